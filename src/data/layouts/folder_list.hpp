// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace splinevox::data {

/// Text with its ASCII letters in lower case.
std::string lower_case(std::string_view text);

/// What a file is by its name's ending, whatever its case.
enum class FileKind {
  picture,        ///< PNG or JPEG, which are read
  other_picture,  ///< EXR, TIFF, WebP ..., which are not
  film,           ///< a container that ffmpeg reads
  other
};
FileKind kind_of(const std::filesystem::path& file);

/// What to do with pictures that are not read: a command that makes PNG of such a file.
std::string how_to_convert(const std::filesystem::path& file);

/// Names of what lies in a folder, in the order in which people count; none if it cannot be read.
/// @{
std::vector<std::string> files_in(const std::filesystem::path& folder);
std::vector<std::string> folders_in(const std::filesystem::path& folder);
std::vector<std::string> files_in(const std::filesystem::path& folder, FileKind kind);
/// @}

/// Whether a folder of this name holds masks: "mask" is in it, or it is called "seg" or "segmentation".
bool is_mask_folder(const std::string& name);

/// The name, without endings, of the picture that a mask is for: "frame_1" for "frame_1_mask.png",
/// "frame_1.png.png", "dynamic_mask_frame_1.png" and "frame_1.png".
std::string mask_of(std::string name);

/// Pictures of one folder, among which masks of the others may lie.
class MaskedNames {
 public:
  explicit MaskedNames(const std::vector<std::string>& names);
  /// Whether it has the word "mask", or two endings, and the picture it is for is one of the others, or is
  /// missing while another name of this form is a mask.
  bool is_mask(const std::string& name) const;

 private:
  bool has_picture(const std::string& mask) const;
  std::set<std::string> names_, stems_, forms_;
};
/// Whether all names are such as masks have, and none is there that they could be for.
bool all_named_masks(const std::vector<std::string>& names);
/// The names without those that are masks.
std::vector<std::string> without_masks(const std::vector<std::string>& names);

/// The regular file, or the folder, of that path in a folder, links resolved; none if there is none, or it
/// lies elsewhere.
/// @param root  the folder in canonical form
/// @{
std::optional<std::filesystem::path> file_within(const std::filesystem::path& root, const std::string& path);
std::optional<std::filesystem::path> folder_within(const std::filesystem::path& root,
                                                   const std::string& path);
/// @}

/// Names for a message: the first few in quotes, and how many there are.
std::string list_of(const std::vector<std::string>& names);

}  // namespace splinevox::data
