// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "splinevox/core/vec3.hpp"
#include "splinevox/field/model.hpp"

namespace splinevox {

/// Bounds that are checked before anything is parsed or allocated, and by writers, since what is finished
/// must not be lost: no configuration leads beyond them. What memory has no room for is refused besides.
struct VdbLimits {
  std::uint64_t max_bytes = std::uint64_t(1) << 40;  ///< size of the file
  int max_grids = kMostGrids + 2;                    ///< those of a model's fields, and of its surroundings
  std::uint32_t max_text = 1u << 24;                 ///< bytes of one metadata entry or name
  /// Voxels of all grids together: in leaves of 512, and those that active tiles stand for.
  std::uint64_t max_voxels = std::uint64_t(1) << 36;
  std::uint64_t max_tile_voxels = std::uint64_t(1) << 24;  ///< of them, in tiles
};

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

struct FileCheck {
  std::string file;
  bool ok = false;
  std::string problem;  ///< empty if ok
};

/// Checks size and hash of every listed file; a .vdb whose bytes are right is also parsed, and a run's
/// model.vdb loaded. One entry per listed file, in the manifest's order. Throws Error (Fault::input) if there
/// is no usable manifest or it lists nothing; a file's own problem is in the list.
std::vector<FileCheck> verify(const std::string& folder);

}  // namespace splinevox
