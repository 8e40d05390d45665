// SPDX-License-Identifier: Apache-2.0
#include "train/effects/halves.hpp"

#include <algorithm>

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
  std::vector<char> hold(n, 0);
  for (int i = 0; i < held_out; ++i) hold[(2 * i + 1) * n / (2 * held_out)] = 1;
  std::vector<int> kept, others, chosen;
  for (int i = 0; i < n; ++i) (hold[i] ? kept : others).push_back(stretch.frames[i]);
  for (int i = 0; i < fitted; ++i) chosen.push_back(others[std::size_t(i) * others.size() / fitted]);
  const auto take = [&](const std::vector<int>& frames, Split& out) {
    out.name = train.name;
    out.frames.resize(frames.size());
    parallel_for(int(frames.size()), [&](int i) {
      const Frame& f = train.frames[frames[i]];
      const int factor =
          std::max(1, (std::max(f.camera.width, f.camera.height) + kPictureSize - 1) / kPictureSize);
      out.frames[i] = {f.name, area_downscale(f.camera, factor), (f.time - stretch.start) / stretch.length,
                       area_downscale(f.image.unpacked(), factor)};
      out.frames[i].ignored = area_downscale(f.ignored, factor);
    });
    std::erase_if(out.frames, [](const Frame& f) { return f.ignored.all(); });
  };
  Halves out;
  take(chosen, out.fitted);
  take(kept, out.held_out);
  return out;
}

}  // namespace splinevox
