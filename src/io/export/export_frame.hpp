// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "field/matter_reach.hpp"
#include "io/export/export_mesh.hpp"
#include "io/export/export_profiles.hpp"
#include "io/export/view_bake.hpp"
#include "io/vdb/leaf_values.hpp"
#include "io/vdb/vdb_file.hpp"
#include "splinevox/field/edit.hpp"
#include "splinevox/field/sample.hpp"
#include "splinevox/io/export_vdb.hpp"

namespace splinevox {

/// A frame, or one cluster of it, as grids, and what a manifest counts about it.
struct BakedPart {
  VdbFile file;
  ColorMesh mesh;  ///< empty unless asked for
  std::map<std::string, double> figures;
};

/// Turns a model at one time into the grids of one exported frame.
class FrameBaker {
 public:
  /// @param clusters  the parts to bake apart, or null for the whole
  /// @pre options are valid. All three must outlive the baker.
  FrameBaker(const VoxelModel& model, const ExportOptions& options, const MotionClusters* clusters);

  /// @param time  model time in [0, 1].
  /// @param per_second  units of model time per second: 0 where the model is static.
  /// @param mesh  its surface too
  /// @return a part per cluster, or one that is the whole.
  std::vector<BakedPart> bake(double time, double per_second, bool mesh) const;

  const Lattice& lattice() const { return lattice_; }

 private:
  BakedPart bake_part(const FrameSampler& sampler, LeafValues density, double per_second, bool mesh) const;

  const VoxelModel& model_;
  const ExportOptions& options_;
  const MotionClusters* clusters_;
  const ExportProfile& profile_;
  Lattice lattice_;
  float min_density_;  ///< 1 / scene unit
  MatterReach reach_;
  ViewBake view_, mesh_view_;  ///< of voxels, and of surfaces, which hold no harmonics
};

/// The lattice that voxels are written on: the radiance field's, or one of `voxel_size` over the box. Throws
/// Error (Fault::input) naming --voxel-size where the box would hold more voxels than a frame may.
Lattice export_lattice(const VoxelModel& model, double voxel_size);

}  // namespace splinevox
