// SPDX-License-Identifier: Apache-2.0
#include "curves.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "plot.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::cost {
namespace {

struct Curve {
  std::vector<std::pair<double, double>> points;  ///< seconds, dB
};

Curve read_curve(const std::string& run) {
  Curve c;
  std::ifstream in(run + "/metrics.jsonl");
  for (std::string line; std::getline(in, line);) {
    const auto j = nlohmann::json::parse(line, nullptr, false);
    if (j.is_object() && j.contains("held_view") && j["held_psnr"].is_number() && j["seconds"] > 0)
      c.points.emplace_back(j["seconds"], j["held_psnr"]);
  }
  if (c.points.empty())
    fail({run, "this run has measured no held-out view", "metrics.jsonl with 'held_psnr'", "", ""});
  return c;
}

/// What tells runs apart: the last part of their paths that is not the same for all (bench/quality.sh has
/// .../SCENE/SEED), without what all those begin with.
std::vector<std::string> short_names(const std::vector<std::string>& runs) {
  namespace fs = std::filesystem;
  std::vector<fs::path> paths;
  for (const std::string& run : runs)
    paths.push_back((fs::absolute(run) / "").lexically_normal().parent_path());
  const auto same_end = [&] {
    return paths.size() > 1 && paths[0].has_relative_path() &&
           std::all_of(paths.begin(), paths.end(),
                       [&](const fs::path& p) { return p.filename() == paths[0].filename(); });
  };
  while (same_end())
    for (fs::path& p : paths) p = p.parent_path();
  std::vector<std::string> names;
  for (const fs::path& p : paths) names.push_back(p.filename().string());
  std::string shared = names.size() > 1 ? names[0] : "";
  for (const std::string& n : names)
    shared.resize(
        std::size_t(std::mismatch(shared.begin(), shared.end(), n.begin(), n.end()).first - shared.begin()));
  for (std::string& n : names) n.erase(0, shared.size());
  return names;
}

}  // namespace

std::string curves(const std::vector<std::string>& runs) {
  std::vector<Curve> all;
  double t0 = 1e300, t1 = 0, p0 = 1e300, p1 = 0;
  for (const std::string& run : runs) {
    all.push_back(read_curve(run));
    for (const auto& [t, p] : all.back().points) {
      t0 = std::min(t0, t);
      t1 = std::max(t1, t);
      p0 = std::min(p0, p);
      p1 = std::max(p1, p);
    }
  }
  const std::vector<std::string> names = short_names(runs);
  const Axis x(t0, t1, kLeft, kWidth - kRight), y(p0, p1, kHeight - kBottom, kTop, false);
  std::string svg = open_diagram(
      "PSNR of a held-out view against seconds of training", x, y,
      [](double v) { return fmt::format("{:g} s", v); }, [](double v) { return fmt::format("{:g} dB", v); });
  double row = kTop + 8;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const char* color = kColors[i % std::size(kColors)];
    std::string line;
    for (const auto& [t, p] : all[i].points)
      line += fmt::format("{}{:.1f} {:.1f}", line.empty() ? "M" : " L", x.at(t), y.at(p));
    svg += fmt::format("<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"2\"/>\n", line, color);
    svg += fmt::format(
        "<line x1=\"{}\" x2=\"{}\" y1=\"{}\" y2=\"{}\" stroke=\"{}\" stroke-width=\"3\"/><text x=\"{}\" "
        "y=\"{}\">{}</text>\n",
        kWidth - kRight + 10, kWidth - kRight + 22, row - 4, row - 4, color, kWidth - kRight + 28, row,
        escape(names[i].substr(0, 26)));
    row += 18;
  }
  return svg + "</svg>\n";
}

}  // namespace splinevox::cost
