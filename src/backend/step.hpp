// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "core/ranks.hpp"
#include "field/lattice/row_mask.hpp"
#include "math/adam.hpp"
#include "math/curve_prior.hpp"
#include "math/depth_loss.hpp"
#include "render/active_rows.hpp"
#include "render/occupancy.hpp"
#include "render/ray_losses.hpp"
#include "render/views.hpp"
#include "splinevox/backend/device.hpp"
#include "splinevox/field/model.hpp"

namespace splinevox {

/// Columns of a row that are drawn to zero together unless their gradients insist (math/shrink.hpp).
struct Shrink {
  std::vector<float> member;  ///< [width] 1 for columns of the group, else 0
  float threshold = 0;        ///< length of the group, per touch and at the full rate
};

/// One value array that is learned and what belongs to it, all in the caller's memory.
struct LearnedRows {
  Channels* values;
  AlignedVector<float>*m, *v;       ///< moments
  std::span<const float> rate, tv;  ///< [width] learning rates and weights of total variation; 0 in padding
  std::span<const Shrink> shrink;   ///< at most UpdateKernel::kGroups
  /// [bricks + 1] visible rows, over many steps; empty: not kept. A ray makes the rows around a sample
  /// visible if its weight T alpha is at least min_weight and RayLosses::visible_share of the largest. That
  /// is every sample of smoke, and none behind a surface. Where the picture has nothing but background
  /// (has_matter) no sample counts, so fog there is not visible; also with StepInput::colour_gradient. A step
  /// that is not usable makes none visible. For total variation, rows that are not visible are as if absent.
  std::span<RowMask> visible;
};

/// What stays the same from step to step, until a lattice, a curve or the occupancy changes. With motion,
/// `levels` are coarse to fine.
struct StepModel {
  const VoxelModel* model;  ///< box, march step, activation, columns of the motion; its arrays are not read
  LearnedRows radiance;
  std::vector<LearnedRows> levels;  ///< empty: nothing changes over time
  const ActiveRows* active;         ///< of the finest level
  std::span<const BitGrid> occupancy;
  CurvePrior curves;         ///< of each level
  StaticPrior static_prior;  ///< of the sum of all levels
  bool may_spoil = true;     ///< priors and total variation alone could make a gradient unusable
};

/// Rays [first, last) of a batch, all of one slot: a piece of work.
struct RayTask {
  int slot;
  int first, last;
};
constexpr int kTaskRays = 128;  ///< of a task, at most

/// Rays through points that are followed through pictures, at several slots each.
struct TrackRays {
  std::span<const RayInput<float>> rays;  ///< grouped by slot
  std::span<const RayTask> tasks;         ///< a fixed cut of them
  std::span<const int> first;             ///< [points + 1] where each begins in `of_points`
  std::span<const int> of_points;         ///< [rays] the rays of one point after those of another
};

/// Given the colours of all rays of a batch, fills d loss / d colour of each, which is 0 before.
using ColourGradient = std::function<void(std::span<const Vec3> colours, std::span<Vec3> gradients)>;

/// What one step asks for. The batch is the same on all ranks; each takes its share.
struct StepInput {
  std::span<const RayInput<float>> rays;  ///< grouped by slot, equally many each
  std::span<const Vec3> targets;
  std::span<const DepthTarget<float>> depths;  ///< [rays] how far away what they show is; empty: unknown
  std::span<const RayTask> tasks;              ///< a fixed cut of the rays
  TrackRays tracks;                            ///< none: nothing is known of points
  std::span<const double> times;               ///< of the slots, model time in [0, 1]
  std::span<const int> occupancy;              ///< of the slots: which of StepModel::occupancy
  const Background* background;                ///< behind the rays
  std::span<Vec3> behind;  ///< [rays] gets the gradient of the colour behind each, 0 of other ranks' rays,
                           ///< from which the background's follows; empty: nothing is before the background
  RayLosses losses;
  const ColourGradient* colour_gradient = nullptr;  ///< in place of photometric_gradient; null: that
  float tv_scale, tv_share;
  std::uint64_t draw;  ///< of total variation: levels take draw + 1, ...
  MomentFactors factors;
  float radiance_rate, motion_rate;  ///< what learning rates are multiplied by
  bool errors = false;               ///< StepSums::errors is wanted
  bool slopes = false;               ///< StepSums::slopes is wanted
};

/// Gradient of a learned background's harmonics.
using BackgroundGradient = std::array<Vec3d, kMaxShCount>;

/// What a step gave, summed over the rays of all ranks.
struct StepSums {
  double squared_error = 0, motion_loss = 0, depth_loss = 0, track_loss = 0;
  std::int64_t samples = 0;         ///< in stored bricks
  bool usable = true;               ///< every loss and gradient is; if not, no parameter was changed
  std::int64_t bad_rows = 0;        ///< rows whose gradient is not usable
  BackgroundGradient background{};  ///< if it is learned, and StepInput::behind is empty
  std::vector<Vec3> errors;         ///< [rays] photometric error of each; only where it is wanted
  std::vector<double> slopes;       ///< [slots] d loss / d time of each; only where it is wanted
  /// Seconds in parts of the step, as far as they can be told apart; what is missing went by in the rays.
  double slice_seconds = 0, scatter_seconds = 0, regularise_seconds = 0, update_seconds = 0;
};

/// The errors and slopes of all ranks, where each has those of its own rays.
void sum_over_ranks(Ranks& ranks, StepSums& sums);

/// Above it a number, summed over levels, would soon have no square in float, and one NaN let into the
/// moments would stay (numerics H31).
inline constexpr float kLargestGradient = 1e16f;

/// Whole training steps: slices, rays, scatter, regularisers, update. Parameters and moments may stay with a
/// backend from upload to download; lattices are changed by the caller, between the two.
class StepBackend {
 public:
  virtual ~StepBackend() = default;
  virtual void upload(const StepModel& model) = 0;
  /// Parameters, moments and what is visible into the arrays that `upload` was given.
  virtual void download() = 0;
  /// One step; waits at its end.
  virtual StepSums run(const StepInput& input) = 0;
  /// Whether steps take StepInput::depths.
  virtual bool learns_depth() const { return false; }
  /// Whether steps take StepInput::tracks.
  virtual bool learns_tracks() const { return false; }
  /// Whether steps take StepInput::colour_gradient.
  virtual bool takes_colour_gradient() const { return false; }
  /// Rays of the last batch that this rank computed and that were not usable, in order.
  virtual std::vector<int> bad_rays() = 0;
};

/// Who makes the steps of a device (choose_device): the CPU's own code, or the device's kernels.
/// @param deterministic  of a device: gradients have the same bits in every run (GradientRows, fixed point);
/// otherwise sums depend on the order in which rays happen to arrive, in their last bits. The CPU's always
/// have the same bits, for any number of threads.
/// @param ranks  who makes the steps together, each of its own rays, and on a device of its own; null: nobody
/// else. Gradients are added up. Throws Error (input) where they cannot be, or a machine has fewer devices
/// than ranks.
std::unique_ptr<StepBackend> make_step(Device device, bool deterministic = false, Ranks* ranks = nullptr);

/// The device's kernels on the calling arena's threads: what tests run where there is no device.
std::unique_ptr<StepBackend> make_host_step(bool deterministic, Ranks* ranks = nullptr);

}  // namespace splinevox
