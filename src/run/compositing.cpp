// SPDX-License-Identifier: Apache-2.0
#include "run/compositing.hpp"

#include <algorithm>
#include <vector>

#include "math/camera.hpp"
#include "math/srgb.hpp"
#include "splinevox/field/sample.hpp"

namespace splinevox::run {
namespace {

constexpr float kLeastSeen = 0.05f;  ///< alpha from which a pixel has a place

Ray ray_of(const Camera& camera, std::size_t pixel) {
  const std::size_t width = std::size_t(camera.width);
  return camera_ray(camera, double(pixel % width) + 0.5, double(pixel / width) + 0.5);
}

/// The place that a pixel sees at its depth.
Vec3 place_of(const Camera& camera, std::size_t pixel, float depth) {
  const Ray ray = ray_of(camera, pixel);
  const double along = double(depth) / -dot(ray.direction, camera.axes[2]);
  return cast<float>(ray.origin + along * ray.direction);
}

}  // namespace

Image without_background(const VoxelModel& model, const Rendered& r, const Camera& camera) {
  Image out(r.rgb.width, r.rgb.height, 4);
  for (std::size_t p = 0; p < out.pixels(); ++p) {
    const float alpha = std::clamp(r.alpha.data[p], 0.0f, 1.0f);
    out.data[4 * p + 3] = alpha;
    if (alpha == 0) continue;
    const Vec3 behind = model.behind(ray_of(camera, p));
    for (int c = 0; c < 3; ++c) {
      const float display = (r.rgb.data[3 * p + std::size_t(c)] - (1 - alpha) * behind[c]) / alpha;
      out.data[4 * p + std::size_t(c)] = std::max(0.0f, display);
    }
  }
  return out;
}

VoxelModel nothing_behind(const VoxelModel& model) {
  VoxelModel out = model;
  out.surroundings = {};
  out.background = {.color = {0, 0, 0}};
  return out;
}

Image premultiplied(const Rendered& r) {
  Image out(r.rgb.width, r.rgb.height, 4);
  for (std::size_t p = 0; p < out.pixels(); ++p) {
    const float alpha = std::clamp(r.alpha.data[p], 0.0f, 1.0f);
    out.data[4 * p + 3] = alpha;
    for (std::size_t c = 0; c < 3 && alpha > 0; ++c)
      out.data[4 * p + c] = alpha * srgb_to_linear(std::max(0.0f, r.rgb.data[3 * p + c] / alpha));
  }
  return out;
}

Image depth_layer(const Rendered& r) {
  Image out = r.depth;
  for (std::size_t p = 0; p < out.pixels(); ++p)
    if (!(r.depth.data[p] > 0)) out.data[p] = kEmptyDepth;  // of next to no alpha, too
  return out;
}

Image motion_vectors(const VoxelModel& model, const Rendered& r, const Shot& shot, const Shot& other) {
  std::vector<std::size_t> pixels;
  std::vector<Vec3> places;
  for (std::size_t p = 0; p < r.alpha.pixels(); ++p)
    if (r.alpha.data[p] >= kLeastSeen) {
      pixels.push_back(p);
      places.push_back(place_of(shot.camera, p, r.depth.data[p]));
    }
  std::vector<TrackedPoint> carried;
  if (model.motion.moves() && other.time != shot.time)
    carried = std::move(track(model, places, shot.time, std::vector<double>{other.time})[0]);
  else
    for (const Vec3& place : places) carried.push_back({place, false, 0});
  Image out(r.rgb.width, r.rgb.height, 2);
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    if (carried[i].folded) continue;
    const Projection now = project(shot.camera, cast<double>(places[i]));
    const Projection then = project(other.camera, cast<double>(carried[i].position));
    if (then.depth <= 0) continue;
    out.data[2 * pixels[i]] = float(then.u - now.u);
    out.data[2 * pixels[i] + 1] = float(now.v - then.v);
  }
  return out;
}

}  // namespace splinevox::run
