// SPDX-License-Identifier: Apache-2.0
#include "backend/host/sum_ranks.hpp"

#include <algorithm>
#include <atomic>
#include <bit>

#include "core/parallel.hpp"

namespace splinevox {

static_assert(sizeof(RowMask) == kBrick * sizeof(std::uint64_t), "masks are sent as they lie in memory");

PassResult sum_over_ranks(Ranks& ranks, const PassResult& mine) {
  double numbers[] = {mine.squared_error,      mine.motion_loss, double(mine.samples),
                      mine.usable ? 0.0 : 1.0, mine.depth_loss,  mine.track_loss};
  sum_over_ranks(ranks, std::span<double>(numbers));
  PassResult sum = mine;
  sum.squared_error = numbers[0];
  sum.motion_loss = numbers[1];
  sum.samples = std::int64_t(numbers[2]);
  sum.usable = numbers[3] == 0;
  sum.depth_loss = numbers[4];
  sum.track_loss = numbers[5];
  return sum;
}

void sum_over_ranks(Ranks& ranks, StepSums& sums) {
  if (!sums.errors.empty())
    sum_over_ranks(ranks, std::span<float>(&sums.errors[0].x, 3 * sums.errors.size()));
  if (!sums.slopes.empty()) sum_over_ranks(ranks, std::span<double>(sums.slopes));
}

bool sum_over_ranks(Ranks& ranks, Gradient& gradient) {
  ranks.merge({gradient.touched.data()->word, gradient.touched.size() * kBrick});
  const int bricks = int(gradient.touched.size());
  const std::size_t width = std::size_t(gradient.values.width);
  std::vector<std::size_t> start(std::size_t(bricks) + 1, 0);
  for (int b = 0; b < bricks; ++b) {
    std::size_t rows = 0;
    for (const std::uint64_t word : gradient.touched[b].word) rows += std::size_t(std::popcount(word));
    start[b + 1] = start[b] + rows;
  }
  const auto each_row = [&](int b, auto&& visit) {
    std::size_t at = start[b];
    gradient.touched[b].for_each(
        [&](int i) { visit(gradient.values.row(std::size_t(b) * kBrickRows + i), width * at++); });
  };
  AlignedVector<float> all(start.back() * width);
  parallel_for(bricks, [&](int b) {
    each_row(b, [&](const float* row, std::size_t at) { std::copy_n(row, width, all.data() + at); });
  });

  sum_over_ranks(ranks, std::span<float>(all));

  std::atomic<bool> good = true;
  parallel_for(bricks, [&](int b) {
    each_row(b, [&](float* row, std::size_t at) { std::copy_n(all.data() + at, width, row); });
    if (!usable(gradient, b)) good = false;
  });
  return good;
}

}  // namespace splinevox
