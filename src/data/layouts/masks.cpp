// SPDX-License-Identifier: Apache-2.0
#include "data/layouts/masks.hpp"

#include <algorithm>
#include <map>
#include <set>

#include "data/layouts/folder_list.hpp"
#include "data/message_text.hpp"
#include "data/pictures/picture_header.hpp"

namespace splinevox::data {
namespace {

namespace fs = std::filesystem;

constexpr const char* kLookedFor =
    "'mask_path' in a transforms file; a folder masks, mask or seg in the data set, beside the pictures or "
    "beside their folder; NAME_mask.png, dynamic_mask_NAME.png or NAME.png.png beside a picture";

/// A file that may be a picture's mask.
struct Candidate {
  fs::path folders;  ///< in which it lies within the folder of masks
  std::string path;  ///< in the data set
};
/// By the pictures' names without endings.
using MaskNames = std::map<std::string, std::vector<Candidate>>;

std::string without_endings(fs::path name) {
  while (kind_of(name) != FileKind::other) name = name.stem();
  return name.string();
}

/// All pictures of a folder of masks and of the folders in it.
void add_masks(const fs::path& folder, const fs::path& inside, const fs::path& below, MaskNames& masks,
               int depth = 0) {
  for (const std::string& name : files_in(folder / inside / below, FileKind::picture)) {
    const Candidate candidate{below, (inside / below / name).generic_string()};
    const std::string of = mask_of(name), own = without_endings(name);
    masks[of].push_back(candidate);
    if (own != of) masks[own].push_back(candidate);  // the word may be part of the picture's own name
  }
  constexpr int kDeepestMask = 2;
  if (depth < kDeepestMask)
    for (const std::string& name : folders_in(folder / inside / below))
      if (std::error_code ignored; !fs::is_symlink(folder / inside / below / name, ignored))
        add_masks(folder, inside, below / name, masks, depth + 1);
}

/// Masks in a folder: those among its pictures, and folders of masks in it.
MaskNames masks_of(const fs::path& folder, const fs::path& inside) {
  MaskNames masks;
  const std::vector<std::string> all = files_in(folder / inside, FileKind::picture);
  const MaskedNames pictures(all);
  for (const std::string& name : all)
    if (pictures.is_mask(name)) masks[mask_of(name)].push_back({{}, (inside / name).generic_string()});
  for (const std::string& name : folders_in(folder / inside))
    if (std::error_code ignored; is_mask_folder(name) && !fs::is_symlink(folder / inside / name, ignored))
      add_masks(folder, inside / name, {}, masks);
  return masks;
}

std::set<std::string> parts_of(const fs::path& folder) {
  std::set<std::string> parts;
  for (const fs::path& part : folder) parts.insert(part.string());
  return parts;
}

bool same_size(const fs::path& mask, const fs::path& picture) {
  try {
    return read_picture_header(mask).size == read_picture_header(picture).size;
  } catch (const Error&) {
    return false;
  }
}

/// The masks that fit a picture best: by as many folders as possible, none of which is another picture's, and
/// then by their size.
std::vector<std::string> best_of(const std::vector<Candidate>& candidates, const fs::path& root,
                                 const fs::path& picture, const fs::path& picture_file,
                                 const std::set<std::string>& of_pictures) {
  const std::set<std::string> own = parts_of(picture.parent_path());
  std::vector<std::string> best;
  int most = -1;
  for (const Candidate& candidate : candidates) {
    int shared = 0;
    bool of_other = false;
    for (const std::string& part : parts_of(candidate.folders)) {
      shared += own.contains(part) ? 1 : 0;
      of_other |= !own.contains(part) && of_pictures.contains(part);
    }
    if (of_other || shared < most) continue;
    if (shared > most) best.clear();
    most = shared;
    best.push_back(candidate.path);
  }
  if (best.size() > 1)
    if (std::vector<std::string> fit = best;
        std::erase_if(fit, [&](const std::string& m) { return !same_size(root / m, picture_file); }) > 0 &&
        !fit.empty())
      return fit;
  return best;
}

}  // namespace

bool MaskUse::keeps_black(const fs::path& mask) const {
  if (kept != Kept::by_name) return kept == Kept::black;
  return is_dynamic_mask(mask);
}

bool is_dynamic_mask(const fs::path& mask) {
  return lower_case(mask.filename().string()).starts_with("dynamic_mask");
}

MaskUse parse_masks(const std::string& text) {
  using What = MaskUse::What;
  using Kept = MaskUse::Kept;
  for (const MaskUse& use : {MaskUse{"", What::unsaid, Kept::white},
                             {"none", What::none, Kept::white},
                             {"subject", What::subject, Kept::white},
                             {"subject-black", What::subject, Kept::black},
                             {"ignore", What::ignore, Kept::by_name},
                             {"ignore-white", What::ignore, Kept::black},
                             {"ignore-black", What::ignore, Kept::white},
                             {"moving", What::moving, Kept::black},
                             {"moving-black", What::moving, Kept::white}})
    if (use.text == text) return use;
  fail({"--masks", "there is no such use of masks",
        "subject, subject-black, ignore, ignore-white, ignore-black, moving, moving-black or none",
        in_quotes(text), ""});
}

std::optional<MaskSearch> masks_of_alpha(RawScene& scene, MaskUse& use) {
  if (!scene.alpha_ignores || !(use.what == MaskUse::What::unsaid || use.text == "ignore")) return {};
  const RawFrame& first = scene.splits.at(0).frames.at(0);
  if (!read_picture_header(first.found, printable(first.file_path)).alpha) return {};
  MaskSearch search;
  search.first = first.file_path;
  for (RawSplit& split : scene.splits)
    for (RawFrame& frame : split.frames) {
      frame.mask = frame.file_path;
      frame.mask_file = frame.found;
      search.found = ++search.frames;
    }
  scene.notes.push_back(
      "alpha is taken for that of DyCheck, which says where depth was measured: --masks none takes it for "
      "what "
      "the scene covers");
  use = {"ignore", MaskUse::What::ignore, MaskUse::Kept::white, true};
  return search;
}

MaskSearch find_masks(const fs::path& root, RawScene& scene) {
  MaskSearch search;
  std::map<std::string, MaskNames> of_folder;
  std::set<std::string> of_pictures, pictures;
  for (const RawSplit& split : scene.splits)
    for (const RawFrame& frame : split.frames) {
      of_pictures.merge(parts_of(fs::path(frame.file_path).lexically_normal().parent_path()));
      pictures.insert(frame.found.string());
    }
  std::map<std::string, fs::path> taken;  // by name alone: the folder of the picture
  for (RawSplit& split : scene.splits)
    for (RawFrame& frame : split.frames) {
      ++search.frames;
      search.of_films += frame.film_frame >= 0 ? 1 : 0;
      const bool named = !frame.mask.empty();
      const fs::path picture = fs::path(frame.file_path).lexically_normal();
      const bool within = !picture.is_absolute() && (picture.empty() || *picture.begin() != "..");
      if (!named && within && frame.film_frame < 0)
        for (const fs::path& inside :
             {picture.parent_path(), picture.parent_path().parent_path(), fs::path()}) {
          const auto [found, fresh] = of_folder.try_emplace(inside.generic_string());
          if (fresh) found->second = masks_of(root, inside);
          const auto of_name = found->second.find(without_endings(picture.filename()));
          if (of_name == found->second.end()) continue;
          std::vector<std::string> best = best_of(of_name->second, root, picture, frame.found, of_pictures);
          // A picture in a folder such as images_masked is none.
          std::erase_if(best,
                        [&](const std::string& mask) { return pictures.contains((root / mask).string()); });
          if (best.empty()) continue;
          frame.mask = best[0];
          if (best.size() > 1 && ++search.several == 1)
            search.first_several = in_quotes(best[0]) + " and " + in_quotes(best[1]);
          break;
        }
      if (frame.mask.empty()) continue;
      const std::optional<fs::path> file = file_within(root, frame.mask);
      if (!file) {
        if (++search.absent == 1) search.first_absent = frame.mask;
        continue;
      }
      frame.mask_file = *file;
      if (++search.found == 1) search.first = frame.mask;
      if (!named) {
        const auto [of, fresh] = taken.try_emplace(frame.mask, picture.parent_path());
        if (!fresh && of->second != picture.parent_path() && search.shared.empty())
          search.shared = in_quotes(frame.mask) + " for " +
                          in_quotes((of->second / picture.filename()).string()) + " and " +
                          in_quotes(picture.string());
      }
    }
  return search;
}

void require_masks(RawScene& scene, const MaskUse& use, const MaskSearch& search, const DatasetRules& rules) {
  if (!use.used()) return;
  const std::string asked = "--masks " + use.text;
  if (search.found == 0) {
    const bool films = search.of_films == search.frames;
    fail({scene.splits.at(0).file, asked + " was asked for, but no picture has a mask", kLookedFor,
          films               ? "films, whose masks are not read"
          : search.absent > 0 ? in_quotes(search.first_absent) + " is named and is not there"
                              : "none of them",
          films ? "decode the films to a folder of pictures per camera, and their masks to masks/CAMERA"
                : ""});
  }
  if (!search.shared.empty())
    fail({scene.splits.at(0).file, "one mask is for several pictures by its name",
          "a folder of masks per camera, named as the camera's folder, or 'mask_path' per frame",
          search.shared, ""});
  const auto has_none = [&](RawFrame& frame, const std::string& where) -> std::optional<Error> {
    if (!frame.mask_file.empty()) return {};
    return Error({where, "the picture has no mask", kLookedFor,
                  frame.mask.empty() ? "none of " + in_quotes(frame.file_path)
                                     : in_quotes(frame.mask) + ", which is not there",
                  ""},
                 Fault::input);
  };
  if (use.what == MaskUse::What::subject || rules.missing == "refuse") {
    leave_out(scene, rules, has_none, "pictures have no mask and are");
  } else if (search.found < search.frames) {
    std::string first;
    for (const RawSplit& split : scene.splits)
      for (std::size_t i = 0; i < split.frames.size() && first.empty(); ++i)
        if (split.frames[i].mask_file.empty()) first = in_quotes(split.frames[i].file_path);
    scene.notes.push_back(
        std::to_string(search.frames - search.found) + " of " + std::to_string(search.frames) +
        " pictures have no mask: " +
        (use.what == MaskUse::What::moving ? "all of them may move" : "nothing of them is ignored") +
        ", such as " + first);
  }
}

}  // namespace splinevox::data
