// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "backend/host/gradient.hpp"
#include "backend/step.hpp"

namespace splinevox {

/// What one pass over a batch gives besides the gradients.
struct PassResult {
  double squared_error = 0;  ///< summed over rays and colour channels
  double motion_loss = 0;    ///< offset and divergence losses, summed
  double depth_loss = 0;     ///< of the rays whose depth is known, summed
  double track_loss = 0;     ///< of the rays of tracks, summed
  std::int64_t samples = 0;  ///< in stored bricks, forward and backward
  bool usable = true;        ///< losses are finite and every gradient is usable
  double slice_seconds = 0, scatter_seconds = 0;
};

/// What a pass may give beside gradients of parameters. Empty: not wanted.
struct PassOutput {
  std::span<Vec3> behind = {};    ///< [rays] gradient of the colour behind each ray of the tasks
  std::span<Vec3> errors = {};    ///< [rays] photometric error of each ray of the tasks
  std::span<double> slopes = {};  ///< [slots] d loss / d time of each, of the rays of the tasks
  std::span<RowMask> marks = {};  ///< [bricks + 1] radiance rows that the rays make visible are set
};

/// Which rays of a batch are one rank's.
struct OwnTasks {
  std::span<const RayTask> rays, tracks;  ///< of StepInput::tasks and of TrackRays::tasks
};

/// Forward and backward over one batch: slices, rays, scatter. Gradients are of the sum over rays of the
/// squared colour error plus the losses of motion, depth and tracks. Keeps its buffers between steps. The
/// same bits for any number of threads.
class Engine {
 public:
  virtual ~Engine() = default;
  /// @param model     of its levels nothing is read. Rows of the motion that are not active get no gradient.
  /// @param motion    the sum of the levels, on the finest one's lattice; null: nothing changes over time
  /// @param d_radiance  gradient of the radiance rows, accumulated
  /// @param d_motion  gradient of the sum of the levels, accumulated; null with `motion`
  virtual PassResult run(const StepModel& model, const Channels* motion, const StepInput& in,
                         const OwnTasks& own, Gradient& d_radiance, Gradient* d_motion,
                         const PassOutput& out) = 0;
  /// Rays of the last batch whose loss or gradient was not finite, in order.
  virtual std::vector<int> bad_rays() const = 0;
};

/// @param sh_order       -1..3
/// @param moving         whether the models it will be given change: have motion, light or presence
/// @param motion_losses  whether offset or divergence losses may be asked for
std::unique_ptr<Engine> make_engine(int sh_order, bool moving, bool motion_losses);

}  // namespace splinevox
