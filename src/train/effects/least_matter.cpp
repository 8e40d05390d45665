// SPDX-License-Identifier: Apache-2.0
#include "train/effects/least_matter.hpp"

#include <algorithm>
#include <vector>

#include "core/parallel.hpp"
#include "math/composite.hpp"
#include "render/occupancy.hpp"
#include "splinevox/field/sample.hpp"

namespace splinevox {
namespace {

constexpr int kMatterCells = 48;  // along the longest edge
constexpr int kMoments = 12, kInARow = 3;
constexpr float kChange = 0.5f;  // of a cell's alpha

}  // namespace

double least_matter(const VoxelModel& model) {
  const BitGrid grid(model.box, kMatterCells);
  std::vector<std::vector<float>> alpha(kMoments, std::vector<float>(grid.cells()));
  parallel_for(kMoments, [&](int m) {
    const FrameSampler sampler(model, double(m) / (kMoments - 1));
    for (std::size_t c = 0; c < grid.cells(); ++c)
      alpha[std::size_t(m)][c] = opacity_of(sampler.density(grid.center(grid.cell_at(c))), grid.cell).alpha;
  });
  std::vector<double> matter(kMoments, 0.0);
  for (std::size_t c = 0; c < grid.cells(); ++c) {
    const auto [lo, hi] = std::minmax_element(alpha.begin(), alpha.end(),
                                              [&](const auto& a, const auto& b) { return a[c] < b[c]; });
    if ((*hi)[c] - (*lo)[c] > kChange)
      for (int m = 0; m < kMoments; ++m) matter[std::size_t(m)] += alpha[std::size_t(m)][c];
  }
  double least = 0, most = 0;
  for (int m = 0; m + kInARow <= kMoments; ++m) {
    double sum = 0;
    for (int k = 0; k < kInARow; ++k) sum += matter[std::size_t(m + k)];
    least = m == 0 ? sum : std::min(least, sum);
    most = std::max(most, sum);
  }
  return most > 0 ? least / most : 1;
}

}  // namespace splinevox
