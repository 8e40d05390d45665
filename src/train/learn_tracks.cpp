// SPDX-License-Identifier: Apache-2.0
#include "train/learn_tracks.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

#include "core/rng.hpp"
#include "math/camera.hpp"
#include "render/field_view.hpp"
#include "splinevox/core/error.hpp"
#include "train/film/moving_tracks.hpp"

namespace splinevox {
namespace {

constexpr std::size_t kPart = 8;                   ///< rays of a batch for one of tracks
constexpr std::uint64_t kPoints = 1, kStarts = 2;  ///< random streams

/// A point in the picture of a slot.
struct Sight {
  int slot;
  VisiblePoint at;
};

}  // namespace

bool has_tracks(const Split& train) {
  return std::any_of(train.frames.begin(), train.frames.end(),
                     [](const Frame& f) { return !f.tracks.empty(); });
}

bool leaves_out_tracks(const StepBackend& steps, const Config& config, const Split& train) {
  return config.loss.tracks > 0 && has_tracks(train) && !steps.learns_tracks();
}

void check_learns_tracks(const StepBackend& steps, const Config& config, const Split& train) {
  if (leaves_out_tracks(steps, config, train))
    fail({"--device", "tracks are learned on the CPU alone so far", "--device cpu",
          "another device, and tracked points", "--set loss.tracks=0 leaves them out"});
}

void draw_tracks(const Split& train, const Batch& batch, const std::vector<char>& moves,
                 const std::vector<CoarseMask>& moving, const Box& box, float step, TrackBatch& out) {
  out = {};
  struct Followed {
    std::vector<Sight> seen;
    bool may_move = false;
  };
  std::map<int, Followed> points;
  for (std::size_t s = 0; s < batch.frames.size(); ++s) {
    const auto f = std::size_t(batch.frames[s]);
    for (const VisiblePoint& p : train.frames[f].tracks) {
      if (!moves[std::size_t(p.point)] || !counts(train.frames[f], p)) continue;
      Followed& followed = points[p.point];
      followed.seen.push_back({int(s), p});
      followed.may_move |= moving.empty() || moving[f].empty() || moving[f].test(int(p.u), int(p.v));
    }
  }
  std::vector<const Followed*> chosen;
  for (const auto& [point, followed] : points)
    if (followed.seen.size() > 1 && followed.may_move) chosen.push_back(&followed);
  const Rng pick(batch.draw, kPoints), start(batch.draw, kStarts);
  std::size_t count = 0, rays = 0;
  while (count < chosen.size() && rays < batch.rays.size() / kPart) {
    std::swap(chosen[count], chosen[count + pick.below(count, std::uint32_t(chosen.size() - count))]);
    rays += chosen[count++]->seen.size();
  }
  // Rays by slot, each point's kept together in of_points.
  std::vector<std::pair<Sight, int>> all;
  for (std::size_t p = 0; p < count; ++p)
    for (const Sight& seen : chosen[p]->seen) all.emplace_back(seen, int(p));
  std::stable_sort(all.begin(), all.end(),
                   [](const auto& a, const auto& b) { return a.first.slot < b.first.slot; });
  for (const auto& [seen, point] : all) {
    const Camera& camera = train.frames[std::size_t(batch.frames[std::size_t(seen.slot)])].camera;
    const int i = int(out.rays.size());
    if (out.tasks.empty() || out.tasks.back().slot != seen.slot || i - out.tasks.back().first == kTaskRays)
      out.tasks.push_back({seen.slot, i, i});
    out.tasks.back().last = i + 1;
    out.rays.push_back(clip_ray(camera_ray(camera, double(seen.at.u), double(seen.at.v)), box, step,
                                start.uniform(std::uint64_t(i)), Vec3{}));
  }
  out.of_points.resize(all.size());
  std::iota(out.of_points.begin(), out.of_points.end(), 0);
  std::stable_sort(out.of_points.begin(), out.of_points.end(),
                   [&](int a, int b) { return all[std::size_t(a)].second < all[std::size_t(b)].second; });
  for (std::size_t k = 0; k < all.size(); ++k)
    if (const int p = all[std::size_t(out.of_points[k])].second; p == int(out.first.size()))
      out.first.push_back(int(k));
  out.first.push_back(int(all.size()));
}

}  // namespace splinevox
