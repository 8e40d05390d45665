// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>

#include "io/export_mesh.hpp"
#include "io/export_profiles.hpp"
#include "io/export_reach.hpp"
#include "io/view_bake.hpp"
#include "splinevox/io/export_vdb.hpp"
#include "splinevox/io/vdb_file.hpp"

namespace splinevox {

/// A frame as grids, and what a manifest counts about it.
struct BakedFrame {
  VdbFile file;
  ColorMesh mesh;  ///< empty unless asked for
  std::map<std::string, double> figures;
};

/// Turns a model at one time into the grids of one exported frame.
class FrameBaker {
 public:
  /// @pre options are valid. The model must outlive the baker.
  FrameBaker(const VoxelModel& model, const ExportOptions& options);

  /// @param time  model time in [0, 1].
  /// @param per_second  units of model time per second: 0 where the model stands still.
  BakedFrame bake(double time, double per_second) const;

  const Lattice& lattice() const { return lattice_; }

 private:
  const VoxelModel& model_;
  const ExportOptions& options_;
  const ExportProfile& profile_;
  Lattice lattice_;
  float min_density_;  ///< 1 / scene unit
  ExportReach reach_;
  ViewBake view_;
};

/// The lattice that voxels are written on: the radiance field's, or one of `voxel_size` over the box.
Lattice export_lattice(const VoxelModel& model, double voxel_size);

}  // namespace splinevox
