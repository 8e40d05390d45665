// SPDX-License-Identifier: Apache-2.0
#include "train/effects/halves.hpp"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <iterator>
#include <map>
#include <set>
#include <utility>

#include "core/parallel.hpp"
#include "core/squares.hpp"
#include "splinevox/data/image_io.hpp"
#include "train/by_time.hpp"
#include "train/learn_cameras.hpp"

namespace splinevox {
namespace {

constexpr int kPictureSize = 128;  // pixels, at most: what is asked is coarse
constexpr int kMostHeldOut = 20;   // pictures
constexpr int kMostFitted = 60;    // by the fits, but for a rig of many cameras:
constexpr int kOfACamera = 3;      // make it one whose gain is learned (rig_of)
constexpr std::size_t kMostCameras = 40;
constexpr std::size_t kStretch = 80;  // moments of a long sequence that tell how many control points it needs

/// `count` of some frames in order of time, by their places in the list: one of each of as many equal parts,
/// of the camera that was taken least often so far and, of those, nearest to a share of the part. In a rig
/// the frames of every moment have the same order of cameras, so frames at even distances might all be of
/// one.
std::vector<int> one_of_each_part(const Split& train, const std::vector<int>& frames, int count,
                                  double share) {
  const auto n = std::int64_t(frames.size());
  std::map<int, int> taken;  // of each camera
  std::vector<int> out;
  for (int i = 0; i < count; ++i) {
    const int first = int(i * n / count), last = int((i + 1) * n / count),
              middle = int((i + share) * double(n) / count);
    const auto rank = [&](int at) {
      return std::pair(taken[train.frames[frames[at]].camera_id], std::abs(at - middle));
    };
    int best = middle;
    for (int at = first; at < last; ++at)
      if (rank(at) < rank(best)) best = at;
    ++taken[train.frames[frames[best]].camera_id];
    out.push_back(best);
  }
  return out;
}

/// The cameras of a rig whose gains a fit may learn, of so many frames; none: it is no rig.
std::vector<int> trained_cameras(const Split& train, const std::vector<int>& frames) {
  const CameraFits rig = rig_of(train);
  std::set<int> ids;
  for (const int f : frames)
    if (const int id = train.frames[f].camera_id; rig.knows(id)) ids.insert(id);
  return {ids.begin(), ids.end()};
}

/// Without the frames of some cameras, evenly among them, where a rig has very many.
std::vector<int> of_some_cameras(const Split& train, std::vector<int> frames) {
  const std::vector<int> ids = trained_cameras(train, frames);
  if (ids.size() <= kMostCameras) return frames;
  std::set<int> others(ids.begin(), ids.end());
  for (std::size_t i = 0; i < kMostCameras; ++i) others.erase(ids[i * ids.size() / kMostCameras]);
  std::erase_if(frames, [&](int f) { return others.contains(train.frames[f].camera_id); });
  return frames;
}

/// Of each camera of a rig so many frames, by their places in the list of all, in order of time: evenly over
/// its own, and those of one camera between those of the last.
std::vector<int> some_of_each_camera(const Split& train, const std::vector<int>& frames, int each) {
  std::map<int, std::vector<int>> own;
  for (int i = 0; i < int(frames.size()); ++i) own[train.frames[frames[i]].camera_id].push_back(i);
  std::vector<int> out;
  double shift = 0;
  for (const auto& [camera, at] : own) {
    const int count = std::min(each, int(at.size()));
    for (int k = 0; k < count; ++k) out.push_back(at[std::size_t((k + shift) * double(at.size()) / count)]);
    shift += 1 / double(own.size());
  }
  std::sort(out.begin(), out.end());
  return out;
}

/// The places of those frames that the fits take.
std::vector<int> fitted_of(const Split& train, const std::vector<int>& frames) {
  if (kOfACamera * int(trained_cameras(train, frames).size()) > kMostFitted)
    return some_of_each_camera(train, frames, kOfACamera);
  return one_of_each_part(train, frames, std::min(kMostFitted, int(frames.size())), 0);
}

/// Frames at the size of the fits, in the time of a stretch. @param frames  keeps those that are taken
Split taken(const Split& train, std::vector<int>& frames, const Stretch& stretch) {
  Split out{train.name, std::vector<Frame>(frames.size())};
  parallel_for(int(frames.size()), [&](int i) {
    const Frame& f = train.frames[frames[i]];
    const ReadAll all_of(f.image);
    const int factor = block_factor(f.camera.width, f.camera.height, kPictureSize);
    out.frames[i] = {f.name, area_downscale(f.camera, factor), (f.time - stretch.start) / stretch.length,
                     area_downscale(f.image, factor), f.camera_id};
    out.frames[i].ignored = area_downscale(f.ignored, factor);
    out.frames[i].depth = f.depth;
    out.frames[i].tracks = f.tracks;
    for (VisiblePoint& p : out.frames[i].tracks) {
      p.u /= float(factor);
      p.v /= float(factor);
    }
    const Camera& camera = out.frames[i].camera;  // rows and columns that fill no whole pixel are left out
    std::erase_if(out.frames[i].tracks, [&](const VisiblePoint& p) {
      return !(p.u < float(camera.width) && p.v < float(camera.height));
    });
  });
  const std::vector<Frame> all = std::exchange(out.frames, {});
  std::vector<int> left;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i].ignored.all()) continue;
    out.frames.push_back(all[i]);
    left.push_back(frames[i]);
  }
  frames = left;
  return out;
}

}  // namespace

