// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "io/manifest.hpp"
#include "splinevox/io/export_vdb.hpp"

namespace splinevox {

using ExportInfo = std::map<std::string, std::string>;  ///< Manifest::info of an export

/// Keys of ExportInfo that say where an export came from and decide no byte of it.
inline constexpr const char* kExportRun = "run";
/// The settings alone.
ExportInfo settings_of(ExportInfo info);

/// A list of an export in a folder; none: there is no such list, or it is not one of ours.
std::optional<Manifest> export_list(const std::string& folder, const std::string& name);

/// Makes the folder of a sequence. Throws Error (Fault::output).
void make_export_folder(const std::string& folder);

/// The list that an export of a share, or one that has not ended, keeps.
std::string partial_name(const Share& share);

/// What earlier exports into a folder listed, whether they ended or were interrupted, of the whole or of
/// shares.
struct EarlierExports {
  std::vector<ManifestFile> files;  ///< of the same settings; a name once
  /// What those of other settings had beside their frames and the new export does not write. It would show
  /// the new frames as if they were the old ones: see remove_replaced.
  std::vector<ManifestFile> replaced;
  std::vector<std::string> lists;  ///< those of other settings that have not ended
};

/// Takes a folder for an export. From here on it has a list that says whose its files are.
///
/// A folder holds one sequence. Where a list is of other settings, throws Error (Fault::input) that says
/// which differ, unless it lists nothing. Where there is none, a file with one of `names` is somebody else's:
/// it throws as well. Where there is one, files that it does not name may be those of an export that was
/// killed before it listed them: it throws for a .vdb that is not made_by_us(). With `replace` it does
/// neither, and frames of other settings are left alone.
/// @param names  what the export will write  @param partial  partial_name()
EarlierExports claim_export_folder(const std::string& folder, const ExportInfo& info,
                                   const std::vector<std::string>& names, const std::string& partial,
                                   bool replace);

/// A listed file is there and has its checksum. @param by_size  only its size is asked
bool intact(const std::string& folder, const ManifestFile& file, bool by_size = false);

/// The frame that a listed file belongs to, or -1: it is of the sequence.
int frame_of(const ManifestFile& file);

/// Numbers of the frames in a list, each once, in order.
std::vector<int> frames_in(const Manifest& manifest);

/// In the order of their frames; what is of no frame comes last.
void sort_by_frame(std::vector<ManifestFile>& files);

/// Names in the folder that are frames' by their beginning and not in the list: who loads the folder as a
/// sequence would load them too.
std::vector<std::string> other_frames(const std::string& folder, const Manifest& manifest);

void remove_quietly(const std::string& folder, const std::string& name);

/// Removes what belongs to no frame of what is replaced, as far as it is as it was listed: what was changed
/// since is somebody's. Then the lists that name it.
void remove_replaced(const std::string& folder, const EarlierExports& earlier);

}  // namespace splinevox
