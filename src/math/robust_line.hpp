// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>

namespace splinevox {

/// y = slope x + start.
struct Line {
  double slope = 1, start = 0;
  double at(double x) const { return slope * x + start; }
};

/// The line whose errors, as shares of y, have the least sum of sqrt(1 + (error / width)^2): least squares
/// with weights that are made anew from the errors, sixteen times. None: fewer than eight points, or all x
/// are much the same.
/// @param x  and @param y  as many; y > 0
inline std::optional<Line> robust_line(std::span<const double> x, std::span<const double> y, double width) {
  constexpr std::size_t kFewest = 8;
  constexpr int kRounds = 16;
  if (x.size() < kFewest) return {};
  std::optional<Line> line;
  for (int round = 0; round < kRounds; ++round) {
    double all = 0, mean_x = 0, mean_y = 0;
    const auto weight = [&](std::size_t i) {
      const double of_y = 1 / (y[i] * y[i]);
      if (!line) return of_y;
      const double error = (line->at(x[i]) - y[i]) / (width * y[i]);
      return of_y / std::sqrt(1 + error * error);
    };
    for (std::size_t i = 0; i < x.size(); ++i) {
      const double w = weight(i);
      all += w;
      mean_x += w * x[i];
      mean_y += w * y[i];
    }
    mean_x /= all;
    mean_y /= all;
    double xx = 0, xy = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      const double w = weight(i);
      xx += w * (x[i] - mean_x) * (x[i] - mean_x);
      xy += w * (x[i] - mean_x) * (y[i] - mean_y);
    }
    constexpr double kSame = 1e-10;
    if (!(xx > kSame * all * mean_x * mean_x) || !std::isfinite(xy / xx)) return {};
    line = Line{xy / xx, mean_y - xy / xx * mean_x};
  }
  return line;
}

}  // namespace splinevox
