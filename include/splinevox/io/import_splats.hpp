// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "splinevox/core/vec3.hpp"
#include "splinevox/io/export_vdb.hpp"

namespace splinevox {

/// A PLY of Gaussian splats and the frame it is.
struct SplatFrame {
  int frame = 1;
  std::string path;
};

/// One .ply, or all of a folder in the order of the numbers that their names end in. These are the frames
/// where all names have one; else frames count from 1. Throws Error (Fault::input): there are none, or two of
/// one number.
std::vector<SplatFrame> splat_frames(const std::string& path);

/// Settings of a VDB sequence that is made of splats.
struct ImportOptions {
  std::string profile = "blender";  ///< one of export_profiles() with grids
  double fps = 24;                  ///< frames per second, (0, 1000]
  double voxel_size = 0;            ///< scene units; 0: what suits the splats of the first frame that has any
  double min_alpha = 1e-3;          ///< voxels below this opacity over one voxel are dropped, (0, 1)
  std::string colorspace = "display";  ///< as ExportOptions::colorspace
  bool half = true;                    ///< 16-bit floats
  bool afresh = false;                 ///< in place of an export with other settings
  struct Box {
    Vec3d lo, hi;
  };
  std::optional<Box> box;  ///< scene units; what is outside is left out
  std::string source;      ///< where the splats came from, for the manifest
};

/// Throws Error (Fault::input) naming the option, its range and what was given.
void validate(const ImportOptions& options);

struct ImportResult {
  double voxel_size = 0;
  std::vector<ExportedFrame> frames;  ///< figures: splats, splats_skipped, density_voxels, ...
  std::vector<std::string> others;    ///< as ExportResult::others
  bool finished = false;
};

/// Writes `folder`/frame_0001.vdb and so on with the density and colour of the splats, then what the profile
/// wants beside them and manifest.json: as export_vdb does, but without velocity, which splats do not have.
/// A voxel holds the Gaussians' own integrals. Colours are means over all directions.
/// The same bytes for any number of threads. One frame is in memory at a time. Throws Error: Fault::input for
/// bad options and files, Fault::output if a file cannot be written.
ImportResult import_splats(const std::vector<SplatFrame>& frames, const std::string& folder,
                           const ImportOptions& options, const ExportProgress& progress = {});

}  // namespace splinevox
