// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "field/lattice/row_mask.hpp"
#include "field/lattice/slice.hpp"
#include "render/occupancy.hpp"
#include "render/views.hpp"
#include "splinevox/field/model.hpp"
#include "splinevox/train/config.hpp"

namespace splinevox::micro {

/// Harmonics of the model: the kernels are compiled for them.
inline constexpr int kOrder = 2;

/// A hollow ball that sways, as large as a model of the preset fast is at its end, and the rays of a last
/// step: made of formulas and fixed draws, so the same everywhere.
struct Scene {
  Config config;                             ///< the preset's
  VoxelModel model;                          ///< one motion level, the finest
  std::vector<double> times;                 ///< of the frame slots of a batch, [0, 1]
  std::vector<BitGrid> occupancy;            ///< of each slot
  std::vector<RowMask> active;               ///< rows of the motion near matter of any slot, [bricks + 1]
  std::vector<BasisWeights<float>> weights;  ///< of each slot
  std::vector<MotionSlice> slices;           ///< of each slot
  std::vector<RayInput<float>> rays;         ///< grouped by slot, as many in each

  Scene();
  std::span<const RayInput<float>> rays_of(std::size_t slot) const {
    return std::span(rays).subspan(slot * (rays.size() / times.size()), rays.size() / times.size());
  }
  FrameView<float> frame(std::size_t slot) const {
    return {slices[slot].values.data(), occupancy[slot].view()};
  }
};

/// The one scene, made when first asked for.
const Scene& scene();

}  // namespace splinevox::micro
