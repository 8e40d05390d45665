// SPDX-License-Identifier: Apache-2.0
#include "cli/export_info.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <optional>

#include "cli/vdb_info.hpp"
#include "io/export/export_folder.hpp"

namespace splinevox::cli {
namespace {

/// The list of a finished export, or those of one that has not ended as one. None: this is no export.
std::optional<Manifest> whole_list(const std::string& folder, bool& finished) {
  std::optional<Manifest> all = export_list(folder, kManifestName);
  finished = all.has_value();
  if (finished) return all;
  for (const std::string& name : partial_manifests(folder)) {
    std::optional<Manifest> list = export_list(folder, name);
    if (!list || (all && settings_of(all->info) != settings_of(list->info))) continue;
    if (!all) all = Manifest{list->kind, list->info, {}};
    for (ManifestFile& file : list->files)
      if (!all->find(file.name)) all->files.push_back(std::move(file));
  }
  if (all) sort_by_frame(all->files);
  return all;
}

/// The smallest or the largest of a figure over all files.
template <class Choose>
std::optional<double> over(const Manifest& list, const std::string& figure, const Choose& choose) {
  std::optional<double> out;
  for (const ManifestFile& file : list.files)
    if (const auto found = file.figures.find(figure); found != file.figures.end())
      out = out ? choose(*out, found->second) : found->second;
  return out;
}

Json box_of(const Manifest& list) {
  Json lo = Json::array(), hi = Json::array();
  for (const char* axis : {"x", "y", "z"}) {
    const auto min =
        over(list, std::string("min_") + axis, [](double a, double b) { return std::min(a, b); });
    const auto max =
        over(list, std::string("max_") + axis, [](double a, double b) { return std::max(a, b); });
    if (!min || !max) return {};
    lo.push_back(*min);
    hi.push_back(*max);
  }
  return {lo, hi};
}

std::vector<int> missing(const std::vector<int>& frames) {
  std::vector<int> out;
  for (std::size_t i = 1; i < frames.size(); ++i)
    for (int f = frames[i - 1] + 1; f < frames[i]; ++f) out.push_back(f);
  return out;
}

std::string text_of(const Json& j, const char* key) { return j.value(key, std::string()); }

}  // namespace

std::string frames_text(const std::vector<int>& frames) {
  std::string text;
  for (std::size_t i = 0; i < frames.size();) {
    std::size_t end = i + 1;
    while (end < frames.size() && frames[end] == frames[end - 1] + 1) ++end;
    text += fmt::format("{}{}", text.empty() ? "" : ", ", frames[i]);
    if (end > i + 1) text += fmt::format("-{}", frames[end - 1]);
    i = end;
  }
  return text;
}

std::optional<Json> export_json(const std::string& folder) {
  bool finished = false;
  const std::optional<Manifest> found_list = whole_list(folder, finished);
  if (!found_list) return {};
  const Manifest& list = *found_list;
  Json j{{"export", folder}, {"finished", finished}};
  for (const char* key : {"profile", kExportRun, "model"})
    if (const auto found = list.info.find(key); found != list.info.end()) j[key] = found->second;
  for (const char* key : {"at", "fps", "seconds"})
    if (const auto found = list.info.find(key); found != list.info.end())
      j[key] = numbers(found->second, ',', folder + "/" + kManifestName + ", " + key, "a number").at(0);
  const std::vector<int> frames = frames_in(list);
  j["frames"] = frames;
  j["missing"] = missing(frames);
  const auto first = over(list, "time", [](double a, double b) { return std::min(a, b); });
  const auto last = over(list, "time", [](double a, double b) { return std::max(a, b); });
  if (first && last) j["times"] = {*first, *last};
  if (Json box = box_of(list); !box.empty()) j["box"] = std::move(box);
  double bytes = 0, of_frames = 0;
  Json beside = Json::array();
  for (const ManifestFile& file : list.files) {
    bytes += double(file.digest.size);
    if (frame_of(file) < 0)
      beside.push_back(file.name);
    else
      of_frames += double(file.digest.size);
  }
  j["bytes"] = bytes;
  j["bytes_a_frame"] = of_frames / double(std::max<std::size_t>(1, frames.size()));
  j["files"] = list.files.size();
  j["beside"] = std::move(beside);
  j["settings"] = list.info;
  j["others"] = other_frames(folder, list);
  for (const ManifestFile& file : list.files)
    if (file.name.ends_with(".vdb") && frame_of(file) >= 0) {
      const Json vdb = vdb_json(folder + "/" + file.name);
      j["grids_of"] = file.name;
      j["grids"] = vdb["grids"];
      break;
    }
  return j;
}

void print_export(const Json& j) {
  const auto frames = j["frames"].get<std::vector<int>>(), gaps = j["missing"].get<std::vector<int>>();
  fmt::print("{}: {} frames ({}), {:.2f} MB, {:.2f} MB a frame, profile {}{}\n", text_of(j, "export"),
             frames.size(), frames_text(frames), j["bytes"].get<double>() / 1e6,
             j["bytes_a_frame"].get<double>() / 1e6, text_of(j, "profile"),
             j["finished"].get<bool>() ? "" : "; not finished: the same command goes on with it");
  if (!gaps.empty()) fmt::print("frames in between that are not there: {}\n", frames_text(gaps));
  if (j.contains("times"))
    fmt::print(
        "they show times {:.4g} to {:.4g}; the whole motion, 0 to 1, takes {:.4g} s from frame {} on, {} "
        "frames a second\n",
        j["times"][0].get<double>(), j["times"][1].get<double>(), j.value("seconds", 0.0), j.value("at", 0.0),
        j.value("fps", 0.0));
  if (const std::string run = text_of(j, kExportRun); !run.empty()) fmt::print("of the run {}\n", run);
  if (j.contains("box")) {
    const auto lo = j["box"][0].get<std::vector<double>>(), hi = j["box"][1].get<std::vector<double>>();
    fmt::print("matter lies in ({:.4g}, {:.4g}, {:.4g}) to ({:.4g}, {:.4g}, {:.4g}), scene units\n", lo[0],
               lo[1], lo[2], hi[0], hi[1], hi[2]);
  }
  if (!j["beside"].empty())
    fmt::print("beside the frames: {}\n", fmt::join(j["beside"].get<std::vector<std::string>>(), ", "));
  if (!j["others"].empty())
    fmt::print("not of this sequence: {} files, {} and so on\n", j["others"].size(),
               j["others"][0].get<std::string>());
  if (j.contains("grids")) {
    fmt::print("grids of {}:\n", text_of(j, "grids_of"));
    print_grids(j["grids"]);
  }
}

}  // namespace splinevox::cli
