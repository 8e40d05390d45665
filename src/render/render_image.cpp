// SPDX-License-Identifier: Apache-2.0
#include "splinevox/render/render_image.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "core/parallel.hpp"
#include "field/lattice/slice.hpp"
#include "render/active_rows.hpp"
#include "render/field_view.hpp"
#include "render/occupancy.hpp"
#include "render/picture_maker.hpp"
#include "render/pixel_sums.hpp"
#include "render/ray_kernel.hpp"
#include "render/specialise.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox {
namespace {

constexpr int kTile = 16;  ///< pixels per tile edge: neighbouring rays share cache lines
constexpr int kOccupancyCells = 64;
constexpr double kNarrow = 2.4;           ///< width in pixels of voxels of which a pixel shows several
constexpr float kOccupancyAlpha = 1e-3f;  ///< far below what shows in 8 bit over a whole ray of skipped cells

template <int Sh, bool Moving>
void render_tile(const VoxelModel& model, const Camera& camera, const FieldView<float>& field,
                 const FrameView<float>& frame, float stop, int tile, Rendered& out) {
  RayKernel<float, Sh, float, Moving> kernel;
  const int tiles_x = (camera.width + kTile - 1) / kTile;
  const int x0 = tile % tiles_x * kTile, y0 = tile / tiles_x * kTile;
  for (int y = y0; y < std::min(y0 + kTile, camera.height); ++y)
    for (int x = x0; x < std::min(x0 + kTile, camera.width); ++x) {
      const Ray ray = camera_ray(camera, x + 0.5, y + 0.5);
      const RayInput<float> input = clip_ray(ray, model.box, field.step, 0.5f, model.behind(ray));
      const RayResult<float> result = kernel.forward(input, field, frame, stop);
      const float alpha = 1 - result.transmittance;
      const PixelDepth depth(camera, ray, input);
      PixelSums sums;
      for (int i = 0; i < kernel.count; ++i) {
        const float w = kernel.weight[i];
        sums.add(w, depth.distance(kernel.distance[i], field.step));
        if constexpr (Moving) sums.add_motion(w, kernel.r[i], kernel.samples[i].warp.motion);
      }
      for (int c = 0; c < 3; ++c) out.rgb.pixel(x, y)[c] = result.rgb[c];
      *out.alpha.pixel(x, y) = alpha;
      *out.depth.pixel(x, y) = depth.mean(sums);
      for (int c = 0; c < 3; ++c) out.flow.pixel(x, y)[c] = sums.flow[c];
      *out.rigidity.pixel(x, y) = sums.rigidity;
    }
}

/// Where the canonical volume has matter, and where a model's motion is not zero, unless that is most of
/// where it is stored.
OccupancyPyramid known_occupancy(const VoxelModel& model) {
  BitGrid reach;
  if (!model.motion.levels.empty()) {
    const Channels& level = model.motion.levels.back();
    const std::vector<RowMask> rows = nonzero_rows(level);
    std::size_t count = 0;
    for (const RowMask& brick : rows) brick.for_each([&](int) { ++count; });
    if (!rows[0].any() && 2 * count < level.topology->rows())
      reach = reach_of(*level.topology, rows, BitGrid(model.box, kOccupancyCells));
  }
  return {model, kOccupancyCells, kOccupancyAlpha, model.step, std::move(reach)};
}

/// Adds a picture to a sum of some, or begins one. Depth is weighted with alpha until mean_of.
void add(Rendered&& picture, Rendered& sum) {
  for (std::size_t i = 0; i < picture.depth.data.size(); ++i) picture.depth.data[i] *= picture.alpha.data[i];
  if (sum.alpha.pixels() == 0) {
    sum = std::move(picture);
    return;
  }
  const auto both = [](const Image& from, Image& to) {
    for (std::size_t i = 0; i < to.data.size(); ++i) to.data[i] += from.data[i];
  };
  both(picture.rgb, sum.rgb);
  both(picture.alpha, sum.alpha);
  both(picture.depth, sum.depth);
  both(picture.flow, sum.flow);
  both(picture.rigidity, sum.rigidity);
}

Rendered mean_of(Rendered&& sum, int count) {
  for (std::size_t i = 0; i < sum.depth.data.size(); ++i)
    if (sum.depth.data[i] > 0) sum.depth.data[i] /= sum.alpha.data[i];
  const float share = 1 / float(count);
  for (Image* layer : {&sum.rgb, &sum.alpha, &sum.flow, &sum.rigidity})
    for (float& v : layer->data) v *= share;
  return std::move(sum);
}

}  // namespace

