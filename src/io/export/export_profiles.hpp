// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace splinevox {

/// What is written beside the frames of a sequence.
enum class ExportSidecar { none, blender_script, usd_stage };

/// What a frame is: the grids of a VDB in one of two files, or Gaussians in one of two.
enum class FrameFormat { vdb, nvdb, splat_ply, splat_spz };
inline bool holds_splats(FrameFormat format) {
  return format == FrameFormat::splat_ply || format == FrameFormat::splat_spz;
}

/// What a host program expects of a sequence. Content is the same everywhere; names and placement differ.
struct ExportProfile {
  const char *name, *density, *color;
  const char* velocity;  ///< null: the host has no use for it
  const char* flame;     ///< null: the host has no room for it
  /// Added to the grids' origin, in voxels. OpenVDB and most hosts put a value at its index; Cycles reads it
  /// half a voxel further on every axis, so its files are shifted back (tests/io/blender_accept.cpp).
  double shift;
  ExportSidecar sidecar;
  FrameFormat format = FrameFormat::vdb;

  bool stores_half() const { return format == FrameFormat::vdb; }
};

/// Throws Error (Fault::input) listing the names if there is no such profile.
const ExportProfile& find_profile(const std::string& name);

}  // namespace splinevox
