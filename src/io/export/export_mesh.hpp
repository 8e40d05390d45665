// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "io/vdb/vdb_file.hpp"

namespace splinevox {

/// A surface with a colour per vertex. Triangles run counter-clockwise as seen from outside.
struct ColorMesh {
  std::vector<Vec3> points;  ///< scene units
  std::vector<std::array<std::uint8_t, 3>> colors;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// The surface where `density` is `isovalue` (openvdb::tools::volumeToMesh, not adaptive), coloured by
/// trilinear interpolation of `color`, which is display-referred, or scene-linear and then encoded as sRGB.
/// @pre the grids share their transform; `color` reaches a voxel beyond every voxel of at least `isovalue`.
ColorMesh make_mesh(const VdbGrid& density, const VdbGrid& color, double isovalue, bool linear);

/// The mesh as a binary little-endian PLY: float x y z, uchar red green blue, lists of three vertices.
std::string ply_bytes(const ColorMesh& mesh);

/// The mesh as Wavefront OBJ text: `v x y z r g b`, colours in [0, 1] (an extension that Blender 3.4, MeshLab
/// and others read), and `f a b c`.
std::string obj_text(const ColorMesh& mesh);

}  // namespace splinevox
