// SPDX-License-Identifier: Apache-2.0
// Runs and exports that come from somebody else.
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <random>

#include "torture/folder_files.hpp"
#include "torture/scene.hpp"
#include "torture/trial.hpp"

namespace splinevox::torture {
namespace fs = std::filesystem;

namespace {

constexpr double kPatience = 60;  // seconds a verb on a small run may take

/// A run and an export of it, whole, to be copied and spoiled; and something of the user's beside them.
class Stage {
 public:
  explicit Stage(const Options& o, const char* log_name) : scene(o), log(o.out + "/" + log_name), o_(o) {
    std::vector<std::string> words = scene.export_words();
    words.insert(words.end(), {"--out", scene.path("export")});
    if (Process(words, log).wait() != 0) throw std::runtime_error("no export to spoil, see " + log);
    fs::create_directories(home());
    std::ofstream(home() + "/bashrc") << "alias ls=ls\n";
    before_ = files_of(home());
  }
  std::string home() const { return scene.path("home"); }
  std::string run() const { return scene.path("copy_run"); }
  std::string exported() const { return scene.path("copy_export"); }

  /// Fresh copies.
  void set_up() {
    for (const auto& [from, to] : {std::pair{scene.path("run"), run()}, {scene.path("export"), exported()}}) {
      fs::remove_all(to);
      fs::copy(from, to, fs::copy_options::recursive);
    }
  }
  bool home_is_untouched() const {
    const auto now = files_of(home());
    return now == before_;
  }
  void restore_home() {
    fs::remove_all(home());
    fs::create_directories(home());
    std::ofstream(home() + "/bashrc") << "alias ls=ls\n";
  }

  /// Words of every verb that reads or writes the copies.
  std::vector<std::vector<std::string>> verbs() const {
    std::vector<std::string> train = scene.train_words(), frames = scene.export_words();
    train.insert(train.end(), {"--out", run(), "--resume"});
    frames[2] = run();
    frames.insert(frames.end(), {"--out", exported()});
    const std::string p = o_.program;
    return {train,
            frames,
            {p, "info", run()},
            {p, "verify", run()},
            {p, "verify", exported()},
            {p, "eval", run()},
            {p, "report", run(), "--out", run() + "/report.html"},
            {p, "view", run(), "--out", run() + "/view.html"},
            {p, "edit", run(), "--reverse", "--quiet", "--out", scene.path("edited")},
            {p, "render", run(), "--camera", "orbit", "--times", "0", "--size", "16", "--out",
             run() + "/preview"}};
  }

  Scene scene;
  std::string log;

