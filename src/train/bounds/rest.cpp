// SPDX-License-Identifier: Apache-2.0
// Where motion comes to rest. Of many scenes only a part moves, and what stands still need not pay for that.
// Early in a run it cannot be told: a fit displaces everything, what stands still by a voxel or two, but
// always by the same. Once all of time is trained, the displacement of a place over time tells the two apart;
// then the canonical volume is laid out anew such that the offset is 0, and where nothing else is left motion
// is not stored, read or learned (docs/experiments.md, "At rest").
#include <algorithm>
#include <cstddef>
#include <optional>
#include <utility>

#include "core/parallel.hpp"
#include "math/rigidity.hpp"
#include "train/bounds/seen_motion.hpp"
#include "train/state.hpp"

namespace splinevox {
namespace {

constexpr int kCells = 32;       ///< along the longest edge
constexpr int kFewestTimes = 4;  ///< that show a cell, to know whether it moves
// Over time, as standard deviations. What stands still after a third of a run stays below 0.1 voxel and 2% of
// light; what moves is beyond a voxel or two.
constexpr float kStill = 0.25f;  ///< voxels of motion
constexpr float kSteady =
    0.05f;  ///< of light. Where it is steady its mean is given up as well: colours learn it again
constexpr float kSettled = 0.1f;  ///< of brightness, in the mean error of a cell's rays: beyond it something
                                  ///< changes that is not known yet

}  // namespace

std::optional<Offset> Trainer::State::settle(float voxel) {
  const MotionField& m = model.motion;
  const bool pinned = m.stored_points() < m.points;  // a point that is always zero has no offset to lose
  if (config.motion.rest == 0 || !m.displaces || pinned || levels.empty() || growing()) return {};
  collapse_levels({});
  BitGrid cells(model.box, kCells), known = cells;
  const auto changes = [&](const SeenMotion& s) { return s.light > kSteady || s.error > kSettled * unit; };
  const std::vector<SeenMotion> seen = seen_motion(model, train, occupancy, cells);
  double weight = 0, moving = 0;
  std::vector<Vec3> offsets(cells.cells());
  for (std::size_t c = 0; c < cells.cells(); ++c) {
    const SeenMotion& s = seen[c];
    if (s.times < kFewestTimes) continue;
    weight += s.weight;
    if (s.spread > kStill * voxel || changes(s))
      cells.set(c), moving += s.weight;
    else
      known.set(c), offsets[c] = s.offset;
  }
  // What rests already stays at rest, or the canonical volume would be laid out for a motion that it no
  // longer has.
  if (awake.cells() == 0 && !(weight > 0 && moving <= config.motion.rest * weight)) return {};
  const Offset offset(known, offsets);
  // A cell that is shown at few times is still if it is displaced like its surroundings.
  for (std::size_t c = 0; c < cells.cells(); ++c) {
    const SeenMotion& s = seen[c];
    if (s.times == 0 || s.times >= kFewestTimes) continue;
    if (length(s.offset - offset.at(cells.center(cells.cell_at(c)))) > kStill * voxel || changes(s))
      cells.set(c);
  }
  moving_share = weight > 0 ? moving / weight : 1;
  awake = awake.cells() > 0 ? cells : dilate(cells);  // at first, so that the place of what moves may grow

  // What moves finds its matter where the offset has taken it.
  Channels sum = model.motion.levels[0];
  parallel_for(sum.topology->brick_count(), [&](int index) {
    for (int i = 0; i < kBrickRows; ++i) {
      float* row = sum.row(std::size_t(index + 1) * kBrickRows + i);
      const Vec3 x = sum.topology->position(index + 1, i);
      const float r = m.rigidity ? std::max(rigidity_of(row[m.rigidity_column()], m.rigidity_offset).value,
                                            kLeastRigidity)
                                 : 1.0f;
      for (int k = 0; k < m.stored_points(); ++k) {
        if (!basis_of(m.basis).is_place(k)) continue;
        float* p = row + m.stride() * k;
        const Vec3 moved = (1 / r) * (offset.undo(x + r * Vec3{p[0], p[1], p[2]}) - x);
        for (int a = 0; a < 3; ++a) p[a] = moved[a];
      }
    }
  });
  put_on_levels(sum, swept());
  return offset;
}

void Trainer::State::find_awake_rows() {
  awake_rows.clear(), active.reach = {};
  if (awake.cells() == 0 || levels.empty()) return;
  const Topology& t = *levels.back().topology;
  awake_rows = rows_near(t, awake, extent_of_vertex(t.lattice));
  active.reach = reach_of(t, awake_rows, BitGrid(model.box, config.sampling.occupancy_cells));
}

}  // namespace splinevox
