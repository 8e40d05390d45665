// SPDX-License-Identifier: Apache-2.0
#include "splinevox/train/ranks.hpp"

#include <algorithm>
#include <atomic>
#include <bit>

#include "splinevox/core/parallel.hpp"

namespace splinevox {

static_assert(sizeof(RowMask) == kBrick * sizeof(std::uint64_t), "masks are sent as they lie in memory");

void keep_own_share(const Ranks& ranks, Batch& batch) {
  std::vector<Batch::Task> own;
  for (std::size_t t = std::size_t(ranks.rank()); t < batch.tasks.size(); t += std::size_t(ranks.count())) own.push_back(batch.tasks[t]);
  batch.tasks = std::move(own);
}

void sum_over_ranks(Ranks& ranks, std::span<double> numbers) {
  const std::vector<double> all = ranks.gather(numbers);
  std::fill(numbers.begin(), numbers.end(), 0.0);
  for (std::size_t i = 0; i < all.size(); ++i) numbers[i % numbers.size()] += all[i];
}

PassResult sum_over_ranks(Ranks& ranks, const PassResult& mine) {
  double numbers[] = {mine.squared_error, mine.motion_loss, double(mine.samples), double(mine.visited), mine.usable ? 0.0 : 1.0};
  sum_over_ranks(ranks, std::span<double>(numbers));
  PassResult sum = mine;
  sum.squared_error = numbers[0], sum.motion_loss = numbers[1];
  sum.samples = std::int64_t(numbers[2]), sum.visited = std::int64_t(numbers[3]);
  sum.usable = numbers[4] == 0;
  return sum;
}

bool sum_over_ranks(Ranks& ranks, Gradient& gradient) {
  ranks.merge({gradient.touched.data()->word, gradient.touched.size() * kBrick});
  if (!gradient.seen.empty()) ranks.merge({gradient.seen.data()->word, gradient.seen.size() * kBrick});
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
    gradient.touched[b].for_each([&](int i) { visit(gradient.values.row(std::size_t(b) * kBrickRows + i), width * at++); });
  };
  AlignedVector<float> all(start.back() * width);
  parallel_for(bricks, [&](int b) { each_row(b, [&](const float* row, std::size_t at) { std::copy_n(row, width, all.data() + at); }); });

  // Each rank adds up one piece, so that nobody's links carry more than twice the gradient, however many there are.
  std::vector<std::size_t> ends(std::size_t(ranks.count()) + 1);
  for (int k = 0; k <= ranks.count(); ++k) ends[k] = start.back() * std::size_t(k) / std::size_t(ranks.count()) * width;
  const std::size_t own = ends[ranks.rank()], piece = ends[ranks.rank() + 1] - own;
  AlignedVector<float> pieces(piece * std::size_t(ranks.count()));
  ranks.exchange(all, ends, pieces);
  std::copy_n(pieces.data(), piece, all.data() + own);
  for (int k = 1; k < ranks.count(); ++k)
    for (std::size_t i = 0; i < piece; ++i) all[own + i] += pieces[std::size_t(k) * piece + i];
  ranks.collect(all, ends);

  std::atomic<bool> good = true;
  parallel_for(bricks, [&](int b) {
    each_row(b, [&](float* row, std::size_t at) { std::copy_n(all.data() + at, width, row); });
    if (!usable(gradient, b)) good = false;
  });
  return good;
}

}  // namespace splinevox
