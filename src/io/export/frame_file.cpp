// SPDX-License-Identifier: Apache-2.0
#include "io/export/frame_file.hpp"

#include <fstream>

#include "core/atomic_file.hpp"
#include "io/splat/voxel_splats.hpp"
#include "io/vdb/nvdb_write.hpp"
#include "io/vdb/vdb_cursor.hpp"
#include "io/vdb/vdb_scan.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox {

FileDigest write_frame(const ExportProfile& profile, const std::string& path, VdbFile grids, int sh_order,
                       std::map<std::string, double>& figures) {
  if (profile.format == FrameFormat::vdb) return write_vdb(path, std::move(grids));
  if (profile.format == FrameFormat::nvdb) return write_nvdb(path, std::move(grids));
  const bool ply = profile.format == FrameFormat::splat_ply;
  const VoxelSplats splats = voxel_splats(grids, sh_order, ply ? SplatAxes::scene : SplatAxes::upright);
  figures["splats"] = double(splats.places.size());
  return write_file(path, {ply ? splat_ply(splats) : splat_spz(splats)});
}

bool made_by_us(const std::string& path) {
  constexpr std::streamsize kHead = 4096;  // of ours `creator` is the first entry
  std::string head(kHead, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(head.data(), kHead);
  head.resize(std::size_t(file.gcount()));
  const VdbLimits limits{};
  Cursor cursor(path, head, limits);
  try {
    cursor.skip(kVdbIdOffset + kVdbIdBytes, "the header");
    for (auto n = cursor.take<std::uint32_t>("the metadata count"); n > 0; --n) {
      const std::string_view name = cursor.text("a metadata name");
      cursor.text("a metadata type");
      const std::string_view value = cursor.text("a metadata value");
      if (name == "creator") return value == "splinevox";
    }
  } catch (const Error&) {  // it ends within its head, or is no .vdb
  }
  return false;
}

}  // namespace splinevox
