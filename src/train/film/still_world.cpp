// SPDX-License-Identifier: Apache-2.0
#include "train/film/still_world.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "core/parallel.hpp"
#include "core/squares.hpp"
#include "math/camera.hpp"
#include "splinevox/data/image_io.hpp"
#include "splinevox/math/basis.hpp"
#include "splinevox/math/metrics.hpp"
#include "splinevox/render/render_image.hpp"
#include "splinevox/train/trainer.hpp"
#include "train/effects/effect_table.hpp"
#include "train/effects/film.hpp"
#include "train/effects/rig.hpp"
#include "train/film/moving_tracks.hpp"
#include "train/film/unexplained.hpp"
#include "train/start.hpp"

namespace splinevox {
namespace {

constexpr int kSteps = 200;             ///< of the fit
constexpr int kMostRays = 4096;         ///< of a step
constexpr int kStride = 4;              ///< squares, between places that are asked who sees them
constexpr int kFewestViews = 5;         ///< of a place of which something is said
constexpr double kViewsShare = 0.15;    ///< of all pictures, that such a place is in
constexpr std::size_t kMostViews = 64;  ///< pictures that are asked
constexpr double kMoves = 3e-4;         ///< share of the pixels from which something moves

Config still_config(const Config& config) {
  Config c = config;
  apply(unchanging(effects_of(config)), c);
  c.run.max_time = 0;
  c.run.max_steps = kSteps;
  c.radiance.sh_order = order_at(c.radiance, 0);
  c.radiance.sh_start.clear();
  c.grid.radiance = {32, 64, 96};
  c.grid.radiance_start = {0, .2f, .5f};
  c.grid.surroundings = {32, 48};
  c.grid.surroundings_start = {0, 0.4f};
  c.grid.empty_start.clear();
  c.sampling.rays = std::min(c.sampling.rays, kMostRays);
  c.sampling.growth = 1;
  c.sampling.changing = 0;
  c.sampling.hard_share = 0;  // what moves is what it fits worst
  c.sampling.window = 1;
  return c;
}

/// Which pixels show a place that enough pictures have in them.
std::vector<char> known_pixels(const VoxelModel& still, const Rendered& shown, const Camera& camera,
                               const Split& train) {
  const std::size_t views = std::min(train.frames.size(), kMostViews);
  const double enough = std::max(double(kFewestViews), kViewsShare * double(views));
  const int w = camera.width, h = camera.height;
  std::vector<char> out(std::size_t(w) * std::size_t(h));
  for (int y = 0; y < h; y += kStride)
    for (int x = 0; x < w; x += kStride) {
      const int u = std::min(w - 1, x + kStride / 2), v = std::min(h - 1, y + kStride / 2);
      const Ray ray = camera_ray(camera, u + 0.5, v + 0.5);
      // What lies behind the box is far away.
      const double distance = *shown.alpha.pixel(u, v) > 0.5f
                                  ? double(*shown.depth.pixel(u, v)) / -dot(ray.direction, camera.axes[2])
                                  : 2 * double(still.box.longest_edge());
      const Vec3d place = ray.origin + distance * ray.direction;
      int seen = 0;
      for (std::size_t i = 0; i < views; ++i) {
        const Camera& other = train.frames[i * train.frames.size() / views].camera;
        const Projection p = project(other, place);
        seen += p.depth > 0 && p.u >= 0 && p.v >= 0 && p.u < other.width && p.v < other.height;
      }
      for (int b = y; b < std::min(h, y + kStride); ++b)
        for (int a = x; a < std::min(w, x + kStride); ++a)
          out[std::size_t(b) * std::size_t(w) + std::size_t(a)] = seen >= enough;
    }
  return out;
}

void leave_out(const PixelMask& ignored, std::vector<char>& known) {
  for (std::size_t i = 0; i < known.size() && !ignored.empty(); ++i)
    if (ignored.test(i)) known[i] = 0;
}

/// None: no masks are for that.
std::optional<FilmEvidence> given_motion(const Split& train) {
  FilmEvidence out;
  out.given = true;
  out.threshold = kMoves;
  int masks = 0, whole = 0;
  for (const Frame& f : train.frames) {
    const PixelMask& squares = f.moving.squares;
    if (squares.empty()) continue;
    whole += squares.all();
    if (squares.all()) continue;
    ++masks;
    out.pictures += squares.count() > 0;
    out.share += double(squares.count()) / double(squares.pixels());
  }
  if (masks + whole == 0) return {};
  out.share = masks > 0 ? out.share / masks : 1;
  out.coloured = out.share;
  return out;
}

}  // namespace

Vec3 starting_middle(const Config& config, const Split& train) {
  return starting_bounds(config, train, picture_stats(train)).box.center();
}

double view_told_by_time(const Config& config, const Split& train, const Vec3& middle) {
  return view_told_by_time(train, middle, 1.0 / basis_of(config.motion.basis).pieces(config.motion.points));
}

std::optional<FilmEvidence> motion_told(const Config& config, const Split& train, const TimeMap& time_map,
                                        double told, std::vector<CoarseMask>& moving,
                                        const std::function<void(const FilmEvidence&)>& on_film) {
  std::optional<FilmEvidence> out = given_motion(train);
  if (out || !is_film(told)) return out;
  out = look_at_film(config, train, time_map, moving);
  if (on_film) on_film(*out);
  return out;
}

FilmEvidence look_at_film(const Config& config, const Split& train, const TimeMap& time_map,
                          std::vector<CoarseMask>& moving) {
  Trainer trainer(still_config(config), train, time_map);
  while (!trainer.done()) trainer.step();
  const CameraFits cameras = trainer.cameras();
  const VoxelModel still = trainer.finish();
  const float unit = brightness(config, picture_stats(train));
  const std::size_t n = train.frames.size();
  const std::vector<char> followed = points_that_move(train);
  std::vector<double> psnrs(n), shares(n), coloured(n);
  moving.resize(n);
  parallel_for(int(n), [&](int i) {
    const Frame& frame = train.frames[std::size_t(i)];
    const int factor = squares_factor(frame.camera.width, frame.camera.height);
    const ReadAll all_of(frame.image);
    const Camera camera = area_downscale(frame.camera, factor);
    const Image picture = composite(area_downscale(frame.image, factor), still.background.color);
    const Rendered shown = render_image(still, camera, frame.time);
    const Image expected = exposed(shown, cameras.gain_of(frame), still);
    const PixelMask ignored = area_downscale(frame.ignored, factor);
    std::vector<char> known = known_pixels(still, shown, camera, train);
    leave_out(ignored, known);
    const PixelMask tracked = squares_of_moving(frame, followed, factor);  // no highlight is
    const auto clear = [&](const std::vector<float>& error) {
      return clear_errors(error, known, camera.width, camera.height, unit) |= tracked;
    };
    moving[std::size_t(i)] = {clear(unexplained(picture, expected)), factor};
    const PixelMask& squares = moving[std::size_t(i)].squares;
    coloured[std::size_t(i)] =
        double(clear(unexplained_hue(picture, expected)).count()) / double(squares.pixels());
    shares[std::size_t(i)] = double(squares.count()) / double(squares.pixels());
    psnrs[std::size_t(i)] = capped_psnr(psnr(expected, picture, ignored));
  });
  FilmEvidence out;
  double shown = 0;  // pictures of which masks leave something
  for (std::size_t i = 0; i < n; ++i) {
    if (std::isfinite(psnrs[i])) {
      out.psnr += psnrs[i];
      ++shown;
    }
    out.share += shares[i] / double(n);
    out.coloured += coloured[i] / double(n);
    out.pictures += moving[i].squares.count() > 0;
  }
  out.psnr /= std::max(1.0, shown);
  out.threshold = kMoves;
  out.seconds = trainer.seconds();
  return out;
}

}  // namespace splinevox
