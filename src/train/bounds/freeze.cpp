// SPDX-License-Identifier: Apache-2.0
#include "train/bounds/freeze.hpp"

#include <algorithm>
#include <cstddef>
#include <vector>

#include "core/parallel.hpp"
#include "field/columns.hpp"
#include "math/rigidity.hpp"
#include "train/bounds/seen_motion.hpp"

namespace splinevox {
namespace {

constexpr int kCells = 32;       ///< along the longest edge
constexpr int kFewestTimes = 4;  ///< at which a cell is visible, to know whether it moves
// Over time, as standard deviations. After a third of a run static cells stay below 0.1 voxel and 2% of
// light; moving ones are beyond a voxel or two.
constexpr float kStill = 0.25f;  ///< voxels of motion
constexpr float kSteady =
    0.05f;  ///< of light. Where it is steady its mean is given up as well: colours learn it again
constexpr float kThere = 0.5f;  ///< of presence: an alpha that grows or shrinks by half
constexpr float kKnown = 0.1f;  ///< of brightness, in the mean error of a cell's rays: beyond it something
                                ///< changes that is not known yet

/// Takes what moves along: it finds its matter where the offset has taken it.
void follow(const Offset& offset, const MotionField& m, Channels& sum) {
  const MotionLayout layout(m);
  parallel_for(sum.topology->brick_count(), [&](int index) {
    for (int i = 0; i < kBrickRows; ++i) {
      float* row = sum.row(std::size_t(index + 1) * kBrickRows + i);
      const Vec3 x = sum.topology->position(index + 1, i);
      const float r =
          layout.rigidity
              ? std::max(rigidity_of(row[layout.rigidity_column], m.rigidity_offset).value, kLeastRigidity)
              : 1.0f;
      for (int k = 0; k < m.stored_points(); ++k) {
        if (!basis_of(m.basis).is_place(k)) continue;
        float* p = row + layout.stride * k;
        const Vec3 moved = (1 / r) * (offset.undo(x + r * Vec3{p[0], p[1], p[2]}) - x);
        for (int a = 0; a < 3; ++a) p[a] = moved[a];
      }
    }
  });
}

}  // namespace

std::optional<Offset> freeze(const Setting& setting, Volume& volume, const TimeWindow& window, float voxel) {
  const Config& config = setting.config;
  const VoxelModel& model = volume.lattices.model;
  const MotionField& m = model.motion;
  const bool pinned = m.stored_points() < m.points;  // a point that is always zero has no offset to lose
  if (!freezes(config) || volume.moving.proved || !m.displaces || pinned || volume.lattices.levels.empty() ||
      !window.whole)
    return {};
  BitGrid cells(model.box, kCells), known = cells;
  const auto changes = [&](const VisibleMotion& s) {
    return s.light > kSteady || s.presence > kThere || s.error > kKnown * setting.unit;
  };
  const std::vector<VisibleMotion> visible =
      visible_motion(model, setting.train, volume.occupancy.frames, cells, volume.cameras);
  double weight = 0, weight_moving = 0;
  std::vector<Vec3> offsets(cells.cells());
  for (std::size_t c = 0; c < cells.cells(); ++c) {
    const VisibleMotion& s = visible[c];
    if (s.times < kFewestTimes) continue;
    weight += s.weight;
    if (s.spread > kStill * voxel || changes(s)) {
      cells.set(c);
      weight_moving += s.weight;
    } else {
      known.set(c);
      offsets[c] = s.offset;
    }
  }
  // What is frozen stays so, or the canonical volume would be laid out for a motion that it no longer has.
  MovingPart& moving = volume.moving;
  const bool first = moving.cells.cells() == 0;
  if (first && !(weight > 0 && weight_moving <= config.motion.rest * weight)) return {};
  const Offset offset(known, offsets);
  // A cell that is visible at few times is static if it is displaced like its surroundings.
  for (std::size_t c = 0; c < cells.cells(); ++c) {
    const VisibleMotion& s = visible[c];
    if (s.times == 0 || s.times >= kFewestTimes) continue;
    if (length(s.offset - offset.at(cells.center(cells.cell_at(c)))) > kStill * voxel || changes(s))
      cells.set(c);
  }
  moving.share = weight > 0 ? weight_moving / weight : 1;
  moving.cells = first ? dilate(cells) : cells;  // at first, so that the place of what moves may grow

  Channels sum = m.levels[0];
  follow(offset, m, sum);
  volume.lattices.put_on_levels(config.grid.motion, sum, motion_cells(volume, window));
  fit_motion(setting, volume);
  return offset;
}

}  // namespace splinevox
