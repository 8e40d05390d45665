// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "core/parallel.hpp"
#include "data/synth/view.hpp"
#include "math/camera.hpp"

namespace splinevox::data {
namespace {

constexpr std::size_t kAsked = 8;  ///< pictures whose points are followed
constexpr int kGrid = 24;          ///< points along an edge of those
constexpr double kHidden = 1e-3;   ///< of the distance: what a ray meets so much earlier hides a point

struct Point {
  int body;
  Vec3d rest;
};

}  // namespace

std::vector<std::vector<VisiblePoint>> follow_points(const SynthScene& scene,
                                                     const std::vector<SynthShot>& shots) {
  std::vector<std::size_t> train;
  for (std::size_t i = 0; i < shots.size(); ++i)
    if (shots[i].split == "train") train.push_back(i);
  std::vector<Point> points;
  const std::size_t asked = std::min(kAsked, train.size());
  for (std::size_t k = 0; k < asked; ++k) {
    const SynthShot& shot = shots[train[k * (train.size() - 1) / std::max<std::size_t>(1, asked - 1)]];
    const SynthMoment now = scene.at(shot.time + shot.late);
    for (int y = 0; y < kGrid; ++y)
      for (int x = 0; x < kGrid; ++x)
        if (const auto hit = now.trace(camera_ray(shot.camera, (x + 0.5) * shot.camera.width / kGrid,
                                                  (y + 0.5) * shot.camera.height / kGrid)))
          points.push_back({hit->body, hit->rest});
  }
  std::vector<std::vector<VisiblePoint>> out(shots.size());
  parallel_for(int(train.size()), [&](int t) {
    const std::size_t i = train[std::size_t(t)];
    const Camera& camera = shots[i].camera;
    const SynthMoment now = scene.at(shots[i].time + shots[i].late);
    for (std::size_t p = 0; p < points.size(); ++p) {
      const Vec3d at = now.world_from_rest(points[p].body, points[p].rest);
      const Projection seen = project(camera, at);
      if (!(seen.depth > 0 && seen.u >= 0 && seen.v >= 0 && seen.u < camera.width && seen.v < camera.height))
        continue;
      const auto hit = now.trace(camera_ray(camera, seen.u, seen.v));
      if (hit && hit->along > (1 - kHidden) * length(at - camera.position))
        out[i].push_back({int(p), float(seen.u), float(seen.v)});
    }
  });
  return out;
}

}  // namespace splinevox::data
