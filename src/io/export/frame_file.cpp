// SPDX-License-Identifier: Apache-2.0
#include "io/export/frame_file.hpp"

#include "core/atomic_file.hpp"
#include "io/splat/voxel_splats.hpp"
#include "io/vdb/nvdb_write.hpp"

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

}  // namespace splinevox
