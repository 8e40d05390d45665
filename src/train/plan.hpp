// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <string_view>
#include <vector>

#include "train/volume.hpp"

namespace splinevox {

/// What a run changes on its way, and how often it has: the events in plan.cpp, each of which happens where
/// the progress reaches one of its starts in the configuration.
class Plan {
 public:
  /// Events in the order in which they happen, for a progress that asks for them to have happened more often
  /// than they have.
  std::vector<std::string_view> due(const Config& config, double progress) const;

  /// Runs the events that are due. True if a lattice changed, or bricks were pruned.
  /// @param begun  steps have been made, so the volume says something of where matter is
  bool carry_out(const Setting& setting, double progress, bool begun, const TimeWindow& window,
                 Volume& volume);
  /// Rates, priors and summed motion for the lattices as they are now.
  void fit(const Setting& setting, Volume& volume) const;

  /// From here on no radiance lattice begins beyond this many.
  void limit_stages(int most) { most_stages_ = most; }

  void archive(Archive& a);
  /// Whether a restored plan can be one of this configuration that has come to this volume.
  bool fits(const Config& config, const Lattices& lattices) const;

  /// Times that events have happened.
  struct Counts {
    int emptied = 0;    ///< hidden matter was to be emptied
    int stages = 0;     ///< a radiance lattice began
    int harmonics = 0;  ///< harmonics joined
    int levels = 0;     ///< a motion level began
    int curves = 0;     ///< curves got more control points: spans were halved, or degrees elevated
  };
  const Counts& counts() const { return counts_; }

 private:
  Counts counts_;
  int most_stages_ = std::numeric_limits<int>::max();
};

}  // namespace splinevox
