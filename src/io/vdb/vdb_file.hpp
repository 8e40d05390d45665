// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <variant>
#include <vector>

#include "splinevox/core/file_digest.hpp"
#include "splinevox/core/vec3.hpp"
#include "splinevox/io/inspect.hpp"

namespace splinevox {

/// One entry of a file's or a grid's metadata, as every VDB program shows it.
using VdbValue = std::variant<std::string, std::int64_t, double>;
using VdbMeta = std::map<std::string, VdbValue>;

enum class VdbClass { unknown, fog_volume };
/// How a vector grid transforms: a colour does not, a velocity turns and scales with its volume.
enum class VdbVector { none, invariant, contravariant_relative };

/// The largest value of a 16-bit float.
constexpr float kLargestHalf = 65504.0f;

/// A float or Vec3s grid as plain arrays; this header keeps OpenVDB's own out of every other file.
/// Voxel ijk sits at origin + spacing * ijk (no half-voxel shift).
struct VdbGrid {
  std::string name;
  int width = 1;       ///< 1: float grid, 3: Vec3s grid
  Vec3d origin{};      ///< world position of voxel 0, scene units
  double spacing = 1;  ///< scene units between voxels, > 0
  Vec3 background{};   ///< value of everything absent (x only if width is 1)
  VdbClass grid_class = VdbClass::unknown;
  VdbVector vector = VdbVector::none;
  bool half = false;          ///< stored as 16-bit floats; values beyond +-65504 are clamped to that
  std::vector<Int3> leaves;   ///< index of each leaf's first voxel: multiples of 8, no duplicates
  std::vector<float> values;  ///< [leaves * 512 * width]; inside a leaf x * 64 + y * 8 + z, OpenVDB's order
  std::vector<std::uint64_t>
      active;    ///< [leaves * 8] bit v & 63 of word v >> 6 is voxel v; empty: every voxel
  VdbMeta meta;  ///< besides name, class and the like, which are written from the fields above
};

struct VdbFile {
  VdbMeta meta;
  std::vector<VdbGrid> grids;
  std::vector<std::string> skipped;  ///< read only: names of grids of other types, which were left out
};

/// Writes a .vdb that any VDB program opens (Blosc, grid offsets, statistics), atomically: see write_file.
/// Takes the grids: each is let go when it has become OpenVDB's. The bytes depend on the content only (the
/// file's unique id is a hash of it). The file ends in a 24-byte seal, which other programs never look at: a
/// checksum of all that stands before, since VDB itself has none and OpenVDB accepts damaged files
/// (docs/reliability.md).
///
/// OpenVDB serialises into memory here and write_file puts the bytes on disk, because
/// openvdb::io::File::write returns without error on a full disk.
///
/// Throws Error (Fault::output) also for more voxels than readers take: what they refuse is not written.
FileDigest write_vdb(const std::string& path, VdbFile file, const VdbLimits& limits = {});

/// Reads the float and Vec3s grids of a .vdb. Whatever is truncated, damaged or foreign gives Error
/// (Fault::input) naming the file: the seal, if there is one, is checked before parsing; sizes are bounded by
/// VdbLimits and by the file's length; the parser runs on a stream that throws at its end.
VdbFile read_vdb(const std::string& path, const VdbLimits& limits = {});

}  // namespace splinevox
