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

/// Writes what the options ask for of what the matter carries through all frames: the surface of the first of
/// these frames, a file per part, and points. @return their entries.
std::vector<ManifestFile> write_carried(const VoxelModel& model, const std::string& folder,
                                        const ExportOptions& options, const FrameBaker& baker, int clusters,
                                        const std::vector<int>& frames);

/// Which of these files a stage shows.
std::vector<UsdLayer> usd_layers(const std::vector<ManifestFile>& carried);

}  // namespace splinevox