 private:
  const Options& o_;
  std::map<std::string, FileDigest> before_;
};

std::vector<std::string> names_in(const std::string& folder) {
  std::vector<std::string> out;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    out.push_back(fs::relative(entry.path(), folder));
  for (const char* extra : {"preview", "report.html", "view.html", "metrics.jsonl", "checkpoint.bin.prev",
                            "effects.json", "manifest.partial.json", "load_in_blender.py", "edit.json"})
    out.emplace_back(extra);
  std::sort(out.begin(), out.end());
  return out;
}

template <class Random>
const std::string& one_of(const std::vector<std::string>& list, Random& random) {
  return list[random() % list.size()];
}

std::string spoken(const std::vector<std::string>& words) {
  std::string out;
  for (std::size_t i = 1; i < words.size() && i < 4; ++i) out += " " + words[i];
  return out;
}

}  // namespace

Line try_links(const Options& o, double seconds) {
  Stage stage(o, "links.log");
  const Clock::time_point begin = Clock::now();
  Line line{"links", "runs and exports"};
  std::mt19937_64 random(o.seed);
  std::uint64_t refused = 0;
  while (since(begin) < seconds) {
    stage.set_up();
    fs::remove_all(stage.scene.path("edited"));
    const std::string folder = random() % 3 ? stage.run() : stage.exported();
    const std::string name = one_of(names_in(folder), random), at = folder + "/" + name;
    const std::vector<std::string> targets = {stage.home() + "/bashrc",
                                              stage.home() + "/made",
                                              stage.home(),
                                              "../home/bashrc",
                                              "../home/new",
                                              "/dev/null",
                                              "/proc/self/environ",
                                              at};
    const std::string& target = one_of(targets, random);
    fs::remove_all(at);
    std::error_code error;
    fs::create_symlink(target, at, error);
    if (error) continue;
    const auto verbs = stage.verbs();
    const std::vector<std::string>& words = verbs[random() % verbs.size()];
    const int code = Process(words, stage.log).wait(kPatience);
    ++line.tried;
    refused += code == 2;
    const bool wrote = !stage.home_is_untouched();
    line.crashes += code > 128 && code != 130;
    line.hangs += code < 0;
    line.lost += wrote;
    if (wrote) stage.restore_home();
    if (wrote || code < 0 || code > 128)
      line.note = fmt::format("{} with {} -> {}: code {}{}; ", spoken(words), name, target, code,
                              wrote ? ", wrote elsewhere" : "");
  }
  line.seconds = since(begin);
  line.note += fmt::format("{} refused", refused);
  return line;
}

Line try_siblings(const Options& o, double seconds) {
  Stage stage(o, "siblings.log");
  const Clock::time_point begin = Clock::now();
  Line line{"siblings", "runs and exports"};
  std::mt19937_64 random(o.seed);
  std::uint64_t refused = 0, taken = 0;
  const std::vector<std::string> kinds = {"pipe",  "folder", "deep",  "type",  "huge",
                                          "empty", "null",   "other", "nines", "repeat"};
  while (since(begin) < seconds) {
    stage.set_up();
    fs::remove_all(stage.scene.path("edited"));
    const std::string folder = random() % 4 ? stage.run() : stage.exported();
    const std::string name = one_of(names_in(folder), random), at = folder + "/" + name,
                      kind = one_of(kinds, random);
    std::string old;
    if (fs::is_regular_file(at)) old = read_file(at);
    fs::remove_all(at);
    const auto put = [&](const std::string& text) { std::ofstream(at, std::ios::binary) << text; };
    if (kind == "pipe") {
      if (::mkfifo(at.c_str(), 0600) != 0) continue;
    } else if (kind == "folder") {
      fs::create_directories(at + "/within");
    } else if (kind == "deep") {
      put(std::string(200'000, random() % 2 ? '[' : '{'));
    } else if (kind == "type") {  // a value of the JSON becomes one of another type
      std::size_t colon = old.find(": ", old.empty() ? 0 : random() % old.size());
      if (colon == std::string::npos) colon = old.find(": ");
      if (colon == std::string::npos) continue;
      const std::size_t end = std::min(old.find_first_of(",\n}", colon), old.size());
      const std::vector<std::string> values = {"[[1]]", "{\"a\": 1}", "\"text\"", "null", "true", "-1e300"};
      put(old.replace(colon + 2, end - colon - 2, one_of(values, random)));
    } else if (kind == "huge") {  // all holes
      put("x");
      if (::truncate(at.c_str(), off_t(1) << 35) != 0) continue;
    } else if (kind == "empty") {
      put("");
    } else if (kind == "null") {
      put(std::string(100'000, '\0'));
    } else if (kind == "other") {  // another file of the run under this name
      const std::string from = folder + "/" + one_of(names_in(folder), random);
      if (!fs::is_regular_file(from)) continue;
      fs::copy_file(from, at);
    } else if (kind == "nines") {
      put("{\"step\": 99999999999999999999999999999, \"seconds\": 1e999, \"version\": 99999999999}\n");
    } else {
      for (int i = 0; i < 50; ++i) old += old.substr(0, 10'000);
      put(old.substr(0, 1 << 20));
    }
    const auto verbs = stage.verbs();
    const std::vector<std::string>& words = verbs[random() % verbs.size()];
    const int code = Process(words, stage.log).wait(kPatience);
    ++line.tried;
    refused += code == 2;
    taken += code == 0;
    line.crashes += code > 128 && code != 130;
    line.hangs += code < 0;
    line.lost += !stage.home_is_untouched();
    if (code >= 0 && code <= 2) continue;
    line.note = fmt::format("{} with {} as {}: code {}; ", spoken(words), name, kind, code);
    fs::copy_file(stage.log, o.out + "/siblings_" + std::to_string(line.tried) + ".log",
                  fs::copy_options::overwrite_existing);
  }
  line.seconds = since(begin);
  line.note += fmt::format("{} refused, {} taken", refused, taken);
  return line;
}

}  // namespace splinevox::torture
