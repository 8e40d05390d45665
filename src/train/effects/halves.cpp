// SPDX-License-Identifier: Apache-2.0
#include "train/effects/halves.hpp"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "core/parallel.hpp"
#include "core/rng.hpp"
#include "splinevox/data/image_io.hpp"
#include "train/by_time.hpp"
#include "train/learn_cameras.hpp"

namespace splinevox {
namespace {

constexpr int kPictureSize = 128;     // pixels, at most: what is asked is coarse
constexpr int kMostHeldOut = 20;      // pictures
constexpr int kMostFitted = 60;       // by the fits
constexpr std::size_t kStretch = 80;  // moments of a long sequence that tell how many control points it needs
constexpr std::size_t kLong = 3 * kStretch;  // moments

/// `count` of the numbers 0 to n - 1, one of each of as many equal parts: at a share of the part or, if
/// drawn, at random. In a rig the frames of every moment have the same order of cameras, so numbers at even
/// distances may all be of one camera.
std::vector<int> one_of_each_part(int n, int count, double share, bool drawn) {
  std::vector<int> out(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    const int first = int(std::int64_t(i) * n / count), last = int(std::int64_t(i + 1) * n / count);
    out[std::size_t(i)] = drawn ? first + int(hash64(std::uint64_t(i)) % std::uint64_t(last - first))
                                : int((i + share) * n / count);
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
  Stretch out{frames_by_time(train)};
  std::vector<double> moments;
  for (const int f : out.frames) moments.push_back(train.frames[f].time);
  moments.erase(std::unique(moments.begin(), moments.end()), moments.end());
  if (moments.size() <= kLong) return {};
  const std::size_t first = (moments.size() - kStretch) / 2;
  const double start = moments[first], end = moments[first + kStretch - 1];
  std::erase_if(out.frames,
                [&](int f) { return train.frames[f].time < start || train.frames[f].time > end; });
  out.start = start;
  out.length = end - start;
  return out;
}

Halves divide(const Split& train, const Stretch& stretch) {
  const int n = int(stretch.frames.size()), held_out = std::min(kMostHeldOut, n / 5),
            fitted = std::min(kMostFitted, n - held_out);
  const bool of_rig = taken_by(train) == TakenBy::rig;
  std::vector<char> hold(n, 0);
  for (const int i : one_of_each_part(n, held_out, 0.5, of_rig)) hold[i] = 1;
  std::vector<int> kept, others, chosen;
  for (int i = 0; i < n; ++i) (hold[i] ? kept : others).push_back(stretch.frames[i]);
  for (const int i : one_of_each_part(int(others.size()), fitted, 0, of_rig)) chosen.push_back(others[i]);
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
  const auto thin = [](std::vector<int>& frames, int most) {
    if (int(frames.size()) <= most) return;
    std::vector<int> chosen;
    for (const int i : one_of_each_part(int(frames.size()), most, 0, true)) chosen.push_back(frames[i]);
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
