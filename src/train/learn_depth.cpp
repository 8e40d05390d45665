// SPDX-License-Identifier: Apache-2.0
#include "train/learn_depth.hpp"

#include <algorithm>
#include <cmath>

#include "core/parallel.hpp"
#include "math/camera.hpp"
#include "render/specialise.hpp"
#include "splinevox/core/error.hpp"
#include "train/look.hpp"

namespace splinevox {
namespace {

constexpr std::int64_t kFirstFit = 50;  ///< steps
constexpr double kRays = 400;           ///< of a picture, that it is fitted by
constexpr float kSolid = 0.5f;          ///< alpha from which on a ray shows a surface

bool is_opaque(const Frame& frame, int x, int y) { return frame.image.rgba(x, y)[3] >= 65535; }

/// How much a step along a ray goes along the camera's axis.
double cosine_of(const Camera& camera, const Ray& ray) { return -dot(ray.direction, camera.axes[2]); }

/// Numbers of a picture's map, and the depths (or their inverses) that the model shows there.
struct Pairs {
  std::vector<double> map, shown;
};

template <int Sh>
Pairs pairs_of(const VoxelModel& model, const Frame& frame, double time, const BitGrid& occupied) {
  Look<Sh> look(model, time, &occupied);
  const Camera& camera = frame.camera;
  const ReadAll all_of(frame.image);
  const int stride = std::max(1, int(std::sqrt(double(camera.width) * camera.height / kRays)));
  Pairs out;
  for (int y = stride / 2; y < camera.height; y += stride)
    for (int x = stride / 2; x < camera.width; x += stride) {
      const float number = frame.depth.at(x, y, camera.width, camera.height);
      if (number == 0 || frame.ignored.test(x, y) || !is_opaque(frame, x, y)) continue;
      const Ray ray = camera_ray(camera, x + 0.5, y + 0.5);
      look.along(ray);
      const auto [distance, alpha] = look.distance(ray);
      const double depth = distance * cosine_of(camera, ray);
      if (alpha < kSolid || !(depth > 0)) continue;
      out.map.push_back(number);
      out.shown.push_back(frame.depth.kind() == DepthKind::inverse ? 1 / depth : depth);
    }
  return out;
}

}  // namespace

bool has_depth(const Split& train) {
  return std::any_of(train.frames.begin(), train.frames.end(),
                     [](const Frame& f) { return !f.depth.empty(); });
}

bool leaves_out_depth(const StepBackend& steps, const Config& config, const Split& train) {
  return config.loss.depth > 0 && has_depth(train) && !steps.learns_depth();
}

void check_learns_depth(const StepBackend& steps, const Config& config, const Split& train) {
  if (leaves_out_depth(steps, config, train))
    fail({"--device", "depth maps are learned on the CPU alone so far", "--device cpu",
          "another device, and pictures with depth", "--depth none leaves depth maps out"});
}

DepthFits starting_depth_fits(const Split& train, float weight) {
  if (weight == 0 || !has_depth(train)) return {};
  DepthFits out(train.frames.size());
  for (std::size_t f = 0; f < out.size(); ++f)
    out[f].known = train.frames[f].depth.kind() == DepthKind::metric;
  return out;
}

float depth_weight(const Split& train, float weight) {
  constexpr float kFitted = 0.1f;
  const bool fitted = std::any_of(train.frames.begin(), train.frames.end(), [](const Frame& f) {
    return !f.depth.empty() && f.depth.kind() != DepthKind::metric;
  });
  return fitted ? kFitted * weight : weight;
}

bool depth_fit_is_due(std::int64_t step) {
  std::int64_t due = kFirstFit;
  while (2 * due <= step) due *= 2;
  return step == due || 2 * step == 3 * due;
}

void fit_depths(const Setting& setting, const Volume& volume, const TimeWindow& window, DepthFits& fits) {
  const VoxelModel& model = volume.lattices.model;
  parallel_for(int(window.frames.size()), [&](int i) {
    const auto f = std::size_t(window.frames[std::size_t(i)]);
    const Frame& frame = setting.train.frames[f];
    if (frame.depth.empty() || frame.depth.kind() == DepthKind::metric) return;
    Pairs pairs;
    specialise(model.radiance.sh_order, [&]<int Sh>() {
      const Occupancy& o = volume.occupancy;
      pairs = pairs_of<Sh>(model, frame, volume.cameras.time_of(frame),
                           o.grids()[std::size_t(o.grid_of(int(f)))]);
    });
    const std::optional<Line> line = robust_line(pairs.map, pairs.shown, kDepthWidth);
    fits[f].known = line.has_value();
    if (line) fits[f].line = *line;
  });
}

DepthTarget<float> depth_target(const Frame& frame, int x, int y, const Ray& ray, const DepthFit& fit,
                                const RayInput<float>& clipped, float step) {
  if (!fit.known || frame.depth.empty() || clipped.count == 0 || !is_opaque(frame, x, y)) return {};
  const float number = frame.depth.at(x, y, frame.image.width, frame.image.height);
  if (number == 0) return {};
  double depth = fit.line.at(number);
  if (frame.depth.kind() == DepthKind::inverse) depth = 1 / depth;
  const double distance = depth / cosine_of(frame.camera, ray);
  const double from_start = distance - dot(cast<double>(clipped.origin) - ray.origin, ray.direction);
  if (!(depth > 0) || !std::isfinite(distance) || from_start < 0) return {};
  return {float(std::min(from_start, double(clipped.count) * step)), float(1 / distance)};
}

}  // namespace splinevox
