// SPDX-License-Identifier: Apache-2.0
#include "run/first_sight.hpp"

#include <algorithm>
#include <cmath>

#include "core/squares.hpp"
#include "run/camera_ways.hpp"
#include "run/compositing.hpp"
#include "splinevox/data/image_io.hpp"
#include "splinevox/render/render_image.hpp"

namespace splinevox::run {
namespace {

constexpr int kMoments = 12;
constexpr int kSmall = 64;        // longest side of a picture that only a silhouette is taken from
constexpr double kNearly = 0.95;  // of the largest silhouette
constexpr int kOrbitSize = 400;   // as the viewer's own camera has it (camera.js)

Camera within(const Camera& camera, int size) {
  return area_downscale(camera, block_factor(camera.width, camera.height, size));
}

std::vector<FirstSight> at_moments(const Camera& camera) {
  std::vector<FirstSight> out;
  for (int i = 0; i < kMoments; ++i) out.push_back({-1, {camera, (i + 0.5) / kMoments}});
  return out;
}

bool on_one_side(const TrainingCameras* train) { return train && train->stand != Stand::around; }

std::vector<FirstSight> candidates(const VoxelModel& model, const std::vector<TrueShot>& shots,
                                   const TrainingCameras* train) {
  if (on_one_side(train)) {
    const Shot& middle = central(train->places);
    if (train->stand == Stand::few || train->stand == Stand::one) return at_moments(middle.camera);
    return {{-1, middle}};
  }
  if (shots.empty()) return at_moments(orbit(model.box, CameraRequest().elevation, kOrbitSize, 1).front());
  std::vector<FirstSight> out;
  for (std::size_t i = 0; i < shots.size(); ++i) out.push_back({int(i), {shots[i].camera, shots[i].time}});
  return out;
}

double silhouette(const Image& alpha) {
  double all = 0, edge = 0;
  for (int y = 0; y < alpha.height; ++y)
    for (int x = 0; x < alpha.width; ++x) {
      const double a = *alpha.pixel(x, y);
      all += a;
      if (x == 0 || y == 0 || x == alpha.width - 1 || y == alpha.height - 1) edge += a;
    }
  const double round = 2.0 * (alpha.width + alpha.height) - 4;
  return all / double(alpha.pixels()) - edge / std::max(round, 1.0);
}

}  // namespace

FirstSight first_sight(const VoxelModel& model, const std::vector<TrueShot>& shots,
                       const TrainingCameras* train, int size) {
  std::vector<FirstSight> all = candidates(model, shots, train);
  Renderer renderer(model);
  std::vector<double> seen;
  for (const FirstSight& c : all)
    seen.push_back(
        all.size() > 1 ? silhouette(renderer.render(within(c.shot.camera, kSmall), c.shot.time).alpha) : 0);
  const double most = *std::max_element(seen.begin(), seen.end());
  const double enough = most - (1 - kNearly) * std::abs(most);
  std::size_t best = all.size();
  for (std::size_t i = 0; i < all.size(); ++i) {
    const auto from_middle = [&](std::size_t k) { return std::abs(all[k].shot.time - 0.5); };
    if (seen[i] >= enough && (best == all.size() || from_middle(i) < from_middle(best))) best = i;
  }
  FirstSight& chosen = all[best];
  const Camera camera = within(chosen.shot.camera, size);
  const Rendered r = renderer.render(camera, chosen.shot.time);
  const bool clear = std::any_of(shots.begin(), shots.end(), [](const TrueShot& s) { return s.clear; });
  chosen.poster = encode_png(clear ? without_background(model, r, camera) : r.rgb);
  return std::move(chosen);
}

std::optional<FirstSight> plain_sight(const std::vector<TrueShot>& shots, const TrainingCameras* train) {
  if (on_one_side(train)) return FirstSight{-1, central(train->places)};
  if (shots.empty()) return {};
  return FirstSight{0, {shots[0].camera, shots[0].time}};
}

}  // namespace splinevox::run
