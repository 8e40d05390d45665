// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "io/export/export_frame.hpp"
#include "io/export/usd_stage.hpp"

namespace splinevox {

/// Counts of a mesh, for a manifest.
void add_size(std::map<std::string, double>& figures, const ColorMesh& mesh);

inline constexpr const char* kPointsFile = "points.usda";
/// "mesh.usda" or "mesh.glb", behind the prefix of a part. @pre options.mesh_carried()
std::string carried_mesh_file(const ExportOptions& options);

/// Throws Error (Fault::memory) where the surface at the first frame, carried through so many, would not find
/// room: it is held for all of them at once. @pre options.mesh_carried()
void check_carried_room(const ExportOptions& options, const FrameBaker& baker, std::size_t frames);

/// Writes what the options ask for of what the matter carries through all frames: the surface of the first of
/// these frames, a file per part, and points. @return their entries.
std::vector<ManifestFile> write_carried(const VoxelModel& model, const std::string& folder,
                                        const ExportOptions& options, const FrameBaker& baker, int clusters,
                                        const std::vector<int>& frames);

/// Which of these files a stage shows.
std::vector<UsdLayer> usd_layers(const std::vector<ManifestFile>& carried);

}  // namespace splinevox
