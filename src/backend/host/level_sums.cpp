// SPDX-License-Identifier: Apache-2.0
#include "backend/host/level_sums.hpp"

#include <algorithm>

#include "core/parallel.hpp"

namespace splinevox {

const Channels& LevelSums::make(std::span<const Channels* const> levels, std::span<const RowMask> rows) {
  sum_ = levels[0];
  sums_.resize(levels.size() - 1);
  for (std::size_t l = 1; l < levels.size(); ++l) {
    const Channels &fine = *levels[l], &coarse = *sum_;
    Channels& sum = sums_[l - 1];
    if (sum.topology != fine.topology || sum.width != fine.width)
      sum = make_channels(fine.topology, fine.width, std::vector<float>(fine.width, 0.0f).data());
    const bool some = l + 1 == levels.size() && !rows.empty();
    parallel_for(sum.topology->brick_count(), [&](int index) {
      const int b = index + 1;
      const RowMask mask = some ? rows[b] : RowMask::all();
      mask.for_each([&](int i) {
        const std::size_t row = std::size_t(b) * kBrickRows + i;
        std::copy_n(fine.row(row), sum.width, sum.row(row));
      });
      prolong_brick(coarse, sum, b, mask);
    });
    sum_ = &sum;
  }
  return *sum_;
}

}  // namespace splinevox
