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
  std::string name;
  std::vector<std::pair<double, double>> points;  ///< seconds, dB
};

Curve read_curve(const std::string& run) {
  Curve c{std::filesystem::path(run).filename().string(), {}};
  std::ifstream in(run + "/metrics.jsonl");
  for (std::string line; std::getline(in, line);) {
    const auto j = nlohmann::json::parse(line, nullptr, false);
    if (j.is_object() && j.contains("held_view") && j["held_psnr"].is_number() && j["seconds"] > 0) c.points.emplace_back(j["seconds"], j["held_psnr"]);
  }
  if (c.points.empty()) fail({run, "this run has measured no held view", "metrics.jsonl with 'held_psnr'", "", ""});
  return c;
}

}  // namespace

std::string curves(const std::vector<std::string>& runs) {
  std::vector<Curve> all;
  double t0 = 1e300, t1 = 0, p0 = 1e300, p1 = 0;
  for (const std::string& run : runs) {
    all.push_back(read_curve(run));
    for (const auto& [t, p] : all.back().points) t0 = std::min(t0, t), t1 = std::max(t1, t), p0 = std::min(p0, p), p1 = std::max(p1, p);
  }
  std::string shared = all.front().name;  // what all names begin with says nothing
  for (const Curve& c : all) shared.resize(std::size_t(std::mismatch(shared.begin(), shared.end(), c.name.begin(), c.name.end()).first - shared.begin()));
  if (all.size() > 1)
    for (Curve& c : all) c.name.erase(0, shared.size());
  const Axis x(t0, t1, kLeft, kWidth - kRight), y(p0, p1, kHeight - kBottom, kTop, false);
  std::string svg = open_diagram("PSNR of a held view against seconds of training", x, y, [](double v) { return fmt::format("{:g} s", v); },
                                 [](double v) { return fmt::format("{:g} dB", v); });
  double row = kTop + 8;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const char* color = kColors[i % std::size(kColors)];
    std::string line;
    for (const auto& [t, p] : all[i].points) line += fmt::format("{}{:.1f} {:.1f}", line.empty() ? "M" : " L", x.at(t), y.at(p));
    svg += fmt::format("<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"2\"/>\n", line, color);
    svg += fmt::format("<line x1=\"{}\" x2=\"{}\" y1=\"{}\" y2=\"{}\" stroke=\"{}\" stroke-width=\"3\"/><text x=\"{}\" y=\"{}\">{}</text>\n", kWidth - kRight + 10,
                       kWidth - kRight + 22, row - 4, row - 4, color, kWidth - kRight + 28, row, escape(all[i].name.substr(0, 26)));
    row += 18;
  }
  return svg + "</svg>\n";
}

}  // namespace splinevox::cost
