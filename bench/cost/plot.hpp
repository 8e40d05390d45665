// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

/// What the diagrams share.
namespace splinevox::cost {

inline constexpr double kWidth = 760, kHeight = 460, kLeft = 80, kRight = 190, kTop = 40, kBottom = 56;
inline constexpr const char* kColors[] = {"#1b6ca8", "#d1495b", "#3a7d44", "#8a5a83", "#c98b2b",
                                          "#2a9d8f", "#6d597a", "#555555", "#b56576", "#4d7ea8"};

inline std::string escape(const std::string& text) {
  std::string out;
  for (const char c : text)
    out += c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '&' ? "&amp;" : std::string(1, c);
  return out;
}

/// One axis from the least to the most value, as picture coordinates.
struct Axis {
  double lo, hi, from, to;
  bool log;
  Axis(double least, double most, double a, double b, bool logarithmic = true)
      : lo(least), hi(most), from(a), to(b), log(logarithmic) {
    if (log) {
      lo = std::log10(lo);
      hi = std::log10(hi);
    }
    const double pad = std::max(0.04 * (hi - lo), (log ? 0.15 : 0.5) - 0.5 * (hi - lo));
    lo -= pad;
    hi += pad;
  }
  double at(double v) const { return from + ((log ? std::log10(v) : v) - lo) / (hi - lo) * (to - from); }
  /// 1, 2, 5 times powers of ten on short logarithmic axes, powers on long ones; steps of 1, 2 or 5 on linear
  /// ones.
  std::vector<double> ticks() const {
    std::vector<double> out;
    if (log) {
      for (int e = int(std::floor(lo)); e <= int(std::ceil(hi)); ++e)
        for (const double m : hi - lo > 3 ? std::vector<double>{1} : std::vector<double>{1, 2, 5})
          if (const double v = m * std::pow(10, e); std::log10(v) > lo && std::log10(v) < hi)
            out.push_back(v);
      return out;
    }
    const double step = hi - lo > 20 ? 5 : hi - lo > 8 ? 2 : 1;
    for (double v = std::ceil(lo / step) * step; v < hi; v += step) out.push_back(v);
    return out;
  }
};

/// The beginning of a diagram: white ground, title, grid, and the axes' numbers as `name_x` and `name_y`
/// write them. The caller closes it.
template <class NameX, class NameY>
std::string open_diagram(const std::string& title, const Axis& x, const Axis& y, const NameX& name_x,
                         const NameY& name_y) {
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {}\" font-family=\"sans-serif\" "
      "font-size=\"12\">\n"
      "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n<text x=\"{}\" y=\"22\" "
      "font-size=\"15\">{}</text>\n",
      kWidth, kHeight, kLeft, escape(title));
  for (const double v : x.ticks())
    svg += fmt::format(
        "<line x1=\"{0:.1f}\" x2=\"{0:.1f}\" y1=\"{1}\" y2=\"{2}\" stroke=\"#e4e4e4\"/><text x=\"{0:.1f}\" "
        "y=\"{3}\" text-anchor=\"middle\">{4}</text>\n",
        x.at(v), kTop, kHeight - kBottom, kHeight - kBottom + 18, name_x(v));
  for (const double v : y.ticks())
    svg += fmt::format(
        "<line x1=\"{1}\" x2=\"{2}\" y1=\"{0:.1f}\" y2=\"{0:.1f}\" stroke=\"#e4e4e4\"/><text x=\"{3}\" "
        "y=\"{4:.1f}\" text-anchor=\"end\">{5}</text>\n",
        y.at(v), kLeft, kWidth - kRight, kLeft - 6, y.at(v) + 4, name_y(v));
  return svg;
}

}  // namespace splinevox::cost
