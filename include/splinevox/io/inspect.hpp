// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "io/vdb/vdb_file.hpp"
#include "splinevox/core/vec3.hpp"

namespace splinevox {

/// What `info` prints about one grid of any type.
struct GridInfo {
  std::string name;
  std::string type;        ///< OpenVDB's value type: "float", "vec3s", "mask", ...
  std::string grid_class;  ///< "fog volume", "level set", "staggered", "unknown"
  std::uint64_t active_voxels = 0;
  std::uint64_t leaves = 0;
  std::uint64_t memory_bytes = 0;  ///< in memory, not on disk
  bool half = false;               ///< stored as 16-bit floats
  bool linear = true;              ///< false: a frustum, for which spacing and origin hold at voxel 0 only
  Vec3d voxel_size{};              ///< scene units per voxel and axis
  Vec3d origin{};                  ///< world position of voxel 0
  Int3 lo{}, hi{};  ///< active bounding box in index space, inclusive; lo > hi: no active voxel
  std::map<std::string, std::string> meta;
};

struct VdbInfo {
  std::uint64_t file_bytes = 0;
  std::string version;  ///< of the library that wrote it / of the file format
  bool sealed = false;  ///< carries this project's checksum, which was right
  std::map<std::string, std::string> meta;
  std::vector<GridInfo> grids;
};

/// Lists the grids of any .vdb. Throws Error (Fault::input) as read_vdb does.
VdbInfo inspect_vdb(const std::string& path, const VdbLimits& limits = {});

}  // namespace splinevox
