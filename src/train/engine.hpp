// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "field/lattice/levels.hpp"
#include "field/lattice/row_mask.hpp"
#include "render/active_rows.hpp"
#include "render/backward.hpp"
#include "render/occupancy.hpp"
#include "render/ray_losses.hpp"
#include "train/batch.hpp"
#include "train/gradient.hpp"

namespace splinevox {

/// What one pass over a batch gives besides the gradients.
struct PassResult {
  double squared_error = 0;  ///< summed over rays and colour channels
  double motion_loss = 0;    ///< offset and divergence losses, summed
  std::int64_t samples = 0;  ///< in stored bricks, forward and backward
  std::int64_t visited = 0;  ///< in occupied cells
  bool usable = true;        ///< losses are finite and every gradient is usable
  double slice_seconds = 0, ray_seconds = 0, scatter_seconds = 0;
};

/// Forward and backward over one batch: slices, rays, scatter. Gradients are of the sum over rays of the
/// squared colour error plus the motion losses. Keeps its buffers between steps. The same bits for any number
/// of threads.
class Engine {
 public:
  virtual ~Engine() = default;
  /// @param model      motion collapsed into one level (or none).
  /// @param active     rows of the motion level that a sample may read other than zeros from; the others get
  /// no gradient. Its reach has the cells of the occupancies.
  /// @param times      model time of each frame slot of the batch, [0, 1].
  /// @param occupancy  of each frame slot.
  /// @param radiance   gradient of model.radiance.raw, accumulated; marks what was seen, if it has a mask for
  /// that.
  /// @param motion     gradient of the collapsed motion level, accumulated; ignored when nothing moves.
  /// @param behind     gets the gradient of the colour behind each ray of the batch's tasks, [rays]; empty:
  /// not wanted.
  virtual PassResult run(const VoxelModel& model, const ActiveRows& active, float step, const Batch& batch,
                         const std::vector<double>& times, const std::vector<const BitGrid*>& occupancy,
                         const RayLosses& losses, Gradient& radiance, Gradient& motion,
                         std::span<Vec3> behind) = 0;
  /// Rays of the last batch whose loss or gradient was not finite, in order.
  virtual std::vector<int> bad_rays() const = 0;
};

/// @param sh_order       -1..3
/// @param moving         whether the models it will be given have motion or light
/// @param motion_losses  whether offset or divergence losses may be asked for
std::unique_ptr<Engine> make_engine(int sh_order, bool moving, bool motion_losses);

}  // namespace splinevox
