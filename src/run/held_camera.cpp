// SPDX-License-Identifier: Apache-2.0
#include "run/held_camera.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <vector>

#include "core/parallel.hpp"
#include "math/camera.hpp"
#include "run/still_places.hpp"
#include "splinevox/field/sample.hpp"
#include "train/effects/film.hpp"

namespace splinevox::run {
namespace {

constexpr std::size_t kCameras = 12;
constexpr int kTimes = 9;

std::vector<double> even_times() {
  std::vector<double> out;
  for (int i = 0; i < kTimes; ++i) out.push_back(double(i) / (kTimes - 1));
  return out;
}

/// How far a surface point goes in a picture, as a share of its width; all of it if it leaves the view.
double shift_of(const Camera& camera, const Vec3d& point, const Vec3& by) {
  const Projection from = project(camera, point), to = project(camera, point + cast<double>(by));
  const double shift = to.depth > 0 ? std::hypot(to.u - from.u, to.v - from.v) / camera.width : 1;
  return std::min(shift, 1.0);
}

double quantile(std::vector<double>& values, double share) {
  const auto nth = values.begin() + std::ptrdiff_t(share * double(values.size() - 1));
  std::nth_element(values.begin(), nth, values.end());
  return *nth;
}

}  // namespace

bool is_film(const VoxelModel& model, const Split& train) {
  const double window = 1.0 / basis_of(model.motion.basis).pieces(model.motion.points);
  return view_told_by_time(train, model.box.center(), window) > kFilm;
}

std::optional<HeldCamera> held_camera_test(const VoxelModel& model, Renderer& renderer, const Split& train,
                                           const Split& held_out) {
  const auto start = std::chrono::steady_clock::now();
  const StillEvidence evidence(train, model.box, model.background.color, even_times());
  std::vector<FrameSampler> at;
  for (const double t : evidence.times()) at.emplace_back(model, t);
  HeldCamera out;
  std::vector<double> shifts;
  std::size_t asked = 0;
  double pixels = 0;
  const std::size_t n = held_out.frames.size(), count = std::min(n, kCameras);
  for (std::size_t i = 0; i < count; ++i) {
    const Frame& frame = held_out.frames[(2 * i + 1) * n / (2 * count)];
    const SmallPicture picture = small_picture(frame, model.background.color);
    const StillPlaces still = evidence.places(picture, frame.ignored);
    asked += still.asked;
    const Image depth = renderer.render(picture.camera, frame.time).depth;
    const FrameSampler own(model, frame.time);
    for (const StillPlace& place : still.places) {
      const Ray ray = camera_ray(picture.camera, place.u, place.v);
      const double along =
          *depth.pixel(int(place.u), int(place.v)) / -dot(ray.direction, picture.camera.axes[2]);
      const Vec3d point = ray.origin + along * ray.direction;
      const Vec3 surface = cast<float>(point), here = own.warp(surface).displacement;
      for (const int t : place.times)
        shifts.push_back(
            along > 0 ? shift_of(picture.camera, point, at[std::size_t(t)].warp(surface).displacement - here)
                      : 0);
    }
    pixels += double(frame.camera.width) / double(count);
    ++out.cameras;
  }
  if (shifts.size() < kFewestPlaces) return {};
  out.places = shifts.size();
  out.proved_share = double(shifts.size()) / double(asked);
  out.median_share = quantile(shifts, 0.5);
  out.p95_share = quantile(shifts, 0.95);
  out.median = pixels * out.median_share;
  out.p95 = pixels * out.p95_share;
  out.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return out;
}

Json held_camera_json(const HeldCamera& t) {
  return {{"cameras", t.cameras},
          {"places", t.places},
          {"proved_share", t.proved_share},
          {"median_pixels", t.median},
          {"p95_pixels", t.p95},
          {"median_percent", 100 * t.median_share},
          {"p95_percent", 100 * t.p95_share},
          {"seconds", t.seconds}};
}

std::string held_camera_line(const HeldCamera& t) {
  return fmt::format(
      "still part, camera held: moves by {:.2f} pixels ({:.2f}% of the width), 95th percentile {:.2f} "
      "({:.2f}%)"
      "   ({} cameras, {:.0f}% of their texture proved still)",
      t.median, 100 * t.median_share, t.p95, 100 * t.p95_share, t.cameras, 100 * t.proved_share);
}

std::string held_camera_warning(const HeldCamera& t) {
  if (t.p95_share <= kHeldCameraBad) return {};
  return fmt::format(
      "warning: with the camera held still, a twentieth of what stands still moves by {:.1f}% of the "
      "picture's width or more: the camera's motion was learned as the scene's. Views from beside its way "
      "will be wrong. If little or nothing moves, --effects view,background,surroundings leaves motion out; "
      "--masks ignore with masks of what moves, loss.curve_rest or more steps help; so does a second camera",
      100 * t.p95_share);
}

}  // namespace splinevox::run
