// SPDX-License-Identifier: Apache-2.0
#include "run/capture/frame_choice.hpp"

#include <algorithm>
#include <cmath>

namespace splinevox::run {

std::vector<FrameGroup> frame_groups(const std::vector<double>& times, double from, double to, int every,
                                     int most) {
  constexpr double kSlack = 1e-6;  // seconds: what a person writes is rounded
  const auto begin = std::lower_bound(times.begin(), times.end(), from - kSlack);
  const int first = int(begin - times.begin()),
            count = int(std::upper_bound(begin, times.end(), to + kSlack) - begin);
  std::vector<FrameGroup> groups;
  if (every > 0) {
    for (int i = 0; i < count; i += every) groups.emplace_back(first + i, first + std::min(i + every, count));
    return groups;
  }
  const int number = most > 0 ? std::min(most, count) : count;
  const auto border = [&](int g) { return first + int(std::int64_t(g) * count / number); };
  for (int g = 0; g < number; ++g) groups.emplace_back(border(g), border(g + 1));
  return groups;
}

std::vector<FrameGroup> frames_at(const std::vector<double>& times, const std::vector<double>& moments) {
  std::vector<FrameGroup> groups;
  for (const double moment : moments) {
    auto at = std::lower_bound(times.begin(), times.end(), moment);
    if (at == times.end() || (at != times.begin() && moment - at[-1] < *at - moment)) --at;
    const int i = int(at - times.begin());
    if (groups.empty() || groups.back().first < i) groups.emplace_back(i, i + 1);
  }
  return groups;
}

double sharpness(std::span<const std::uint8_t> rgb, int width, int height) {
  if (width < 3 || height < 3) return 0;
  std::vector<int> grey(std::size_t(width) * std::size_t(height));  // times 1000
  for (std::size_t p = 0; p < grey.size(); ++p)
    grey[p] = 299 * rgb[3 * p] + 587 * rgb[3 * p + 1] + 114 * rgb[3 * p + 2];
  double sum = 0, squares = 0;
  for (int y = 1; y + 1 < height; ++y)
    for (int x = 1; x + 1 < width; ++x) {
      const int* p = grey.data() + std::size_t(y) * std::size_t(width) + x;
      const double laplacian = (p[-1] + p[1] + p[-width] + p[width] - 4.0 * p[0]) / 1000;
      sum += laplacian;
      squares += laplacian * laplacian;
    }
  const double count = double(width - 2) * double(height - 2), mean = sum / count;
  return squares / count - mean * mean;
}

}  // namespace splinevox::run
