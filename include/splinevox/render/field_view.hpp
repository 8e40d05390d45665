// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "splinevox/math/aabb.hpp"
#include "splinevox/math/camera.hpp"
#include "splinevox/render/views.hpp"

namespace splinevox {

/// The float view of a model for the ray kernels. @param step  march step, scene units.
inline FieldView<float> view_field(const VoxelModel& model, float step) {
  FieldView<float> view;
  view.radiance = BrickView<float>(*model.radiance.raw.topology);
  view.radiance_rows = model.radiance.raw.values.data();
  view.density_scale = model.radiance.activation.scale;
  view.density_shift = model.radiance.activation.shift;
  view.step = step;
  view.moving = !model.motion.levels.empty();
  if (view.moving) view.motion = BrickView<float>(*model.motion.levels.back().topology);
  view.rigidity = model.motion.rigidity;
  view.rigidity_offset = model.motion.rigidity_offset;
  return view;
}

/// Clips a ray to the box and places its samples: the first lies `jitter` steps behind the entry. Positions are moved to the
/// entry in double, so a scene far from the origin loses nothing (numerics H14).
/// @param jitter  in [0, 1); 0.5 for a picture.
inline RayInput<float> clip_ray(const Ray& ray, const Box& box, float step, float jitter, Vec3 background) {
  RayInput<float> out;
  out.background = background;
  out.direction = cast<float>(ray.direction);
  const Interval inside = intersect(box, ray.origin, ray.direction);
  if (inside.far <= inside.near) return out;
  const double first = inside.near + double(jitter) * step;
  out.origin = cast<float>(ray.origin + first * ray.direction);
  out.count = int((inside.far - first) / step) + 1;
  if (first > inside.far) out.count = 0;
  return out;
}

}  // namespace splinevox
