// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <doctest/doctest.h>

#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "program.hpp"
#include "splinevox/core/camera.hpp"
#include "splinevox/data/image_io.hpp"

/// The page of `view` in a headless browser.
namespace splinevox::test {

using Json = nlohmann::json;

inline std::string browser() {
  for (const char* name : {"chromium", "chromium-browser", "google-chrome"})
    if (const std::string found = found_in_path(name); !found.empty()) return found;
  return "";
}

inline Bytes unbase64(const std::string& text) {
  Bytes out;
  std::uint32_t bits = 0;
  int count = 0;
  for (const char c : text) {
    const int v = c >= 'A' && c <= 'Z'   ? c - 'A'
                  : c >= 'a' && c <= 'z' ? c - 'a' + 26
                  : c >= '0' && c <= '9' ? c - '0' + 52
                  : c == '+'             ? 62
                  : c == '/'             ? 63
                                         : -1;
    if (v < 0) continue;
    bits = bits << 6 | std::uint32_t(v);
    count += 6;
    if (count >= 8) {
      count -= 8;
      out.push_back(std::uint8_t(bits >> count));
    }
  }
  return out;
}

/// A run, its page, and what a browser found on it.
struct Page {
  TempFolder temp;
  std::string text;
  Json header, result;
  std::string console, run = "run";

  std::string path(const std::string& name) const { return temp.str() + "/" + name; }

  /// @param editing  of the trained run; empty: it is shown as it is. @param look  of the scene
  void make(const std::vector<std::string>& training, const std::vector<std::string>& editing = {},
            const std::vector<std::string>& look = {}) {
    std::vector<std::string> words{"synth", "ball", "--out", path("scene"), "--size", "32", "--frames", "12"};
    words.insert(words.end(), look.begin(), look.end());
    REQUIRE(program(words).code == 0);
    words = {"train",
             path("scene"),
             "--out",
             path("run"),
             "--preset",
             "draft",
             "--max-steps",
             "60",
             "--quiet",
             "--set",
             "grid.radiance=16,24,32",
             "--set",
             "grid.motion=4,8",
             "--set",
             "grid.motion_start=0,0.2",
             "--set",
             "sampling.rays=512",
             "--set",
             "sampling.occupancy_cells=24"};
    words.insert(words.end(), training.begin(), training.end());
    const Ended train = program(words);
    CAPTURE(train.err);
    REQUIRE(train.code == 0);
    if (!editing.empty()) {
      words = {"edit", path("run"), "--out", path("edited")};
      words.insert(words.end(), editing.begin(), editing.end());
      const Ended edit = program(words);
      CAPTURE(edit.err);
      REQUIRE(edit.code == 0);
      run = "edited";
    }
    const Ended view =
        program({"view", path(run), "--out", path("page.html"), "--views", "3", "--split", "train"});
    CAPTURE(view.err);
    REQUIRE(view.code == 0);
    text = slurp(path("page.html"));
    header = Json::parse(between(text, "id=\"header\">", "</script>"));
  }

  /// Opens the page with a script behind it, which may await, that fills the object `result`.
  void open(const std::string& script, const std::string& window = "800,800") {
    write_text(path("checked.html"), text +
                                         "<script>splinevox.then(async app => {\n  const result = {problem: "
                                         "document.getElementById('problem').textContent};\n" +
                                         script +
                                         "\n  const node = document.createElement('pre');\n  node.id = "
                                         "'result';\n  node.textContent = JSON.stringify(result);\n"
                                         "  document.body.append(node);\n});</script>");
    // The browser's time races past a slow machine: one that saw no end of the script is given more.
    Ended e;
    std::string found;
    for (int budget = 10000; found.empty() && budget <= 160000; budget *= 4) {
      e = Started({"timeout", "120", browser(), "--headless=new", "--no-sandbox", "--use-gl=angle",
                   "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--enable-logging=stderr",
                   "--window-size=" + window, "--user-data-dir=" + path("profile"),
                   "--virtual-time-budget=" + std::to_string(budget), "--dump-dom",
                   "file://" + path("checked.html")})
              .wait();
      found = between(e.out, "<pre id=\"result\">", "</pre>");
    }
    std::stringstream log(e.err);
    for (std::string line; std::getline(log, line);)
      // Reading pixels back, which only this test does so often, is slow, and the driver says so.
      if (contains(line, "CONSOLE") && !contains(line, "GPU stall due to ReadPixels")) console += line + "\n";
    CAPTURE(console);
    REQUIRE_FALSE(found.empty());
    result = Json::parse(found);
  }

  Image picture(const std::string& data) const {
    write_bytes(path("picture.png"), unbase64(data.substr(data.find(',') + 1)));
    return composite(read_png(path("picture.png")), {1, 1, 1});
  }
  Camera camera(int view) const {
    const Json& j = header["views"][view]["camera"];
    Camera c{j["width"], j["height"], j["fx"], j["fy"],
             j["cx"],    j["cy"],     {},      {j["position"][0], j["position"][1], j["position"][2]}};
    for (int a = 0; a < 3; ++a) c.axes[a] = {j["axes"][a][0], j["axes"][a][1], j["axes"][a][2]};
    return c;
  }
};

}  // namespace splinevox::test