/// What a renderer knows of its model, and of the last time.
struct Renderer::State {
  const VoxelModel& model;
  std::unique_ptr<PictureMaker> maker;
  OccupancyPyramid canonical;
  double moment = std::numeric_limits<double>::quiet_NaN();  ///< on the curves, of slice and occupied; NaN:
                                                             ///< of none yet
  MotionSlice slice = {};
  BitGrid occupied = {};

  void go_to(double time) {
    const double asked = model.motion.levels.empty() ? 0 : model.motion.time_curve(time);
    if (asked == moment) return;
    slice = make_slice(model.motion, parameter_weights(model.motion, asked));
    occupied = frame_occupancy(model, slice, canonical);
    if (maker) maker->set_time(slice, occupied);
    moment = asked;
  }

  /// One ray a pixel, at the time that was gone to.
  Rendered draw(const Camera& camera, const RenderOptions& options) {
    const int w = camera.width, h = camera.height;
    Rendered out{{w, h, 3}, {w, h, 1}, {w, h, 1}, {w, h, 3}, {w, h, 1}};
    if (maker) {
      maker->draw(camera, model.step * options.step_scale, options.stop, out);
      return out;
    }
    FieldView<float> field = view_field(model, model.step * options.step_scale);
    if (canonical.moving[0].cells() > 0) field.reach = canonical.moving[0].bits.data();
    const FrameView<float> frame{slice.values.data(), occupied.view()};
    const int tiles = ((w + kTile - 1) / kTile) * ((h + kTile - 1) / kTile);
    parallel_for(tiles, [&](int tile) {
      specialise(model.radiance.sh_order, field.moving, [&]<int Sh, bool Moving>() {
        render_tile<Sh, Moving>(model, camera, field, frame, options.stop, tile, out);
      });
    });
    return out;
  }
};

Renderer::Renderer(const VoxelModel& model) : Renderer(model, nullptr) {}
Renderer::Renderer(const VoxelModel& model, std::unique_ptr<PictureMaker> maker)
    : state_(new State{model, std::move(maker), known_occupancy(model)}) {}
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;
Renderer::~Renderer() = default;

Rendered Renderer::render(const Camera& camera, double time, const RenderOptions& options) {
  if (camera.lens.kind != Distortion::Kind::none && !(camera.lens.reach > 0))
    fail({"Renderer::render", "the lens of the camera has no reach", "Distortion::reach above 0", "",
          "lens_reach(camera.lens)"});
  state_->go_to(time);
  const int n =
      options.across == 0 ? rays_across(state_->model, camera) : std::clamp(options.across, 1, kMostAcross);
  if (n == 1) return state_->draw(camera, options);
  Rendered sum;
  for (int i = 0; i < n * n; ++i) {
    // Seen a part of a pixel to the right and below, as a camera sees it whose centre is as far to the left
    // and above.
    Camera moved = camera;
    moved.cx -= (i % n + 0.5) / n - 0.5;
    moved.cy -= (i / n + 0.5) / n - 0.5;
    add(state_->draw(moved, options), sum);
  }
  return mean_of(std::move(sum), n * n);
}

int rays_across(const VoxelModel& model, const Camera& camera) {
  const double voxel = model.radiance.raw.topology->lattice.spacing,
               away = length(cast<double>(model.box.center()) - camera.position);
  return std::max(camera.fx, camera.fy) * voxel < kNarrow * away ? 2 : 1;
}

Rendered render_image(const VoxelModel& model, const Camera& camera, double time,
                      const RenderOptions& options) {
  return Renderer(model).render(camera, time, options);
}

}  // namespace splinevox
