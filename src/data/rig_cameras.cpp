// SPDX-License-Identifier: Apache-2.0
#include "data/rig_cameras.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>
#include <string>

namespace splinevox::data {
namespace {

namespace fs = std::filesystem;

/// Pose and lens, rounded so that what a program wrote twice is the same.
using Stand = std::vector<double>;

Stand stand_of(const RawFrame& frame) {
  constexpr double kDigits = 1e6;
  Stand out;
  for (int i = 0; i < 12; ++i) out.push_back(std::round(kDigits * frame.matrix[std::size_t(i)]));
  const Lens& lens = frame.lens;
  for (const auto& value : {lens.fl_x, lens.fl_y, lens.camera_angle_x, lens.cx, lens.cy})
    out.push_back(std::round(1e3 * value.value_or(0)));
  return out;
}

/// What the files of a camera's pictures say of it: a film, or the folder that they have to themselves.
std::string file_name_of(const RawFrame& frame) {
  const fs::path path(frame.file_path);
  if (frame.film_frame >= 0) return path.stem().string();
  fs::path folder = path.parent_path();
  if (folder.filename() == "images") folder = folder.parent_path();
  return folder == "." ? "" : folder.filename().string();
}

}  // namespace

std::vector<RigCamera> settle_cameras(std::vector<RawSplit>& splits) {
  const auto each = [&](const auto& act) {
    for (RawSplit& split : splits)
      for (RawFrame& frame : split.frames) act(frame);
  };
  bool named = true;
  each([&](const RawFrame& f) { named &= !f.camera.empty(); });
  std::vector<RigCamera> cameras;
  std::vector<std::set<double>> moments;
  std::vector<Stand> stands;
  std::vector<std::set<std::string>> files;
  std::map<std::string, int> by_name;
  std::map<Stand, int> by_stand;
  each([&](RawFrame& f) {
    const Stand stand = stand_of(f);
    const auto [at, fresh] = named ? [&] {
      const auto r = by_name.try_emplace(f.camera, int(cameras.size()));
      return std::pair(r.first->second, r.second);
    }() : [&] {
      const auto r = by_stand.try_emplace(stand, int(cameras.size()));
      return std::pair(r.first->second, r.second);
    }();
    f.camera_id = at;
    if (fresh) {
      cameras.push_back({f.camera, true});
      moments.emplace_back();
      stands.push_back(stand);
      files.emplace_back();
    }
    const auto c = std::size_t(at);
    cameras[c].still &= stand == stands[c];
    moments[c].insert(f.time);
    files[c].insert(file_name_of(f));
  });
  const bool rig = std::any_of(moments.begin(), moments.end(), [](const auto& m) { return m.size() > 1; });
  if (!rig) {
    each([](RawFrame& f) { f.camera_id = -1; });
    return {};
  }
  std::map<std::string, int> owners;  // of folders and films
  for (const auto& names : files)
    for (const std::string& name : names) ++owners[name];
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    cameras[c].still &= moments[c].size() > 1;
    if (named) continue;
    const std::string& file = *files[c].begin();
    const bool own = files[c].size() == 1 && owners[file] == 1 && !file.empty();
    cameras[c].name = own ? file : "camera " + std::to_string(c);
  }
  return cameras;
}

}  // namespace splinevox::data
