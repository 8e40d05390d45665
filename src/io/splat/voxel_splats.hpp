// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "io/vdb/vdb_file.hpp"

namespace splinevox {

/// The voxels of a frame as round Gaussians of one size.
struct VoxelSplats {
  double size = 0;               ///< standard deviation, scene units
  int degree = 0;                ///< of the harmonics, 0..3
  std::vector<Vec3> places;      ///< scene units, in the axes that were asked for
  std::vector<float> opacities;  ///< in (0, 1)
  std::vector<float> harmonics;  ///< [splat][(degree + 1)^2][red, green, blue], in files' basis: the colour
                                 ///< along d is 0.5 + sum_j harmonics_j Y_j(d), display values

  int count() const { return (degree + 1) * (degree + 1); }
};

enum class SplatAxes { scene, upright };

/// One splat a voxel, of size kSplatSize voxels, rounded to what .spz files can hold, where they can; its
/// opacity keeps the voxel's transmittance (math/splat.hpp). Voxels that no renderer would draw have none.
/// @param axes  scene: the frame's own; upright: those of .spz files, x right, y up, z to the viewer, for a
/// frame whose z is up
/// @param frame  density, color and, with harmonics, sh0, sh1, ..., as export_vdb bakes them
/// @param sh_order  of the harmonics in `frame`; -1: the colour is the same from everywhere
VoxelSplats voxel_splats(const VdbFile& frame, int sh_order, SplatAxes axes);

/// Standard deviation of a splat, in voxels.
inline constexpr double kSplatSize = 0.4;

/// Throws Error (input) where an .spz cannot hold the splats of voxels so large, scene units.
void check_spz_size(double spacing);

/// A binary little-endian PLY as trainers of splats write it: x y z, nx ny nz, f_dc, f_rest, opacity (logit),
/// scale (log), rot (w x y z); 32-bit floats.
std::string splat_ply(const VoxelSplats& splats);

/// The same as an .spz, version 2 (Niantic): 20 bytes a splat without harmonics, then deflated. It says that
/// pictures are to be made without blowing small splats up.
std::string splat_spz(const VoxelSplats& splats);

}  // namespace splinevox
