// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "io/export/export_profiles.hpp"
#include "io/export/usd_stage.hpp"
#include "splinevox/io/export_vdb.hpp"

namespace splinevox {

/// What the files of a part are called: "" where there is one, the whole; else "cluster_0_" and so on.
/// @param clusters  how many parts; 0: the whole
std::vector<std::string> part_prefixes(int clusters);
/// "frame_0001.vdb", or as the profile has it.
std::string frame_name(int frame, const ExportProfile& profile);
std::string mesh_name(int frame, const std::string& format);

/// What has to be known of a sequence beside its files.
struct SequenceFacts {
  std::vector<int> frames;  ///< their numbers, in order, at least one
  int clusters = 0;         ///< parts, 0: the whole
  double fps = 24;
  bool linear = false;             ///< colours are scene-linear
  bool velocity = false;           ///< frames hold one
  bool flame = false;              ///< frames hold one
  int sh_order = -1;               ///< of the harmonics that frames hold; -1: none
  Vec3 background{1, 1, 1};        ///< display values
  Vec3 lo{}, hi{};                 ///< a box around everything that is shown, scene units
  std::vector<UsdLayer> layers{};  ///< what is carried
};

/// What the profile wants beside the frames: "load_in_blender.py" or "sequence.usda"; "": nothing.
std::string sidecar_name(const ExportProfile& profile);
/// Writes it. @return an entry for it, or none.
std::vector<ManifestFile> write_sidecar(const std::string& folder, const ExportProfile& profile,
                                        const SequenceFacts& facts);

/// Frames a second of the cameras.usda in a folder; none: there is no such file, or none of ours.
std::optional<double> cameras_rate(const std::string& folder);

enum class CamerasShown { no_stage, yes, other_rate };
/// Makes the stage of a finished export show cameras.usda beside it, if their frames a second are the same:
/// USD would play the frames of others at other times.
/// @return no_stage: the folder has none, or it is not as it was written
CamerasShown show_cameras(const std::string& folder);

}  // namespace splinevox
