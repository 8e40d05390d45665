// SPDX-License-Identifier: Apache-2.0
#include "data/layouts/folder_list.hpp"

#include <algorithm>

#include "data/message_text.hpp"
#include "data/times/names.hpp"

namespace splinevox::data {
namespace {

namespace fs = std::filesystem;

template <class Wanted>
std::vector<std::string> names_in(const fs::path& folder, const Wanted& wanted) {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
    if (wanted(*it)) names.push_back(it->path().filename().string());
  std::sort(names.begin(), names.end(), natural_less);
  return names;
}

bool any_of(std::string_view text, std::initializer_list<std::string_view> words) {
  return std::find(words.begin(), words.end(), text) != words.end();
}

/// What is of that path in a folder, links resolved; none if there is nothing, or it lies elsewhere.
std::optional<fs::path> within(const fs::path& root, const std::string& path) {
  if (path.find('\0') != std::string::npos) return {};
  std::error_code error;
  const fs::path found = fs::weakly_canonical(root / path, error);
  if (error || !fs::exists(found, error)) return {};
  const fs::path relative = found.lexically_relative(root);
  if (relative.empty() || *relative.begin() == "..") return {};
  return found;
}

}  // namespace

std::string lower_case(std::string_view text) {
  std::string low(text);
  std::transform(low.begin(), low.end(), low.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? char(c + 32) : c; });
  return low;
}

FileKind kind_of(const fs::path& file) {
  const std::string end = lower_case(file.extension().string());
  if (any_of(end, {".png", ".jpg", ".jpeg", ".exr", ".tif", ".tiff"})) return FileKind::picture;
  if (any_of(end, {".hdr", ".webp", ".bmp", ".heic", ".heif", ".avif", ".dng", ".ppm", ".tga", ".gif"}))
    return FileKind::other_picture;
  if (any_of(end, {".mp4", ".mov", ".mkv", ".avi", ".webm", ".m4v", ".mpg", ".mpeg", ".mts", ".m2ts", ".ts"}))
    return FileKind::film;
  return FileKind::other;
}

std::string how_to_convert(const fs::path& file) {
  const std::string end = lower_case(file.extension().string());
  if (end == ".hdr")
    return "make PNG of them, with the colours of a screen: for f in *" + end +
           "; do oiiotool \"$f\" --colorconvert linear sRGB -o \"${f%.*}.png\"; done";
  return "make PNG of them: mogrify -format png *" + end;
}

std::vector<std::string> files_in(const fs::path& folder) {
  return names_in(folder, [](const fs::directory_entry& e) {
    std::error_code ignored;
    return e.is_regular_file(ignored);
  });
}

std::vector<std::string> folders_in(const fs::path& folder) {
  return names_in(folder, [](const fs::directory_entry& e) {
    std::error_code ignored;
    return e.is_directory(ignored) && e.path().filename().string()[0] != '.';
  });
}

std::vector<std::string> files_in(const fs::path& folder, FileKind kind) {
  std::vector<std::string> names = files_in(folder);
  std::erase_if(names, [&](const std::string& name) { return kind_of(name) != kind || name[0] == '.'; });
  // Beside pictures of other kinds these are depths, masks or normals.
  const auto rare = [](const std::string& name) {
    return any_of(lower_case(fs::path(name).extension().string()), {".exr", ".tif", ".tiff"});
  };
  if (!std::all_of(names.begin(), names.end(), rare)) std::erase_if(names, rare);
  return names;
}

bool is_mask_folder(const std::string& name) {
  const std::string low = lower_case(name);
  return low.find("mask") != std::string::npos ||
         any_of(low, {"seg", "segs", "segmentation", "segmentations"});
}

std::string mask_of(std::string name) {
  while (kind_of(name) != FileKind::other) name.resize(name.rfind('.'));
  std::string low = lower_case(name);
  for (const std::string_view word : {"dynamic_mask", "masks", "mask"})
    if (const std::size_t at = low.find(word); at != std::string::npos) {
      name.erase(at, word.size());
      low.erase(at, word.size());
      const std::size_t first = name.find_first_not_of("_-."), last = name.find_last_not_of("_-.");
      return first == std::string::npos ? std::string() : name.substr(first, last + 1 - first);
    }
  return name;
}

namespace {

/// A mask's name with a star in place of the picture's; empty for names that are no masks'.
std::string mask_form(const std::string& name) {
  if (kind_of(fs::path(name).stem()) == FileKind::picture) return "*.*.*";
  std::string low = lower_case(name);
  if (low.find("mask") == std::string::npos) return {};
  const std::string picture = lower_case(mask_of(name));
  const std::size_t at = picture.empty() ? std::string::npos : low.find(picture);
  return at == std::string::npos ? std::string() : low.replace(at, picture.size(), "*");
}

}  // namespace

MaskedNames::MaskedNames(const std::vector<std::string>& names) : names_(names.begin(), names.end()) {
  for (const std::string& name : names) stems_.insert(fs::path(name).stem().string());
  for (const std::string& name : names)
    if (const std::string form = mask_form(name); !form.empty() && has_picture(name)) forms_.insert(form);
}

bool MaskedNames::has_picture(const std::string& mask) const {
  const std::string inner = fs::path(mask).stem().string();
  return kind_of(inner) == FileKind::picture ? names_.contains(inner)  // COLMAP's: the whole name and .png
                                             : stems_.contains(mask_of(mask));
}

bool MaskedNames::is_mask(const std::string& name) const {
  const std::string form = mask_form(name);
  return !form.empty() && (forms_.contains(form) || has_picture(name));
}

bool all_named_masks(const std::vector<std::string>& names) {
  return std::none_of(names.begin(), names.end(),
                      [](const std::string& name) { return mask_form(name).empty(); });
}

std::vector<std::string> without_masks(const std::vector<std::string>& names) {
  const MaskedNames all(names);
  std::vector<std::string> rest;
  std::copy_if(names.begin(), names.end(), std::back_inserter(rest),
               [&](const std::string& name) { return !all.is_mask(name); });
  return rest;
}

std::optional<fs::path> file_within(const fs::path& root, const std::string& path) {
  const std::optional<fs::path> inside = within(root, path);
  std::error_code ignored;
  return inside && fs::is_regular_file(*inside, ignored) ? inside : std::nullopt;
}

std::optional<fs::path> folder_within(const fs::path& root, const std::string& path) {
  const std::optional<fs::path> inside = within(root, path);
  std::error_code ignored;
  return inside && fs::is_directory(*inside, ignored) ? inside : std::nullopt;
}

std::string list_of(const std::vector<std::string>& names) {
  constexpr std::size_t kMost = 6;
  std::string text;
  for (std::size_t i = 0; i < std::min(kMost, names.size()); ++i)
    text += (i ? ", " : "") + in_quotes(names[i]);
  if (names.size() > kMost) text += " and " + std::to_string(names.size() - kMost) + " more";
  return text.empty() ? "nothing" : text;
}

}  // namespace splinevox::data
