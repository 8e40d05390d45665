// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "io/export/export_profiles.hpp"
#include "splinevox/field/model.hpp"
#include "splinevox/io/export_vdb.hpp"

namespace splinevox {

/// What the files of a part are called: "" where there is one, the whole; else "cluster_0_" and so on.
/// @param clusters  how many parts; 0: the whole
std::vector<std::string> part_prefixes(int clusters);
/// "frame_0001.vdb", or as the profile has it.
std::string frame_name(int frame, const ExportProfile& profile);
std::string mesh_name(int frame, const std::string& format);

/// The files of a sequence.
struct SequenceFiles {
  std::vector<int> frames;  ///< their numbers, in order, at least one
  int clusters = 0;         ///< parts, 0: the whole
};

/// Writes what the profile wants beside the frames. @return an entry for it, or none.
/// @param padding  voxels beyond the lattice that some frame reaches
std::vector<ManifestFile> write_sidecar(const std::string& folder, const VoxelModel& model,
                                        const ExportOptions& options, const SequenceFiles& files,
                                        const Lattice& lattice, int padding);

}  // namespace splinevox
