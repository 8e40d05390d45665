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
#include "splinevox/data/image_io.hpp"
#include "train/by_time.hpp"

namespace splinevox {
namespace {

constexpr int kPictureSize = 128;     // pixels, at most: what is asked is coarse
constexpr int kMostHeldOut = 20;      // pictures
constexpr int kMostFitted = 60;       // by the fits
constexpr std::size_t kStretch = 80;  // moments of a long sequence that tell how many control points it needs
constexpr std::size_t kLong = 3 * kStretch;  // moments

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

/// Frames at the size of the fits, in the time of a stretch. @param frames  keeps those that are taken
Split taken(const Split& train, std::vector<int>& frames, const Stretch& stretch) {
  Split out{train.name, std::vector<Frame>(frames.size())};
  parallel_for(int(frames.size()), [&](int i) {
    const Frame& f = train.frames[frames[i]];
    const ReadAll all_of(f.image);
    const int factor =
        std::max(1, (std::max(f.camera.width, f.camera.height) + kPictureSize - 1) / kPictureSize);
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
  if (moments.size() <= kLong) return {};
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
  const int n = int(stretch.frames.size()), held_out = std::min(kMostHeldOut, n / 5),
            fitted = std::min(kMostFitted, n - held_out);
  std::vector<char> hold(n, 0);
  for (const int i : one_of_each_part(train, stretch.frames, held_out, 0.5)) hold[i] = 1;
  std::vector<int> kept, others, chosen;
  for (int i = 0; i < n; ++i) (hold[i] ? kept : others).push_back(stretch.frames[i]);
  for (const int i : one_of_each_part(train, others, fitted, 0)) chosen.push_back(others[i]);
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
