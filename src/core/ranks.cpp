// SPDX-License-Identifier: Apache-2.0
#include "core/ranks.hpp"

#include <algorithm>

namespace splinevox {

void sum_over_ranks(Ranks& ranks, std::span<double> numbers) {
  const std::vector<double> all = ranks.gather(numbers);
  std::fill(numbers.begin(), numbers.end(), 0.0);
  for (std::size_t i = 0; i < all.size(); ++i) numbers[i % numbers.size()] += all[i];
}

void sum_over_ranks(Ranks& ranks, std::span<float> numbers) {
  const std::size_t count = std::size_t(ranks.count()), rank = std::size_t(ranks.rank());
  std::vector<std::size_t> ends(count + 1);
  for (std::size_t k = 0; k <= count; ++k) ends[k] = ranks.share_begin(numbers.size(), int(k));
  const std::size_t own = ends[rank], piece = ends[rank + 1] - own;
  std::vector<float> pieces(piece * count);
  ranks.exchange(numbers, ends, pieces);
  std::copy_n(pieces.data(), piece, numbers.data() + own);
  for (std::size_t k = 1; k < count; ++k)
    for (std::size_t i = 0; i < piece; ++i) numbers[own + i] += pieces[k * piece + i];
  ranks.collect(numbers, ends);
}

}  // namespace splinevox
