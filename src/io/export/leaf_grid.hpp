// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "io/export/export_profiles.hpp"
#include "io/vdb/leaf_values.hpp"
#include "io/vdb/vdb_file.hpp"

namespace splinevox {

/// Values on a set of voxels as a fog volume. Takes the values.
VdbGrid to_grid(LeafValues& values, int width, const std::string& name);

/// Puts voxel 0 of all grids at `origin`, and has them stored as 16-bit floats where `half`, the profile and
/// their values allow it. @param figures  counts grids whose values do not: wider_than_half
void place_grids(std::vector<VdbGrid>& grids, const Vec3d& origin, double spacing, bool half,
                 const ExportProfile& profile, std::map<std::string, double>& figures);

/// Moves the grids to where the profile's program takes a voxel to be.
void shift_grids(std::vector<VdbGrid>& grids, const ExportProfile& profile);

/// Where the voxels are, as figures min_x to max_z in scene units; none where there are none.
void add_box(std::map<std::string, double>& figures, const LeafSet& set, const Vec3d& origin, double spacing);

}  // namespace splinevox
