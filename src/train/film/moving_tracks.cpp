// SPDX-License-Identifier: Apache-2.0
#include "train/film/moving_tracks.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/parallel.hpp"
#include "math/camera.hpp"
#include "math/nearest_point.hpp"
#include "math/quantile.hpp"

namespace splinevox {
namespace {

constexpr int kFewestSeen = 4;        ///< pictures of a point of which something is said
constexpr int kRounds = 10;           ///< of the robust fit of a place
constexpr double kMissed = 0.75;      ///< quantile of what a point is missed by
constexpr double kLeast = 0.01;       ///< of the picture's longer side: a smaller miss is none
constexpr double kMost = 0.03;        ///< the same: a larger one is one
constexpr double kUsual = 3;          ///< times what points that stand still are missed by
constexpr double kStandStill = 0.25;  ///< quantile of all points
constexpr double kAround = 0.02;      ///< of the longer side, that moves with a point
constexpr std::size_t kNearest = 5;   ///< a point and those beside it

struct Sight {
  const Camera* camera;
  double u, v;
};

double longer_side(const Camera& camera) { return std::max(camera.width, camera.height); }

/// A place far away in the middle of all rays: what explains a point best if its camera stands still.
Vec3d far_place(const std::vector<Ray>& rays) {
  Vec3d origin{}, direction{};
  for (const Ray& ray : rays) {
    origin += (1.0 / double(rays.size())) * ray.origin;
    direction += (1.0 / double(rays.size())) * ray.direction;
  }
  double way = 0;
  for (const Ray& ray : rays) way = std::max(way, length(ray.origin - origin));
  constexpr double kFar = 1e3;  // ways of the camera
  return origin + (way > 0 ? kFar * way : 1.0) * direction;
}

/// By what share of the pictures' longer side the place that fits best misses a point.
double missed_by(const std::vector<Sight>& seen) {
  std::vector<Ray> rays;
  for (const Sight& s : seen) rays.push_back(camera_ray(*s.camera, s.u, s.v));
  Vec3d at = far_place(rays);
  double best = std::numeric_limits<double>::infinity();
  for (int round = 0; round < kRounds; ++round) {
    std::vector<double> misses, weights;
    for (const Sight& s : seen) {
      const Projection p = project(*s.camera, at);
      const double off = std::hypot(p.u - s.u, p.v - s.v) / longer_side(*s.camera);
      misses.push_back(p.depth > 0 && std::isfinite(off) ? off : 1);
      weights.push_back(1 / std::max(p.depth * p.depth, 1e-12));
    }
    std::vector<double> sorted = misses;
    best = std::min(best, quantile(sorted, kMissed));
    const double usual = std::max(quantile(sorted, 0.5), 1e-3 * kLeast);
    double sum = 0;
    for (std::size_t i = 0; i < seen.size(); ++i)
      sum += weights[i] /= 1 + misses[i] * misses[i] / (usual * usual);
    constexpr double kHeld = 1e-9;  // where it was, as far as no ray says another: all may be parallel
    NearestPoint nearest;
    nearest.hold({at.x, at.y, at.z}, kHeld);
    for (std::size_t i = 0; i < seen.size(); ++i) {
      const auto& [o, d] = rays[i];
      nearest.add({d.x, d.y, d.z}, {o.x, o.y, o.z}, weights[i] / sum);
    }
    const Eigen::Vector3d next = nearest.solve();
    at = {next.x(), next.y(), next.z()};
  }
  return best;
}

}  // namespace

std::vector<char> points_that_move(const Split& train) {
  std::vector<std::vector<Sight>> seen;
  for (const Frame& f : train.frames)
    for (const VisiblePoint& p : f.tracks) {
      if (std::size_t(p.point) >= seen.size()) seen.resize(std::size_t(p.point) + 1);
      if (counts(f, p)) seen[std::size_t(p.point)].push_back({&f.camera, double(p.u), double(p.v)});
    }
  std::vector<double> missed(seen.size(), 0);
  parallel_for(int(seen.size()), [&](int p) {
    if (int(seen[std::size_t(p)].size()) >= kFewestSeen)
      missed[std::size_t(p)] = missed_by(seen[std::size_t(p)]);
  });
  std::vector<double> known;
  for (std::size_t p = 0; p < seen.size(); ++p)
    if (int(seen[p].size()) >= kFewestSeen) known.push_back(missed[p]);
  if (known.empty()) return std::vector<char>(seen.size(), 0);
  const double enough = std::clamp(kUsual * quantile(known, kStandStill), kLeast, kMost);
  std::vector<char> out(seen.size());
  for (std::size_t p = 0; p < out.size(); ++p) out[p] = missed[p] > enough;
  return out;
}

PixelMask squares_of_moving(const Frame& frame, const std::vector<char>& moves, int factor) {
  const Camera& camera = frame.camera;
  PixelMask out(camera.width / factor, camera.height / factor);
  const double around = kAround * longer_side(camera);
  for (const VisiblePoint& p : frame.tracks) {
    if (!moves[std::size_t(p.point)] || !counts(frame, p)) continue;
    std::vector<std::pair<float, bool>> others;
    for (const VisiblePoint& q : frame.tracks)
      if (counts(frame, q))
        others.emplace_back((q.u - p.u) * (q.u - p.u) + (q.v - p.v) * (q.v - p.v),
                            moves[std::size_t(q.point)]);
    const std::size_t nearest = std::min(kNearest, others.size());
    std::partial_sort(others.begin(), others.begin() + std::ptrdiff_t(nearest), others.end());
    const auto moving = std::count_if(others.begin(), others.begin() + std::ptrdiff_t(nearest),
                                      [](const auto& other) { return other.second; });
    if (2 * std::size_t(moving) <= nearest) continue;
    const auto square = [&](double at, int squares) { return std::clamp(int(at / factor), 0, squares - 1); };
    for (int y = square(p.v - around, out.height()); y <= square(p.v + around, out.height()); ++y)
      for (int x = square(p.u - around, out.width()); x <= square(p.u + around, out.width()); ++x)
        out.set(std::size_t(y) * std::size_t(out.width()) + std::size_t(x));
  }
  return out;
}

}  // namespace splinevox
