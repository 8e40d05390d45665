// SPDX-License-Identifier: Apache-2.0
#include "run/held_camera.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/parallel.hpp"
#include "core/stopwatch.hpp"
#include "math/camera.hpp"
#include "math/quantile.hpp"
#include "run/still_places.hpp"
#include "splinevox/field/sample.hpp"
#include "train/effects/film.hpp"

namespace splinevox::run {
namespace {

constexpr std::size_t kCameras = 12;
constexpr int kTimes = 17;

std::vector<double> even_times() {
  std::vector<double> out;
  for (int i = 0; i < kTimes; ++i) out.push_back(double(i) / (kTimes - 1));
  return out;
}

/// Evenly spread over a split, the middle of each stretch.
std::vector<const Frame*> held_frames(const Split& split) {
  const std::size_t n = split.frames.size(), count = std::min(n, kCameras);
  std::vector<const Frame*> out;
  for (std::size_t i = 0; i < count; ++i) out.push_back(&split.frames[(2 * i + 1) * n / (2 * count)]);
  return out;
}

/// How far a surface point goes in a picture, as a share of its width; all of it if it leaves the view.
double shift_of(const Camera& camera, const Vec3d& point, const Vec3& by) {
  if (by == Vec3{}) return 0;  // to the last bit
  const Projection from = project(camera, point), to = project(camera, point + cast<double>(by));
  const double shift = to.depth > 0 ? std::hypot(to.u - from.u, to.v - from.v) / camera.width : 1;
  return std::min(shift, 1.0);
}

}  // namespace

bool is_film(const Split& train, const Box& box) {
  return splinevox::is_film(view_told_by_time(train, box.center(), kOtherTime));
}

std::optional<HeldCamera> held_camera_test(const VoxelModel& model, Renderer& renderer, const Split& train,
                                           const Split& held_out) {
  const Timer timer;
  const PatchEvidence evidence(train, model.box, model.background.color, even_times());
  std::vector<FrameSampler> at;
  for (const double t : evidence.times()) at.emplace_back(model, t);
  const std::vector<const Frame*> frames = held_frames(held_out);
  std::vector<SmallPicture> pictures;
  std::vector<PixelMask> ignored;
  for (const Frame* frame : frames) {
    pictures.push_back(small_picture(*frame, model.background.color));
    ignored.push_back(frame->ignored);
  }
  const StillPlaces still = evidence.places(pictures, ignored);
  std::vector<double> shifts;
  std::size_t proved = 0;
  double pixels = 0;
  auto place = still.places.begin();
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const Camera& camera = pictures[k].camera;
    const Rendered seen = renderer.render(camera, frames[k]->time);
    const FrameSampler own(model, frames[k]->time);
    for (; place != still.places.end() && place->picture == k; ++place) {
      const int x = int(place->u), y = int(place->v);
      proved += std::size_t(std::count(place->still.begin(), place->still.end(), true));
      if (*seen.alpha.pixel(x, y) < 0.5f) continue;  // it shows what is behind the box, which cannot move
      const Ray ray = camera_ray(camera, place->u, place->v);
      const Vec3d point =
          ray.origin + (*seen.depth.pixel(x, y) / -dot(ray.direction, camera.axes[2])) * ray.direction;
      const Vec3 surface = cast<float>(point), here = own.warp(surface).displacement;
      for (std::size_t t = 0; t < at.size(); ++t)
        if (place->still[t])
          shifts.push_back(shift_of(camera, point, at[t].warp(surface).displacement - here));
    }
    pixels += double(frames[k]->camera.width) / double(frames.size());
  }
  if (shifts.size() < kFewestPlaces) return {};
  HeldCamera out;
  out.cameras = int(frames.size());
  out.places = shifts.size();
  out.proved_share = double(proved) / double(still.asked);
  out.median_share = quantile(shifts, 0.5);
  out.p95_share = quantile(shifts, 0.95);
  out.median = pixels * out.median_share;
  out.p95 = pixels * out.p95_share;
  out.seconds = timer.seconds();
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
      "warning: with the camera held still, some of what stands still moves by {:.1f}% of the picture's "
      "width: "
      "the camera's motion was learned as the scene's. Views from beside its way will be wrong. "
      "Masks of what moves hold the rest (--masks moving); --effects view,background,surroundings leaves "
      "motion out; a second camera settles it",
      100 * t.p95_share);
}

}  // namespace splinevox::run
