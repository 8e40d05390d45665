// SPDX-License-Identifier: Apache-2.0
#include "data/rig_cameras.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "data/times/names.hpp"
#include "data/times/seen_moments.hpp"

namespace splinevox::data {
namespace {

namespace fs = std::filesystem;

/// Of frames whose cameras have no names, the share that must be of poses with several moments. Where a way
/// closes, its first and last poses are one, and that makes no rig.
constexpr double kLeastLasting = 0.25;

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

/// What the data's names of cameras can be taken for.
struct Names {
  bool last = false;  ///< every frame has one, and some took several moments
  bool told = false;  ///< and few are in two places at one time
};
/// COLMAP's numbers are of lenses, which cameras share, or of single pictures.
Names names_in(const std::vector<RawSplit>& splits) {
  std::map<std::pair<std::string, double>, Stand> places;
  std::set<std::pair<std::string, double>> twice;
  std::map<std::string, std::set<double>> moments;
  Names out;
  for (const RawSplit& split : splits)
    for (const RawFrame& f : split.frames) {
      if (f.camera.empty()) return {};
      const Stand stand = stand_of(f);
      if (places.try_emplace({f.camera, f.time}, stand).first->second != stand)
        twice.insert({f.camera, f.time});
      std::set<double>& of_camera = moments[f.camera];
      of_camera.insert(f.time);
      out.last |= of_camera.size() > 1;
    }
  out.told = out.last && 2 * twice.size() <= places.size();
  return out;
}

/// The cameras by their names or, without, by their poses. None: no rig.
std::vector<RigCamera> cameras_by(bool named, std::vector<RawSplit>& splits) {
  const auto each = [&](const auto& act) {
    for (RawSplit& split : splits)
      for (RawFrame& frame : split.frames) act(frame);
  };
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
  std::size_t all = 0, lasting = 0;  // frames, and those of cameras that took several moments
  each([&](const RawFrame& f) {
    ++all;
    lasting += moments[std::size_t(f.camera_id)].size() > 1;
  });
  if (lasting == 0 || (!named && double(lasting) < kLeastLasting * double(all))) {
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

}  // namespace

std::vector<RigCamera> settle_cameras(std::vector<RawSplit>& splits) {
  const Names names = names_in(splits);
  std::vector<RigCamera> cameras = cameras_by(names.told, splits);
  if (cameras.empty() && names.last) cameras = cameras_by(true, splits);
  return cameras;
}

std::vector<int> cameras_to_hold_out(const RawSplit& split, const std::vector<RigCamera>& cameras) {
  constexpr std::size_t kFewest = 5, kEvery = 8;
  if (cameras.size() < kFewest) return {};
  std::set<double> moments;
  std::vector<std::set<double>> seen(cameras.size());
  std::vector<Vec3d> places(cameras.size());
  for (const RawFrame& frame : split.frames) {
    moments.insert(frame.time);
    seen.at(std::size_t(frame.camera_id)).insert(frame.time);
    places[std::size_t(frame.camera_id)] = frame.pose.position;
  }
  const std::vector<double> shares = shares_of_moments(seen, moments);
  std::vector<int> order;
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    if (!cameras[c].still || shares[c] < kLastingShare) return {};
    order.push_back(int(c));
  }
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return natural_less(cameras[std::size_t(a)].name, cameras[std::size_t(b)].name);
  });
  const std::size_t parts = std::max<std::size_t>(1, order.size() / kEvery);
  std::vector<int> held_out;
  for (std::size_t part = 0; part < parts; ++part) {
    const std::size_t first = part * order.size() / parts, last = (part + 1) * order.size() / parts;
    Vec3d middle{};
    for (std::size_t i = first; i < last; ++i)
      middle += (1 / double(last - first)) * places[std::size_t(order[i])];
    const auto off = [&](std::size_t i) { return length(places[std::size_t(order[i])] - middle); };
    double furthest = 1e-30;
    for (std::size_t i = first; i < last; ++i) furthest = std::max(furthest, off(i));
    const auto rank =
        [&](std::size_t i) {  // in a ring all are equally far: then it is the middle one in order
          return std::pair(std::round(1e4 * off(i) / furthest),
                           std::abs(2 * double(i) + 1 - double(first + last)));
        };
    std::size_t best = first;
    for (std::size_t i = first + 1; i < last; ++i)
      if (rank(i) < rank(best)) best = i;
    held_out.push_back(order[best]);
  }
  std::sort(held_out.begin(), held_out.end());
  return held_out;
}

}  // namespace splinevox::data
