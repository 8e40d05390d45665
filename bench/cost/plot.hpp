// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

/// What the diagrams share.
namespace splinevox::cost {

inline constexpr double kWidth = 760, kHeight = 460, kLeft = 80, kRight = 190, kTop = 40, kBottom = 56;
inline constexpr const char* kColors[] = {"#1b6ca8", "#d1495b", "#3a7d44", "#8a5a83", "#c98b2b", "#2a9d8f", "#6d597a", "#555555", "#b56576", "#4d7ea8"};

inline std::string escape(const std::string& text) {
  std::string out;
  for (const char c : text) out += c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '&' ? "&amp;" : std::string(1, c);
  return out;
}

/// One axis from the least to the most value, as picture coordinates.
struct Axis {
  double lo, hi, from, to;
  bool log;
  Axis(double least, double most, double a, double b, bool logarithmic = true) : lo(least), hi(most), from(a), to(b), log(logarithmic) {
    if (log) lo = std::log10(lo), hi = std::log10(hi);
    const double pad = std::max(0.04 * (hi - lo), (log ? 0.15 : 0.5) - 0.5 * (hi - lo));
    lo -= pad, hi += pad;
  }
  double at(double v) const { return from + ((log ? std::log10(v) : v) - lo) / (hi - lo) * (to - from); }
  /// 1, 2, 5 times powers of ten on short logarithmic axes, powers on long ones; steps of 1, 2 or 5 on linear ones.
  std::vector<double> ticks() const {
    std::vector<double> out;
    if (log) {
      for (int e = int(std::floor(lo)); e <= int(std::ceil(hi)); ++e)
        for (const double m : hi - lo > 3 ? std::vector<double>{1} : std::vector<double>{1, 2, 5})
          if (const double v = m * std::pow(10, e); std::log10(v) > lo && std::log10(v) < hi) out.push_back(v);
      return out;
    }
    const double step = hi - lo > 20 ? 5 : hi - lo > 8 ? 2 : 1;
    for (double v = std::ceil(lo / step) * step; v < hi; v += step) out.push_back(v);
    return out;
  }
};

}  // namespace splinevox::cost
