// SPDX-License-Identifier: Apache-2.0
#include "io/export/export_folder.hpp"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <set>
#include <string_view>

#include "core/own_folder.hpp"
#include "io/export/frame_file.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox {
namespace {

namespace fs = std::filesystem;

/// Whether a name begins and ends as those of an export's frames do.
bool named_as_frame(const std::string& name) {
  constexpr const char *kBegins[] = {"frame_", "mesh_", "cluster_"},
                       *kEnds[] = {".vdb", ".nvdb", ".ply", ".spz", ".obj", ".glb", ".usda"};
  return std::any_of(std::begin(kBegins), std::end(kBegins),
                     [&](const char* b) { return name.starts_with(b); }) &&
         std::any_of(std::begin(kEnds), std::end(kEnds), [&](const char* e) { return name.ends_with(e); });
}

std::string value_of(const ExportInfo& info, const std::string& key) {
  const auto found = info.find(key);
  return found == info.end() ? "none" : found->second;
}

/// Those of `info` that `other` does not have alike, as "fps 24, profile usd".
std::string where_other(const ExportInfo& info, const ExportInfo& other) {
  std::set<std::string> keys;
  for (const auto& [key, value] : info) keys.insert(key);
  for (const auto& [key, value] : other) keys.insert(key);
  std::string text;
  for (const std::string& key : keys)
    if (value_of(info, key) != value_of(other, key))
      text += (text.empty() ? "" : ", ") + key + " " + value_of(info, key);
  return text;
}

/// Whether the two differ in nothing but the times of their frames.
bool same_but_times(ExportInfo a, ExportInfo b) {
  for (const char* key : {"at", "fps", "seconds"}) {
    a.erase(key);
    b.erase(key);
  }
  return a == b;
}

[[noreturn]] void refuse(const std::string& folder, const ExportInfo& there, const ExportInfo& asked) {
  std::string hint = "another --out, or --afresh to replace what is there";
  if (same_but_times(there, asked))
    hint = "--at " + value_of(there, "at") + " --seconds " + value_of(there, "seconds") + " --fps " +
           value_of(there, "fps") + " for more frames of the shot that is there; " + hint;
  if (value_of(there, "model") != value_of(asked, "model"))
    hint += "; its model is not the run's present one";
  fail({.where = folder,
        .what = "holds an export with other settings, which this one would overwrite",
        .expected = where_other(there, asked),
        .got = where_other(asked, there),
        .hint = hint});
}

/// Files of a list that belong to no frame and are not among `names`. A list may come from a stranger:
/// exports write into the folder itself, and a path within it could lead out of it.
std::vector<ManifestFile> beside_frames(const Manifest& list, const std::vector<std::string>& names) {
  std::vector<ManifestFile> files;
  for (const ManifestFile& file : list.files)
    if (frame_of(file) < 0 && file.name.find('/') == file.name.npos &&
        std::find(names.begin(), names.end(), file.name) == names.end())
      files.push_back(file);
  return files;
}

/// The first of `names` that is beside exports of ours and somebody else's; "": none is.
/// @param there  names of what is in the folder  @param listed  names in lists of ours
std::string first_foreign(const std::string& folder, const std::vector<std::string>& there,
                          const std::vector<std::string>& names, const std::set<std::string>& listed) {
  const std::set<std::string_view> present(there.begin(), there.end());
  const auto foreign = [&](const std::string& name) {
    return present.contains(name) && name.ends_with(".vdb") && !listed.contains(name) &&
           !made_by_us((fs::path(folder) / name).string());
  };
  const auto found = std::find_if(names.begin(), names.end(), foreign);
  return found == names.end() ? "" : *found;
}

}  // namespace

std::optional<Manifest> export_list(const std::string& folder, const std::string& name) {
  try {
    Manifest manifest = read_manifest(folder, name);
    if (manifest.kind == "export") return manifest;
  } catch (const Error&) {  // none, or not one of ours: nothing is kept
  }
  return {};
}

void make_export_folder(const std::string& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error || !fs::is_directory(folder))
    fail_output({.where = folder,
                 .what = "is not a folder and cannot be made one",
                 .expected = "a folder to write to",
                 .got = error ? error.message() : "a file",
                 .hint = "choose another --out"});
  check_own_folder(folder, Depth::entries);
}

