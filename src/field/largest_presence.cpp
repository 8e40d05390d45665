// SPDX-License-Identifier: Apache-2.0
#include "field/largest_presence.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <mutex>
#include <utility>

#include "core/parallel.hpp"
#include "field/lattice/slice.hpp"
#include "field/warped_centers.hpp"

namespace splinevox {
namespace {

CellValues looked_up_presence(const VoxelModel& model, const CellGrid& cells) {
  const MotionField& motion = model.motion;
  if (!motion.displaces) return most_presence(motion, cells);
  CellValues out(cells, 0.0f);
  const int times = 3 * motion.points;
  std::mutex mutex;
  parallel_for(times + 1, [&](int i) {
    MotionSlice slice;
    fill_slice(motion, parameter_weights(motion, double(i) / times), slice);
    const WarpedCenters warped(model, slice, cells);
    CellValues now(cells, 0.0f);
    Int3 c;
    for (c.x = 0; c.x < cells.size.x; ++c.x)
      for (c.y = 0; c.y < cells.size.y; ++c.y)
        for (c.z = 0; c.z < cells.size.z; ++c.z) {
          const auto w = warped.at(c);
          now.raise(cells.index(cells.cell_of(w.position)), w.presence);
        }
    const std::lock_guard lock(mutex);  // the largest is the same in any order
    for (std::size_t k = 0; k < now.values.size(); ++k) out.raise(k, now.values[k]);
  });
  return dilate(std::move(out));
}

}  // namespace

CellValues most_presence(const MotionField& motion, const CellGrid& cells) {
  CellValues out(cells, 0.0f);  // where nothing is stored
  const Channels& level = motion.levels.back();
  const Topology& topology = *level.topology;
  const Contraction by(motion);
  const Basis& basis = basis_of(motion.basis);
  const int place = by.layout.scalar[kPresence], stride = by.layout.stride;
  const float per_velocity = 1.0f / (3.0f * float(basis.pieces(motion.points)));  // of a Hermite curve
  for (int b = 1; b <= topology.brick_count(); ++b)
    for (int i = 0; i < kBrickRows; ++i) {
      const float* row = level.row(std::size_t(b) * kBrickRows + i) + place;
      float most = CellValues::kLowest;
      for (int k = 0; k < by.count; ++k) {
        if (!basis.is_place(k)) continue;
        const float beyond = basis.per_node == 1 ? 0.0f : per_velocity * std::abs(row[stride * (k + 1)]);
        most = std::max(most, row[stride * k] + beyond);
      }
      const float mean = by.mean_at(row);
      visit_around(out.grid, topology.position(b, i), topology.lattice.spacing,
                   [&](std::size_t c) { out.raise(c, most - mean); });
    }
  return out;
}

LargestPresence::LargestPresence(const VoxelModel& model, int cells) {
  most_.grid = CellGrid(model.box, cells);
  if (comes_and_goes(model.motion)) most_ = looked_up_presence(model, most_.grid);
}

float LargestPresence::around(const Vec3& canonical, float reach) const {
  if (!any()) return 0;
  float most = 0;
  visit_around(most_.grid, canonical, reach, [&](std::size_t c) { most = std::max(most, most_.values[c]); });
  return most;
}

}  // namespace splinevox
