// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstdint>

#include "backend/executor_host.hpp"
#include "core/ranks.hpp"

namespace splinevox {

/// The ranks of a HostExecutor's step.
class HostPeers {
 public:
  explicit HostPeers(Ranks& ranks) : ranks_(ranks) {}
  void sum(HostExecutor&, HostExecutor::Buffer<float>& numbers) {
    sum_over_ranks(ranks_, {numbers.data(), numbers.size()});
  }
  void sum(HostExecutor&, HostExecutor::Buffer<std::int64_t>& numbers) {
    std::vector<double> mine(numbers.size());  // bits, not values: a double has 53 of them
    for (std::size_t i = 0; i < mine.size(); ++i) {
      mine[i] = std::bit_cast<double>(numbers.data()[i]);
      numbers.data()[i] = 0;
    }
    const std::vector<double> all = ranks_.gather(mine);
    for (std::size_t i = 0; i < all.size(); ++i)
      numbers.data()[i % mine.size()] += std::bit_cast<std::int64_t>(all[i]);
  }
  void merge(HostExecutor&, HostExecutor::Buffer<std::uint64_t>& masks) {
    ranks_.merge({masks.data(), masks.size()});
  }

 private:
  Ranks& ranks_;
};

}  // namespace splinevox
