// SPDX-License-Identifier: Apache-2.0
#include "run/correspondence.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <unordered_map>

#include "core/parallel.hpp"
#include "math/quantile.hpp"
#include "splinevox/field/sample.hpp"

namespace splinevox::run {
namespace {

/// Points in cells of the search radius.
class PointGrid {
 public:
  PointGrid(const std::vector<Vec3>& points, float radius) : points_(points), radius_(radius) {
    for (std::size_t i = 0; i < points.size(); ++i) cells_[key(cell(points[i]))].push_back(int(i));
  }
  /// The nearest point within the radius; -1: none.
  int nearest(const Vec3& p) const {
    int best = -1;
    float reach = radius_;
    const Int3 c = cell(p);
    for (int x = -1; x <= 1; ++x)
      for (int y = -1; y <= 1; ++y)
        for (int z = -1; z <= 1; ++z) {
          const auto found = cells_.find(key({c.x + x, c.y + y, c.z + z}));
          if (found == cells_.end()) continue;
          for (const int i : found->second)
            if (const float d = length(points_[i] - p); d < reach) {
              best = i;
              reach = d;
            }
        }
    return best;
  }

 private:
  Int3 cell(const Vec3& p) const {
    const auto index = [&](float v) { return int(std::floor(v / radius_)); };
    return {index(p.x), index(p.y), index(p.z)};
  }
  static std::uint64_t key(const Int3& c) {
    const auto bits = [](int v) { return std::uint64_t(v + (1 << 20)) & ((1u << 21) - 1); };
    return bits(c.x) << 42 | bits(c.y) << 21 | bits(c.z);
  }
  const std::vector<Vec3>& points_;
  float radius_;
  std::unordered_map<std::uint64_t, std::vector<int>> cells_;
};

/// One surface point of a frame that is visible in another one too.
struct Pair {
  int point;  ///< of the frame
  int other;  ///< of the other frame
};

/// What one frame adds to the score.
struct Tally {
  std::vector<float> canonical, tracked, tracked_far;
  std::size_t folded = 0, still = 0, still_moved = 0, moving = 0, moving_missed = 0;
};

Distances distances(std::vector<float> values) {
  if (values.empty()) return {};
  return {values.size(), quantile(values, 0.5), quantile(values, 0.9)};
}

class Scorer {
 public:
  Scorer(const VoxelModel& model, const std::vector<SurfaceFrame>& frames, std::size_t per_frame)
      : model_(model), frames_(frames), per_frame_(per_frame) {
    edge_ = model.box.longest_edge();
    for (const SurfaceFrame& f : frames) {
      grids_.emplace_back(f.rest, float(kSameRest) * edge_);
      samplers_.push_back(std::make_unique<FrameSampler>(model, f.time));
    }
  }
  float edge() const { return edge_; }
  float voxel() const { return model_.radiance.raw.topology->lattice.spacing; }

  Tally score(int f) const {
    const SurfaceFrame& here = frames_[f];
    const std::size_t n = here.rest.size(),
                      stride = std::max<std::size_t>(1, n / std::max<std::size_t>(1, per_frame_));
    std::vector<std::vector<Pair>> pairs(frames_.size());  // [other frame]
    std::vector<Vec3> points;
    Tally out;
    for (std::size_t i = 0; i < n; i += stride) {
      points.push_back(here.position[i]);
      float path = 0;  // how far from here the surface point ever is
      int seen = 0;
      for (std::size_t g = 0; g < frames_.size(); ++g) {
        if (int(g) == f) continue;
        const int other = grids_[g].nearest(here.rest[i]);
        if (other < 0) continue;
        pairs[g].push_back({int(points.size()) - 1, other});
        path = std::max(path, length(frames_[g].position[other] - here.position[i]));
        ++seen;
      }
      compare(f, here.position[i], seen > 0 && path < 2 * kSameRest * edge_, pairs, int(points.size()) - 1,
              out);
    }
    follow(f, points, pairs, out);
    return out;
  }

 private:
  /// Canonical places and displacements of one point (its pairs are the last of each list) at the times it is
  /// visible.
  void compare(int f, const Vec3& x, bool still, const std::vector<std::vector<Pair>>& pairs, int point,
               Tally& out) const {
    const Vec3 here = samplers_[f]->warp(x).displacement;
    for (std::size_t g = 0; g < frames_.size(); ++g) {
      if (pairs[g].empty() || pairs[g].back().point != point) continue;
      const Vec3 y = frames_[g].position[pairs[g].back().other];
      const Vec3 there = samplers_[g]->warp(y).displacement;
      out.canonical.push_back(length(x + here - (y + there)));
      if (still) {
        ++out.still;
        out.still_moved += length(samplers_[g]->warp(x).displacement - here) > 0.5f * voxel();
      } else if (length(x - y) > kTrulyMoves * edge_) {
        ++out.moving;
        out.moving_missed += length(here - there) < 0.5f * voxel();
      }
    }
  }

  void follow(int f, const std::vector<Vec3>& points, const std::vector<std::vector<Pair>>& pairs,
              Tally& out) const {
    std::vector<double> times;
    for (const SurfaceFrame& g : frames_) times.push_back(g.time);
    const auto tracked = track(model_, points, frames_[f].time, times);
    for (std::size_t g = 0; g < frames_.size(); ++g) {
      const bool far = std::abs(times[g] - times[f]) >= kFar;
      for (const Pair& p : pairs[g]) {
        const TrackedPoint& t = tracked[g][p.point];
        out.tracked.push_back(length(t.position - frames_[g].position[p.other]));
        if (far) out.tracked_far.push_back(out.tracked.back());
        out.folded += t.folded;
      }
    }
  }

  const VoxelModel& model_;
  const std::vector<SurfaceFrame>& frames_;
  std::size_t per_frame_;
  float edge_;
  std::vector<PointGrid> grids_;
  std::vector<std::unique_ptr<FrameSampler>> samplers_;
};

}  // namespace

MotionScore score_motion(const VoxelModel& model, const std::vector<SurfaceFrame>& frames,
                         std::size_t per_frame) {
  const Scorer scorer(model, frames, per_frame);
  std::vector<Tally> tallies(frames.size());
  parallel_for(int(frames.size()), [&](int f) { tallies[f] = scorer.score(f); });
  Tally all;
  for (const Tally& t : tallies) {
    all.canonical.insert(all.canonical.end(), t.canonical.begin(), t.canonical.end());
    all.tracked.insert(all.tracked.end(), t.tracked.begin(), t.tracked.end());
    all.tracked_far.insert(all.tracked_far.end(), t.tracked_far.begin(), t.tracked_far.end());
    all.folded += t.folded;
    all.still += t.still;
    all.still_moved += t.still_moved;
    all.moving += t.moving;
    all.moving_missed += t.moving_missed;
  }
  const auto share = [](std::size_t part, std::size_t whole) {
    return whole ? double(part) / double(whole) : kNoPairs;
  };
  MotionScore out;
  out.edge = scorer.edge();
  out.voxel = scorer.voxel();
  out.canonical = distances(std::move(all.canonical));
  out.folded = share(all.folded, all.tracked.size());
  out.tracked = distances(std::move(all.tracked));
  out.tracked_far = distances(std::move(all.tracked_far));
  out.still_pairs = all.still;
  out.still_moved = share(all.still_moved, all.still);
  out.moving_pairs = all.moving;
  out.moving_missed = share(all.moving_missed, all.moving);
  return out;
}

}  // namespace splinevox::run
