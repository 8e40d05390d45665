// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "splinevox/field/model.hpp"

namespace splinevox {

/// Which parts of the canonical volume move alike.
///
/// A motion voxel belongs to observed space and holds different matter at different times, so its control
/// points are the path of no matter. What is clustered is the path of the matter: every place with matter at
/// a time adds its own position to the canonical cell that it looks up, weighted by opacity; the mean over
/// the moments of a cell's path is its trajectory, taken relative to its own mean place. Gaps, where a cell
/// is out of sight, are filled from the moments around them.
struct MotionClusters {
  struct Cluster {
    double share = 0;   ///< of all matter, by opacity
    double motion = 0;  ///< root mean square of the distance from the own mean place over the moments, voxels
                        ///< of the radiance lattice
    Vec3 center{};      ///< of its canonical cells, scene units
  };
  Lattice cells;  ///< canonical cells, each around a vertex of this lattice
  std::vector<std::int16_t>
      label;  ///< [cells, z fastest] number of the cluster; -1: no place ever looks up matter here
  std::vector<Cluster> clusters;  ///< 0 is static: moves by less than kStillVoxels, or by little and like
                                  ///< no moving part; then the less a cluster moves the earlier
  double silhouette = 0;          ///< see math/kmeans.hpp

  /// Cluster of a canonical position, -1 for none.
  int at(Vec3 canonical) const;
};

inline constexpr double kStillVoxels = 0.5;  ///< MotionClusters::Cluster::motion below which a cell is static

/// @param count  clusters, the static one included, 2..16; 0: the fewest, up to 6, whose
/// silhouette is within 0.03 of the highest. Deterministic. The time curve plays no part.
/// @pre at most one motion level. Where nothing moves there is one cluster.
MotionClusters find_clusters(const VoxelModel& model, int count);

}  // namespace splinevox
