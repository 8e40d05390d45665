// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>

#include "io/splat/splat_file.hpp"
#include "io/vdb/leaf_values.hpp"
#include "splinevox/core/vec3.hpp"

namespace splinevox {

/// A box in the scene: what is outside is left out.
struct SplatBox {
  Vec3d lo{}, hi{};
};

struct SplatVolume {
  LeafValues density;  ///< 1 / scene unit; voxel v at v times the spacing
  LeafValues color;    ///< display values, on one voxel more to all sides
  std::map<std::string, double>
      figures;  ///< splats, and splats_skipped where some have numbers that are none
};

/// Splats as a volume: density and colour are the Gaussians' own integrals over the voxels
/// (io/splat/splat_gaussian.hpp). Works through layers of bricks, so that beside the result only the splats
/// of one layer are in memory; the same bits for any number of threads.
/// @param min_alpha  voxels less opaque than this are dropped, (0, 1)
/// Throws Error (Fault::input) naming --voxel-size and --box where the splats reach over more bricks than can
/// be worked through.
SplatVolume splat_volume(const SplatFile& file, double spacing, double min_alpha,
                         const std::optional<SplatBox>& box);

/// What suits the splats of a file where nothing is asked for: the median of their middle sizes, but at most
/// 512 voxels over the middle 98% of their places.
double splat_spacing(const SplatFile& file);

}  // namespace splinevox
