// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "splinevox/field/model.hpp"
#include "train/bounds/offset.hpp"
#include "train/learner.hpp"
#include "train/setting.hpp"

namespace splinevox {

/// Canonical rows that are visible in training pictures.
struct Visible {
  std::vector<RowMask> rows;  ///< LearnedRows::visible of the radiance; empty: not kept
  std::int64_t rays = 0;      ///< of usable steps since the rows were begun
};

/// The lattices that are learned: the canonical radiance, and the motion as a sum of levels.
struct Lattices {
  Lattices() = default;
  Lattices(const Setting& setting, const TimeMap& time_map, const Box& box);

  VoxelModel model;  ///< motion.levels: the sum of `levels`, see sum_levels
  Learner radiance;
  Visible visible;
  std::vector<Channels> levels;  ///< active motion levels, coarse to fine; the learned parameters
  std::vector<Learner> level_learners;
  CurvePrior curves;         ///< of each level
  StaticPrior static_prior;  ///< of their sum
  bool may_spoil = false;    ///< StepModel::may_spoil

  /// Longest edge of the box, scene units: the unit of lr_control.
  float edge() const { return model.box.longest_edge(); }

  void start_radiance(const Setting& setting, const BitGrid& cells);
  /// Puts the radiance on another lattice, in bricks near the cells, and forgets its moments. Density is as
  /// steep there as RadianceConfig::steepen says.
  /// @param cells   along the longest edge. @param offset  at which the old lattice is resampled, if any
  /// @param prune   drop the bricks in which nothing is left
  void refine_radiance(const Setting& setting, int cells, const BitGrid& matter,
                       const std::optional<Offset>& offset, bool prune);
  /// Harmonics up to an order from now on, those that join as 0 in rows as wide as it takes: every picture
  /// stays as it is, and moments are kept.
  void add_harmonics(int order);
  /// One more motion level, in bricks near the cells, all zero.
  void add_level(int cells, const BitGrid& near);
  /// Puts a motion on the levels' lattices of the box, in bricks near the cells. They keep it up to sampling
  /// it, and forget their moments.
  /// @param cells  along the longest edge, of each level
  void put_on_levels(const std::vector<int>& cells, const Channels& sum, const BitGrid& near);
  /// More control points, the curves staying as they are. Moments are forgotten.
  void refine_curves(int points);

  /// Makes the sum of the levels, in which what is frozen is zero. @param moving  MovingPart::rows
  void sum_levels(std::span<const RowMask> moving);
  void forget_sum() { model.motion.levels.clear(); }
  /// Begins anew to collect visible rows. None are kept in a run that never empties: total variation then
  /// takes all rows.
  void forget_visible(const Setting& setting);
};

}  // namespace splinevox
