// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "io/splat/splat_file.hpp"
#include "splinevox/core/vec3.hpp"

namespace splinevox {

/// A Gaussian of optical depth on a lattice, in units of its voxels. Voxel v reaches from v - 1/2 to v + 1/2.
struct LatticeGaussian {
  Vec3d mean{};
  double covariance[3][3] = {};
  double mass = 0;  ///< optical depth of a voxel, summed over all voxels
  Vec3 color{};     ///< display values
  Int3 lo{}, hi{};  ///< voxels that it reaches, kReach standard deviations, inclusive
};

inline constexpr double kGaussianReach = 3.5;

/// A splat on the lattice with voxel 0 at the world's origin. Seen along its shortest axis it hides as much
/// as a renderer of splats draws (splat_cross_section); a round one does so from everywhere. It is at least
/// an eighth of a voxel thick: the voxels would not show less.
/// @param color  display values
LatticeGaussian on_lattice(const Splat& splat, const Vec3d& color, double spacing);

/// Mean over all directions of a splat's colour, of which a renderer shows nothing below 0.
Vec3d mean_color(const Splat& splat);

/// The voxels of one brick, 8^3 in OpenVDB's order, and what lies in them.
struct BrickSums {
  double depth[512] = {};     ///< optical depth of a voxel
  double color[512][3] = {};  ///< the same times display values
};

/// Adds the Gaussian's integrals over the voxels of a brick: along the axis in which it is sharpest by the
/// error function, in the other two by midpoints two to a standard deviation, so that all voxels add up to
/// its mass. A Gaussian along the axes is a product of three error functions.
/// @param corner  the brick's first voxel
void add_to_brick(const LatticeGaussian& gaussian, Int3 corner, BrickSums& sums);

}  // namespace splinevox
