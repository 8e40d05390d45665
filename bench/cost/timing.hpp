// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "record.hpp"

namespace splinevox::cost {

/// Median of the values with its bootstrap 95% interval (percentile method, 2000 draws, fixed seed).
Figure median_of(std::vector<double> values);

/// One of several pieces of work that are timed against each other.
struct Candidate {
  std::string name;
  std::function<void()> run;
};

struct Timed {
  Figure seconds;       ///< of one run
  Figure ratio;         ///< time over the first candidate's of the same round
  double instructions;  ///< of one run in user mode, 0 where the kernel or the machine does not count them
};

/// Times every candidate once per round, in an order drawn anew each round, so that slow moments of the
/// machine fall on all alike.
std::vector<Timed> interleave(const std::vector<Candidate>& candidates, int rounds);

}  // namespace splinevox::cost
