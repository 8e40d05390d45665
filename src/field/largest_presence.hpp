// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "field/cells.hpp"
#include "splinevox/field/model.hpp"

/// Presence (math/presence.hpp) belongs to observed places and times, raw density to canonical places. What a
/// canonical place shows when it shows most is its raw density and the largest presence that looks it up.
namespace splinevox {

/// Whether a model's matter may come and go.
inline bool comes_and_goes(const MotionField& motion) { return motion.presence && !motion.levels.empty(); }

/// A bound of the presence at any time around observed cells: a curve stays below the largest point of its
/// control polygon. At least 0.
/// @pre comes_and_goes(motion), at most one level
CellValues most_presence(const MotionField& motion, const CellGrid& cells);

/// The largest presence with which canonical places are looked up at any of some times, cell by cell. A
/// canonical place whose raw density with this stays below a threshold never holds matter: with raw density
/// alone, which is the mean over time, matter that is there part of the time would count as none.
class LargestPresence {
 public:
  static constexpr int kCells = 64;

  /// @param cells  along the longest edge of the model's box
  /// @pre at most one motion level
  explicit LargestPresence(const VoxelModel& model, int cells = kCells);

  /// At a canonical place and up to `reach` to each side of it, scene units; at least 0, which the mean over
  /// time has. 0 everywhere if nothing comes or goes.
  float around(const Vec3& canonical, float reach = 0) const;

  /// Whether matter comes and goes at all.
  bool any() const { return !most_.values.empty(); }
  /// Cell by cell. No values: 0 everywhere.
  const CellValues& cells() const { return most_; }

 private:
  CellValues most_;
};

}  // namespace splinevox
