// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace splinevox {

/// Processes that train one model together: each has all of it, computes its share of every batch, and adds
/// up the others'. What they send each other goes through here; MPI stands behind it in cli/join_ranks.cpp.
/// Every call is made by all ranks, in the same order.
class Ranks {
 public:
  virtual ~Ranks() = default;
  virtual int rank() const = 0;  ///< of this process, 0 .. count() - 1
  virtual int count() const = 0;
  virtual int local()
      const = 0;  ///< of this process among those of its machine, from 0: which of its devices to take
  /// words |= those of every other rank.
  virtual void merge(std::span<std::uint64_t> words) = 0;
  /// What every rank gave, in their order; all give equally many. [count() * mine.size()]
  virtual std::vector<double> gather(std::span<const double> mine) = 0;
  /// Piece k of `mine`, values [ends[k], ends[k + 1]), goes to rank k. @param got  this rank's piece from
  /// every rank, in their order.
  virtual void exchange(std::span<const float> mine, std::span<const std::size_t> ends,
                        std::span<float> got) = 0;
  /// Every rank's own piece of `all` to every rank.
  virtual void collect(std::span<float> all, std::span<const std::size_t> ends) = 0;

  /// A number as rank 0 has it.
  double from_first(double mine) { return gather({&mine, 1})[0]; }
  bool first() const { return rank() == 0; }
  /// Where rank k's even share of n things begins; for k = count() that is n.
  std::size_t share_begin(std::size_t n, int k) const { return n * std::size_t(k) / std::size_t(count()); }

  /// What this rank has sent so far, and what it has spent on sending and waiting.
  struct Traffic {
    std::int64_t bytes = 0;
    double seconds = 0;
  } traffic;
};

/// What all ranks have, added up in the order of the ranks: the same bits on all of them, and on every
/// repetition with as many.
void sum_over_ranks(Ranks& ranks, std::span<double> numbers);
/// Of many numbers each rank adds up one piece, so that nobody's links carry more than twice their bytes,
/// however many ranks there are.
void sum_over_ranks(Ranks& ranks, std::span<float> numbers);

}  // namespace splinevox
