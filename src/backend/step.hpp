// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/ranks.hpp"
#include "field/lattice/row_mask.hpp"
#include "math/adam.hpp"
#include "math/curve_prior.hpp"
#include "render/occupancy.hpp"
#include "render/train_kernel.hpp"
#include "splinevox/backend/device.hpp"
#include "splinevox/field/model.hpp"

namespace splinevox {

/// One value array that is learned and what belongs to it, all in the caller's memory.
struct LearnedRows {
  struct Group {
    std::span<const float> member;  ///< [width] 1 for columns of the group, else 0
    float threshold;
  };
  Channels* values;
  AlignedVector<float>*m, *v;       ///< moments
  std::span<const float> rate, tv;  ///< [width]
  std::vector<Group> shrink;        ///< at most UpdateKernel::kGroups
  std::span<RowMask> seen = {};     ///< Gradient::seen
};

/// What training has between steps, as a device needs it. With motion, `motion` describes its columns and
/// `levels` are coarse to fine.
struct StepModel {
  const VoxelModel* model;  ///< box, activation, columns of the motion; its arrays are not read
  LearnedRows radiance;
  std::vector<LearnedRows> levels;  ///< empty: nothing changes over time
  std::span<const RowMask> active;  ///< ActiveRows::rows of the finest level
  std::span<const BitGrid> occupancy;
};

/// What one step asks for.
struct StepInput {
  std::span<const RayInput<float>> rays;  ///< grouped by slot, equally many each
  std::span<const Vec3> targets;
  std::span<const double> times;   ///< of the slots, [0, 1]
  std::span<const int> occupancy;  ///< of the slots: which of StepModel::occupancy
  RayLosses losses;
  float tv_scale, tv_share;
  CurvePrior curves;   ///< of each level
  RestPrior rest;      ///< of the sum of all levels
  std::uint64_t draw;  ///< of total variation: levels take draw + 1, ...
  MomentFactors factors;
  float radiance_rate, motion_rate;  ///< what learning rates are multiplied by
  float largest;                     ///< gradients beyond it cannot be used
  std::span<Vec3> behind;            ///< gets the gradient of the colour behind each ray; empty: not wanted
};

/// What a step gave.
struct StepSums {
  double squared_error = 0, motion_loss = 0;  ///< summed over rays
  std::int64_t samples = 0;
  std::int64_t bad_rays = 0, bad_rows = 0;  ///< not usable; if any, no parameter was changed
};

/// Whole training steps on a device: slices, rays, gradients, total variation, update. Parameters and moments
/// stay there from upload to download; lattices change on the host, between the two.
class StepBackend {
 public:
  virtual ~StepBackend() = default;
  virtual void upload(const StepModel& model) = 0;
  /// Parameters and moments into the arrays that `upload` was given.
  virtual void download() = 0;
  /// One step; waits at its end.
  virtual StepSums run(const StepInput& input) = 0;
  /// Rays of the last step that were not usable, in order.
  virtual std::vector<int> bad_rays() = 0;
};

/// @param deterministic  gradients have the same bits in every run (GradientRows, fixed point); otherwise
/// sums depend on the order in which rays happen to arrive, in their last bits. @pre the device is there
/// (choose_device) and not the CPU, whose step is Trainer's own.
/// @param ranks  who makes the steps together, each of its own rays on a device of its own; null: nobody
/// else. Gradients are added up from device to device. Throws Error (input) where they cannot be, or a
/// machine has fewer devices than ranks.
std::unique_ptr<StepBackend> make_step(Device device, bool deterministic, Ranks* ranks = nullptr);

/// The device's kernels on the calling arena's threads: what tests run where there is no device.
std::unique_ptr<StepBackend> make_host_step(bool deterministic, Ranks* ranks = nullptr);

}  // namespace splinevox
