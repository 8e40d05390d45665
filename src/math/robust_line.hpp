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

/// A rising line through points of which some are wrong: the reduced major axis, whose slope is the ratio of
/// the spreads of y and x. Least squares would take all that is off for an error of y, and make the line too
/// flat where y is drawn to its mean. Errors are shares of the line's own value, and one beyond `width`
/// weighs less; the weights are made anew from the line, sixteen times. Weights from y would draw it to where
/// y is too small by chance. None: fewer than eight points, or x and y hardly go together.
/// @param x  and @param y  as many; y > 0
inline std::optional<Line> robust_line(std::span<const double> x, std::span<const double> y, double width) {
  constexpr std::size_t kFewest = 8;
  constexpr int kRounds = 16;
  constexpr double kLeast = 0.1;     // of the mean, that a line's value counts as
  constexpr double kTogether = 0.3;  // squared correlation
  if (x.size() < kFewest) return {};
  std::optional<Line> line;
  double least = 0;
  for (int round = 0; round < kRounds; ++round) {
    double all = 0, mean_x = 0, mean_y = 0, xx = 0, xy = 0, yy = 0;
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
      yy += w * (y[i] - mean_y) * (y[i] - mean_y);
    }
    const bool last = round + 1 == kRounds;
    if (!(xy > 0) || !(xx > 0) || (last && xy * xy < kTogether * xx * yy)) return {};
    const double slope = std::sqrt(yy / xx);
    line = Line{slope, mean_y - slope * mean_x};
    if (round == 0) least = kLeast * mean_y;
  }
  return line;
}

}  // namespace splinevox
