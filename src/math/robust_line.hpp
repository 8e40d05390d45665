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

/// A line through points of which some are wrong: errors are shares of the line's own value, and one beyond
/// `width` counts as itself, no longer as its square. Least squares with weights that are made anew from the
/// line, sixteen times. Weights from y would draw the line to where y is too small by chance. None: fewer
/// than eight points, all x are much the same, or the line is not above 0 on the mean.
/// @param x  and @param y  as many; y > 0
inline std::optional<Line> robust_line(std::span<const double> x, std::span<const double> y, double width) {
  constexpr std::size_t kFewest = 8;
  constexpr int kRounds = 16;
  constexpr double kSame = 1e-10, kLeast = 0.1;  // of the mean, that a line's value counts as
  if (x.size() < kFewest) return {};
  std::optional<Line> line;
  double least = 0;
  for (int round = 0; round < kRounds; ++round) {
    double all = 0, mean_x = 0, mean_y = 0, xx = 0, xy = 0;
    const auto weight = [&](std::size_t i) {
      if (!line) return 1.0;
      const double value = std::max(line->at(x[i]), least), error = (line->at(x[i]) - y[i]) / (width * value);
      return 1 / (value * value * std::sqrt(1 + error * error));
    };
    for (std::size_t i = 0; i < x.size(); ++i) {
      const double w = weight(i);
      all += w;
      mean_x += w * x[i];
      mean_y += w * y[i];
    }
    mean_x /= all;
    mean_y /= all;
    for (std::size_t i = 0; i < x.size(); ++i) {
      const double w = weight(i);
      xx += w * (x[i] - mean_x) * (x[i] - mean_x);
      xy += w * (x[i] - mean_x) * (y[i] - mean_y);
    }
    if (!(xx > kSame * all * mean_x * mean_x) || !std::isfinite(xy / xx)) return {};
    line = Line{xy / xx, mean_y - xy / xx * mean_x};
    if (round == 0) least = kLeast * mean_y;
  }
  return line;
}

}  // namespace splinevox
