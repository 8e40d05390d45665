// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "core/parallel.hpp"
#include "field/edit/observed_at.hpp"
#include "field/largest_presence.hpp"
#include "field/lattice/slice.hpp"
#include "math/activation.hpp"
#include "splinevox/field/edit.hpp"
#include "splinevox/field/sample.hpp"

namespace splinevox {
namespace {

constexpr double kLeastAlpha = 1e-3;  ///< of a voxel that counts as matter
constexpr double kTolerance = 1e-2;  ///< of a voxel, where the place is looked for that shows a canonical one

/// The same motion with no columns of presence.
MotionField without_presence(const MotionField& motion) {
  MotionField out = motion;
  out.presence = false;
  const MotionLayout from(motion), to(out);
  for (std::size_t l = 0; l < motion.levels.size(); ++l) {
    const Channels& old = motion.levels[l];
    out.levels[l] =
        make_channels(old.topology, to.width, std::vector<float>(std::size_t(to.width), 0.0f).data());
    for (std::size_t r = 0; r < old.topology->rows(); ++r) {
      const float* in = old.row(r);
      float* row = out.levels[l].row(r);
      for (int k = 0; k < motion.stored_points(); ++k) {
        if (to.displaces) std::copy_n(in + from.stride * k, 3, row + to.stride * k);
        for (int i = 0; i < kScalars; ++i)
          if (to.scalar[i] >= 0) row[to.stride * k + to.scalar[i]] = in[from.stride * k + from.scalar[i]];
      }
      if (to.rigidity) row[to.rigidity_column] = in[from.rigidity_column];
    }
  }
  if (to.stride == 0) out.levels.clear();
  return out;
}

}  // namespace

void scale_presence(MotionField& motion, float factor) {
  const MotionLayout layout(motion);
  const int presence = layout.scalar[kPresence];
  if (presence < 0) return;
  for (Channels& level : motion.levels)
    for (std::size_t r = 0; r < level.topology->rows(); ++r)
      for (int k = 0; k < motion.stored_points(); ++k) level.row(r)[layout.stride * k + presence] *= factor;
}

void keep_emptied(VoxelModel& model, const std::function<void(MotionField&)>& change) {
  if (!comes_and_goes(model.motion)) return change(model.motion);
  const LargestPresence before(model);
  change(model.motion);
  const LargestPresence after(model);
  Channels& raw = model.radiance.raw;
  const DensityActivation& activation = model.radiance.activation;
  const float spacing = raw.topology->lattice.spacing, empty = raw.row(0)[0],
              least = raw_of_alpha(kLeastAlpha, activation.scale, activation.shift, spacing);
  parallel_for(raw.topology->brick_count(), [&](int index) {
    for (int i = 0; i < kBrickRows; ++i) {
      float& density = raw.row(std::size_t(index + 1) * kBrickRows + std::size_t(i))[0];
      if (density > empty) continue;
      const Vec3 place = raw.topology->position(index + 1, i);
      if (density + before.around(place, spacing) < least)  // nothing was shown here
        density = std::min(density, empty - after.around(place, spacing));
    }
  });
}

void freeze_presence(VoxelModel& model, double time) {
  const FrameSampler sampler(model, time);
  Channels& raw = model.radiance.raw;
  const Topology& t = *raw.topology;
  const double tolerance = kTolerance * double(t.lattice.spacing);
  parallel_for(t.brick_count(), [&](int index) {
    for (int i = 0; i < kBrickRows; ++i) {
      const Vec3 canonical = t.position(index + 1, i);
      const Vec3d target = cast<double>(canonical);
      const Vec3d x = observed_at(
          sampler, target, {target - cast<double>(sampler.warp(canonical).displacement), target}, tolerance);
      raw.row(std::size_t(index + 1) * kBrickRows + i)[0] += sampler.warp(cast<float>(x)).presence;
    }
  });
  model.motion = without_presence(model.motion);
}

}  // namespace splinevox