std::optional<Stretch> middle_stretch(const Split& train) {
  const std::set<double> moments = moments_of(train);
  if (moments.size() <= kLongSequence) return {};
  const auto first = std::next(moments.begin(), std::ptrdiff_t(moments.size() - kStretch) / 2);
  const double start = *first, end = *std::next(first, kStretch - 1);
  Stretch out{frames_by_time(train)};
  std::erase_if(out.frames,
                [&](int f) { return train.frames[f].time < start || train.frames[f].time > end; });
  out.start = start;
  out.length = end - start;
  return out;
}

Halves divide(const Split& train, const Stretch& stretch) {
  const std::vector<int> frames = of_some_cameras(train, stretch.frames);
  const int n = int(frames.size()), held_out = std::min(kMostHeldOut, n / 5);
  std::vector<char> hold(n, 0);
  for (const int i : one_of_each_part(train, frames, held_out, 0.5)) hold[i] = 1;
  std::vector<int> kept, others, chosen;
  for (int i = 0; i < n; ++i) (hold[i] ? kept : others).push_back(frames[i]);
  for (const int i : fitted_of(train, others)) chosen.push_back(others[i]);
  Halves out;
  out.fitted = taken(train, chosen, stretch);
  out.held_out = taken(train, kept, stretch);
  out.held_out_frames = kept;
  return out;
}

Halves divide_cameras(const Split& train) {
  constexpr std::size_t kFewestCameras = 5;
  std::vector<int> ids;
  for (const Frame& f : train.frames)
    if (f.camera_id >= 0) ids.push_back(f.camera_id);
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  Halves out;
  if (ids.size() < kFewestCameras) return out;
  const std::size_t held = ids.size() / kFewestCameras;
  std::vector<int> kept_cameras;
  for (std::size_t i = 0; i < held; ++i) kept_cameras.push_back(ids[(2 * i + 1) * ids.size() / (2 * held)]);
  std::vector<int> kept, others;
  for (const int f : frames_by_time(train)) {
    const auto at = std::find(kept_cameras.begin(), kept_cameras.end(), train.frames[f].camera_id);
    (at != kept_cameras.end() ? kept : others).push_back(f);
  }
  const auto thin = [&](std::vector<int>& frames, int most) {
    if (int(frames.size()) <= most) return;
    std::vector<int> chosen;
    for (const int i : one_of_each_part(train, frames, most, 0)) chosen.push_back(frames[i]);
    frames = std::move(chosen);
  };
  thin(kept, kMostHeldOut);
  thin(others, kMostFitted);
  out.fitted = taken(train, others, {});
  out.held_out = taken(train, kept, {});
  out.held_out_frames = kept;
  return out;
}

Split some_of_each(const Split& train, int cameras, int most) {
  std::vector<std::vector<int>> of(static_cast<std::size_t>(cameras));
  for (int f = 0; f < int(train.frames.size()); ++f)
    if (const int c = train.frames[f].camera_id; c >= 0 && c < cameras) of[std::size_t(c)].push_back(f);
  std::vector<int> chosen;
  for (const std::vector<int>& own : of) {
    const std::size_t count = std::min(own.size(), std::size_t(most));
    for (std::size_t i = 0; i < count; ++i) chosen.push_back(own[i * own.size() / count]);
  }
  return taken(train, chosen, {});
}

}  // namespace splinevox
