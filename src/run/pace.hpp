// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "splinevox/train/config.hpp"
#include "splinevox/train/trainer.hpp"

namespace splinevox::run {

/// How long the rest of a run takes.
///
/// A run by the clock ends when its seconds are spent. A run that counts steps is told by the pace of late
/// and by what is still to come: steps get dearer with their rays, which grow evenly over the run, and with
/// each finer radiance lattice. The cost of a step is taken as rays times (cells along an edge + 40). Over
/// 107 runs the median of the forecast is 0.97 to 1.4 of what the rest took, from a tenth of the run on; at
/// an even pace it is 0.3 at first, and 0.5 after three fifths (docs/experiments/speed.md).
class Pace {
 public:
  Pace() = default;  ///< of a run whose steps cost alike
  explicit Pace(const Config& config);

  /// What came before the first one of this call is not the steps' time.
  void add(const StepReport& report);
  /// Seconds; none: too little is done to tell.
  std::optional<double> left() const;

 private:
  struct Stage {
    double start, cells;
  };
  struct Mark {
    double progress, seconds;
  };
  double cost(double from, double to) const;

  bool by_clock_ = false;
  double growth_ = 1;  ///< rays of the last step for one of the first
  std::vector<Stage> stages_ = {{0, 0}};
  std::vector<Mark> marks_;
};

}  // namespace splinevox::run
