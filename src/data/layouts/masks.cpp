// SPDX-License-Identifier: Apache-2.0
#include "data/layouts/masks.hpp"

#include <map>

#include "data/layouts/folder_list.hpp"
#include "data/message_text.hpp"

namespace splinevox::data {
namespace {

namespace fs = std::filesystem;

/// Masks by the pictures' names without endings.
using MaskNames = std::map<std::string, std::string>;

std::string without_endings(fs::path name) {
  while (kind_of(name) != FileKind::other) name = name.stem();
  return name.string();
}

/// All pictures of a folder of masks and of the folders in it.
void add_masks(const fs::path& folder, const fs::path& inside, MaskNames& masks, int depth = 0) {
  for (const std::string& name : files_in(folder / inside, FileKind::picture))
    masks.emplace(mask_of(name), (inside / name).generic_string());
  constexpr int kDeepestMask = 2;
  if (depth < kDeepestMask)
    for (const std::string& name : folders_in(folder / inside))
      if (std::error_code ignored; !fs::is_symlink(folder / inside / name, ignored))
        add_masks(folder, inside / name, masks, depth + 1);
}

/// Masks in a folder: those among its pictures, and folders of masks in it.
MaskNames masks_of(const fs::path& folder, const fs::path& inside) {
  MaskNames masks;
  const std::vector<std::string> all = files_in(folder / inside, FileKind::picture);
  const MaskedNames pictures(all);
  for (const std::string& name : all)
    if (pictures.is_mask(name)) masks.emplace(mask_of(name), (inside / name).generic_string());
  for (const std::string& name : folders_in(folder / inside))
    if (std::error_code ignored; lower_case(name).find("mask") != std::string::npos &&
                                 !fs::is_symlink(folder / inside / name, ignored))
      add_masks(folder, inside / name, masks);
  return masks;
}

}  // namespace

std::optional<std::string> note_on_masks(const fs::path& folder, const RawScene& scene) {
  std::map<std::string, MaskNames> of_folder;
  std::size_t all = 0, masked = 0;
  std::string first;
  for (const RawSplit& split : scene.splits)
    for (const RawFrame& frame : split.frames) {
      ++all;
      std::string mask = frame.mask;
      const fs::path picture = fs::path(frame.file_path).lexically_normal();
      const bool within = !picture.is_absolute() && (picture.empty() || *picture.begin() != "..");
      if (within && frame.film_frame < 0)
        for (const fs::path& inside :
             {picture.parent_path(), picture.parent_path().parent_path(), fs::path()}) {
          if (!mask.empty()) break;
          const auto [found, fresh] = of_folder.try_emplace(inside.generic_string());
          if (fresh) found->second = masks_of(folder, inside);
          const auto of_name = found->second.find(without_endings(picture.filename()));
          if (of_name != found->second.end()) mask = of_name->second;
        }
      if (mask.empty()) continue;
      ++masked;
      if (first.empty()) first = mask;
    }
  if (masked == 0) return {};
  return "masks are not read: " + std::to_string(masked) + " of " + std::to_string(all) +
         " pictures have one, such as " + in_quotes(first);
}

}  // namespace splinevox::data
