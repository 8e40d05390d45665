// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <utility>

#include "field/lattice/slice.hpp"
#include "render/field_view.hpp"
#include "render/occupancy.hpp"
#include "render/ray_kernel.hpp"

namespace splinevox {

/// One model at one time, sampled along rays.
/// @tparam Sh  the model's order of harmonics
template <int Sh>
class Look {
 public:
  /// @param occupancy  of that time; null: rays are sampled everywhere
  Look(const VoxelModel& model, double time, const BitGrid* occupancy = nullptr)
      : model_(model),
        slice_(model.motion.levels.empty() ? MotionSlice{}
                                           : make_slice(model.motion, stored_weights(model.motion, time))),
        field_(view_field(model, model.step)),
        frame_{slice_.values.data(), occupancy ? occupancy->view() : OccupancyView<float>{}} {}

  Vec3 along(const Ray& ray) { return along(ray, model_.behind(ray)); }
  /// @param behind  the box, where it is known
  Vec3 along(const Ray& ray, const Vec3& behind) {
    through_ = clip_ray(ray, model_.box, model_.step, 0.5f, behind);
    return (field_.moving ? moving_.forward(through_, field_, frame_, kStop)
                          : still_.forward(through_, field_, frame_, kStop))
        .rgb;
  }
  /// Distance from its origin at which the last ray had met half of its matter, scene units, and its alpha.
  std::pair<double, float> distance(const Ray& ray) const {
    return field_.moving ? distance_of(moving_, ray) : distance_of(still_, ray);
  }
  /// Calls visit(position, weight, i) for the samples i of the last ray that count in its pixel. @pre
  /// something changes over time in the model
  template <class Visit>
  void each_sample(Visit&& visit) const {
    for (int i = 0; i < moving_.count; ++i)
      if (moving_.weight[i] >= kLeastWeight)
        visit(through_.origin + (moving_.distance[i] * field_.step) * through_.direction, moving_.weight[i],
              i);
  }
  /// How far from sample i of the last ray its matter is in the canonical volume, scene units.
  Vec3 displacement(int i) const {
    const auto& motion = moving_.samples[i].warp.motion;
    return moving_.r[i] * Vec3{motion[0], motion[1], motion[2]};
  }
  /// Gain of the light there.
  float light(int i) const { return moving_.light[i]; }
  /// Presence there.
  float presence(int i) const {
    const auto& warp = moving_.samples[i].warp;
    if (!model_.motion.presence || warp.cell.is_frozen()) return 0;
    const CellRows rows = field_.motion.rows(warp.cell);
    float w[kCorners], sum = 0;
    trilinear_weights(warp.fraction, w);
    for (int c = 0; c < kCorners; ++c)
      sum += w[c] * frame_.slice[std::size_t(rows.row[c]) * kSliceWidth + kSliceScalars + kPresence];
    return sum;
  }

 private:
  template <class Kernel>
  std::pair<double, float> distance_of(const Kernel& kernel, const Ray& ray) const {
    float all = 0, met = 0;
    for (int i = 0; i < kernel.count; ++i) all += kernel.weight[i];
    int i = 0;
    while (i + 1 < kernel.count && met + kernel.weight[i] < 0.5f * all) met += kernel.weight[i++];
    if (kernel.count == 0) return {0, 0};
    const float within = kernel.weight[i] > 0 ? (0.5f * all - met) / kernel.weight[i] : 0.5f;
    const double start = dot(cast<double>(through_.origin) - ray.origin, ray.direction);
    return {start + double(field_.step * (kernel.distance[i] + within - 0.5f)), all};
  }
  static constexpr float kLeastWeight = 0.02f, kStop = 1e-3f;
  const VoxelModel& model_;
  MotionSlice slice_;
  FieldView<float> field_;
  FrameView<float> frame_;
  RayInput<float> through_;
  RayKernel<float, Sh> moving_;
  StillKernel<float, Sh> still_;
};

}  // namespace splinevox