EarlierExports claim_export_folder(const std::string& folder, const ExportInfo& info,
                                   const std::vector<std::string>& names_of_export,
                                   const std::string& partial, bool replace) {
  const ExportInfo asked = settings_of(info);
  // Before any list is read: whoever writes here at the same time has a list before it has a file.
  const std::vector<std::string> there_before = names_in_folder(folder);
  bool ours = false, listed = false;
  std::vector<std::string> names = partial_manifests(folder);
  names.push_back(kManifestName);
  EarlierExports earlier;
  std::set<std::string> known;
  for (const std::string& name : names) {
    const std::optional<Manifest> list = export_list(folder, name);
    const bool stands = std::find(there_before.begin(), there_before.end(), name) != there_before.end();
    std::error_code unread;  // another share may have removed it meanwhile
    if (!list && stands && !replace && fs::exists(fs::path(folder) / name, unread))
      fail({.where = (fs::path(folder) / name).string(),
            .what = "is no list of an export that this program can read, and would be overwritten",
            .expected = "a folder of its own, or one with what earlier exports wrote",
            .got = name,
            .hint = "another --out, or --afresh to replace what is there"});
    if (!list) continue;
    ours = true;
    const ExportInfo there = settings_of(list->info);
    const bool nothing = list->files.empty();  // of an export that was refused after all
    if (there != asked && !replace && !nothing) refuse(folder, there, asked);
    if (there != asked) {
      if (nothing && name != kManifestName)
        remove_quietly(folder, name);
      else if (name != kManifestName && name != partial)
        earlier.lists.push_back(name);
      const std::vector<ManifestFile> beside = beside_frames(*list, names_of_export);
      earlier.replaced.insert(earlier.replaced.end(), beside.begin(), beside.end());
      continue;
    }
    listed = true;
    for (const ManifestFile& file : list->files)
      if (known.insert(file.name).second) earlier.files.push_back(file);
  }
  const std::string taken = replace ? ""
                            : ours  ? first_foreign(folder, there_before, names_of_export, known)
                                    : first_taken(there_before, names_of_export);
  if (!taken.empty())
    fail({.where = folder,
          .what = "holds a file that this would overwrite, and no list of an export says whose it is",
          .expected = "a folder of its own, or one with what earlier exports wrote",
          .got = taken,
          .hint = "another --out, or --afresh to replace what is there"});
  if (!listed) write_manifest(folder, {"export", info, {}}, partial);
  return earlier;
}

std::string partial_name(const Share& share) {
  if (share.whole()) return kPartialManifestName;
  return "manifest.partial." + std::to_string(share.index + 1) + "of" + std::to_string(share.count) + ".json";
}

bool intact(const std::string& folder, const ManifestFile& file, bool by_size) {
  std::error_code none;
  if (by_size) return fs::file_size(fs::path(folder) / file.name, none) == file.digest.size && !none;
  try {
    return manifest_entry(folder, file.name).digest == file.digest;
  } catch (const Error&) {
    return false;
  }
}

int frame_of(const ManifestFile& file) {
  const auto frame = file.figures.find("frame");
  return frame == file.figures.end() ? -1 : int(frame->second);
}

ExportInfo settings_of(ExportInfo info) {
  info.erase(kExportRun);
  return info;
}

std::vector<int> frames_in(const Manifest& manifest) {
  std::set<int> frames;
  for (const ManifestFile& file : manifest.files)
    if (frame_of(file) >= 0) frames.insert(frame_of(file));
  return {frames.begin(), frames.end()};
}

void sort_by_frame(std::vector<ManifestFile>& files) {
  const auto place = [](const ManifestFile& file) { return unsigned(frame_of(file)); };  // -1 is the last
  std::stable_sort(files.begin(), files.end(),
                   [&](const ManifestFile& a, const ManifestFile& b) { return place(a) < place(b); });
}

std::vector<std::string> other_frames(const std::string& folder, const Manifest& manifest) {
  std::set<std::string> listed;
  for (const ManifestFile& file : manifest.files) listed.insert(file.name);
  std::vector<std::string> others;
  for (const std::string& name : names_in_folder(folder))
    if (named_as_frame(name) && listed.count(name) == 0) others.push_back(name);
  std::sort(others.begin(), others.end());
  return others;
}

void remove_quietly(const std::string& folder, const std::string& name) {
  std::error_code ignored;
  fs::remove(fs::path(folder) / name, ignored);
}

void remove_replaced(const std::string& folder, const EarlierExports& earlier) {
  for (const ManifestFile& file : earlier.replaced)
    if (intact(folder, file)) remove_quietly(folder, file.name);
  for (const std::string& list : earlier.lists) remove_quietly(folder, list);
}

}  // namespace splinevox
