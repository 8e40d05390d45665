// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "field/lattice/slice.hpp"
#include "math/aabb.hpp"
#include "math/camera.hpp"
#include "render/views.hpp"

namespace splinevox {

/// The view of a model for ray kernels that compute in Real. @param rows  the model's radiance rows, as
/// Stored. @param step  march step, scene units.
template <class Real, class Stored>
FieldView<Real, Stored> view_field(const VoxelModel& model, const Stored* rows, Real step) {
  FieldView<Real, Stored> view;
  view.radiance = BrickView<Real>(*model.radiance.raw.topology);
  view.radiance_rows = rows;
  view.density_scale = Real(model.radiance.activation.scale);
  view.density_shift = Real(model.radiance.activation.shift);
  view.step = step;
  view.moving = !model.motion.levels.empty();
  if (view.moving) view.motion = BrickView<Real>(*model.motion.levels.back().topology);
  view.rigidity = model.motion.rigidity;
  view.slice_used = stored_floats(model.motion);
  view.rigidity_offset = Real(model.motion.rigidity_offset);
  return view;
}
/// The float view of a model's own rows.
inline FieldView<float> view_field(const VoxelModel& model, float step) {
  return view_field(model, model.radiance.raw.values.data(), step);
}

/// Clips a ray to the box and places its samples: the first lies `jitter` steps behind the entry. Positions
/// are moved to the entry in double, so a scene far from the origin loses nothing (numerics H14).
/// @param jitter  in [0, 1); 0.5 for a picture.
template <class Real>
SPLINEVOX_HD RayInput<Real> clip_ray(const Ray& ray, const Box& box, Real step, Real jitter,
                                     Vec3 background) {
  RayInput<Real> out;
  out.background = cast<Real>(background);
  out.direction = cast<Real>(ray.direction);
  const Interval inside = intersect(box, ray.origin, ray.direction);
  if (inside.far <= inside.near) return out;
  const double first = inside.near + double(jitter) * step;
  out.origin = cast<Real>(ray.origin + first * ray.direction);
  out.count = int((inside.far - first) / step) + 1;
  if (first > inside.far) out.count = 0;
  return out;
}

}  // namespace splinevox
