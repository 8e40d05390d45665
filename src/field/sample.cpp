// SPDX-License-Identifier: Apache-2.0
#include "splinevox/field/sample.hpp"

#include "core/simd.hpp"
#include "field/lattice/brick_view.hpp"
#include "field/lattice/gather.hpp"
#include "field/lattice/locate.hpp"
#include "field/lattice/slice.hpp"
#include "math/emission.hpp"
#include "math/presence.hpp"
#include "math/warp.hpp"

namespace splinevox {
namespace {

using Four = Simd<float>::Four;
using Eight = Simd<float>::Eight;

}  // namespace

/// What a sampler looks into.
struct FrameSampler::Views {
  Views(const VoxelModel& m, const BasisWeights<float>& weights, const BasisWeights<float>& weights_dt)
      : model(m), radiance(*m.radiance.raw.topology) {
    if (m.motion.levels.empty()) return;
    position = make_slice(m.motion, weights);
    velocity = make_slice(m.motion, weights_dt);
    motion = BrickView<float>(*position.topology);
  }
  const VoxelModel& model;
  BrickView<float> radiance, motion;
  MotionSlice position, velocity;
};

FrameSampler::FrameSampler(const VoxelModel& model, double time)
    : views_(std::make_shared<const Views>(model, stored_weights(model.motion, time),
                                           stored_weights_dt(model.motion, time))) {}

FrameSampler::FrameSampler(const VoxelModel& model, AtParameter parameter)
    : views_(std::make_shared<const Views>(model, parameter_weights(model.motion, parameter.value),
                                           parameter_weights_dt(model.motion, parameter.value))) {}

FrameSampler::Warp FrameSampler::warp(Vec3 x) const {
  const auto& [model, radiance_view, motion_view, position, velocity] = *views_;
  Warp out{};
  if (!position.topology) return out;
  const Located at = locate(motion_view, x);
  const auto p = gather<Four>(at.rows, at.fraction, position.values.data(), kSliceWidth, 0);
  const auto v = gather<Four>(at.rows, at.fraction, velocity.values.data(), kSliceWidth, 0);
  Activated<float> r{1, 0};
  if (model.motion.rigidity) r = rigidity_of(p.value[3], model.motion.rigidity_offset);
  out.rigidity = r.value;
  if (model.motion.light || model.motion.presence) {  // raw values of 0 change nothing
    const Four scalars = interpolate<Four>(at, position.values.data(), kSliceWidth, kSliceScalars);
    out.light = light_gain(scalars[kLight]).value;
    out.presence = scalars[kPresence];
  }
  out.displacement = displacement_of(p.value, r.value);
  out.velocity_to_canonical = displacement_of(v.value, r.value);
  // grad (r Delta_0) = r grad Delta_0 + Delta_0 (grad r)^T, per lattice unit, hence the factor.
  const float scale = motion_view.inv_spacing;
  const Four* d[3] = {&p.dx, &p.dy, &p.dz};
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 3; ++i)
      out.gradient[i][j] = scale * (r.value * (*d[j])[i] + p.value[i] * r.slope * (*d[j])[3]);
  return out;
}

Vec3 FrameSampler::canonical(Vec3 x) const { return x + warp(x).displacement; }

float FrameSampler::density(Vec3 x) const {
  const Warp w = warp(x);
  return radiance(x + w.displacement, w.presence).density;
}

FrameSampler::Radiance FrameSampler::radiance(Vec3 x, float presence) const {
  const RadianceField& field = views_->model.radiance;
  const Located at = locate(views_->radiance, x);
  Radiance out{};
  bool stored = false;
  for (const std::int32_t row : at.rows.row) stored |= row >= kBrickRows;
  if (!stored) return out;
  for (int offset = 0; offset < field.raw.width; offset += 8) {
    const Eight v =
        gather<Eight>(at.rows, at.fraction, field.raw.values.data(), field.raw.width, offset).value;
    if (offset == 0) {
      const Emission<float> emission =
          emission_of<false>(RawSample<float>{present(v[0], presence), {v[1], v[2], v[3]}},
                             field.activation.scale, field.activation.shift);
      out.density = emission.sigma;
      out.color = emission.base;
    }
    for (int i = 0; i < 8; ++i)
      if (const int c = offset + i - 4; c >= 0 && c < field.sh_count()) out.sh[c] = v[i];
  }
  return out;
}

}  // namespace splinevox
