// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "run/support.hpp"
#include "splinevox/field/edit.hpp"

namespace splinevox::run {

/// How much of a model a page keeps.
struct ViewQuality {
  int density_bits = 12;    ///< per raw density
  int colour_bits = 10;     ///< per raw colour component
  int sh_bits = 8;          ///< per coefficient of the view rescale, at most 8; 0: there is none in the page
  int motion_bits = 16;     ///< per component of a control point, light and rigidity; 9..16
  int halvings = 0;         ///< how often the radiance lattice is made coarser by two
  bool everywhere = false;  ///< matter may be anywhere at some time: packed in half the time, larger when
                            ///< compressed, and drawn a little slower
};
/// From the best to the smallest; a page takes the first that fits.
const std::vector<ViewQuality>& view_qualities();

/// A model as numbers a page can hold: what they mean, and the bytes.
struct PackedScene {
  Json header;  ///< docs/formats.md, "The page of view"
  std::vector<std::uint8_t> bytes;
};

/// Quantises what a ray can see at some time: rows further than a vertex from anything of alpha 0.0002 per
/// step are left out, whole bricks of them have no place in the page. Raw values, because activation comes
/// after interpolation.
/// @param clusters  parts of the model for the layer of that name; null: there is none
PackedScene pack_scene(const VoxelModel& model, const ViewQuality& quality,
                       const MotionClusters* clusters = nullptr);

}  // namespace splinevox::run
