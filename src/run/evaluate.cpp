// SPDX-License-Identifier: Apache-2.0
#include "splinevox/run/evaluate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/stopwatch.hpp"
#include "math/camera.hpp"
#include "run/colours.hpp"
#include "splinevox/data/image_io.hpp"
#include "splinevox/math/metrics.hpp"

namespace splinevox::run {
namespace {

/// The mean of what is a number; NaN for none.
double mean_of_finite(const std::vector<ViewScore>& views, double ViewScore::*figure) {
  double sum = 0;
  int count = 0;
  for (const ViewScore& v : views) {
    if (!std::isfinite(v.*figure)) continue;
    sum += v.*figure;
    ++count;
  }
  return sum / count;
}

PixelMask others_than(const PixelMask& mask) {
  PixelMask out(mask.width(), mask.height());
  for (std::size_t i = 0; i < mask.pixels(); ++i)
    if (!mask.test(i)) out.set(i);
  return out;
}

/// The nearest and the farthest corner of the box before a camera.
std::pair<float, float> depth_range(const Box& box, const Camera& camera) {
  float near = 1e30f, far = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3d p{corner & 1 ? box.hi.x : box.lo.x, corner & 2 ? box.hi.y : box.lo.y,
                  corner & 4 ? box.hi.z : box.lo.z};
    const float depth = float(project(camera, p).depth);
    near = std::min(near, depth);
    far = std::max(far, depth);
  }
  return {std::max(near, 0.0f), far};
}

/// The render times a gain per channel: least squares against the truth, where it is not ignored. A held-out
/// camera has an exposure of its own, which nothing tells (train/learn_cameras.hpp).
Image best_gain(Image render, const Image& truth, const PixelMask& ignored) {
  for (int c = 0; c < 3; ++c) {
    double along = 0, square = 0;
    for (int y = 0; y < render.height; ++y)
      for (int x = 0; x < render.width; ++x) {
        if (ignored.test(x, y)) continue;
        const double value = render.pixel(x, y)[c];
        along += value * truth.pixel(x, y)[c];
        square += value * value;
      }
    if (square == 0) continue;
    for (std::size_t i = std::size_t(c); i < render.data.size(); i += 3)
      render.data[i] *= float(along / square);
  }
  return clamped(std::move(render));
}

}  // namespace

View compare(Image render, const Frame& frame, const Vec3& background) {
  View v;
  v.truth = composite(frame.image, background);
  v.render = std::move(render);
  v.psnr = psnr(v.render, v.truth, frame.ignored);
  v.ssim = ssim(v.render, v.truth, frame.ignored);
  v.ms_ssim = ms_ssim(v.render, v.truth, frame.ignored);
  v.psnr_best_gain = psnr(best_gain(v.render, v.truth, frame.ignored), v.truth, frame.ignored);
  if (frame.inside.count() > 0) v.psnr_inside = psnr(v.render, v.truth, others_than(frame.inside));
  return v;
}

View evaluate_view(const VoxelModel& model, Renderer& renderer, const Frame& frame, int across) {
  Rendered layers = renderer.render(frame.camera, frame.time, {.across = across});
  View v = compare(clamped(layers.rgb), frame, model.background.color);
  v.layers = std::move(layers);
  return v;
}

Scores evaluate(const VoxelModel& model, Renderer& renderer, const Split& split, const OnView& on_view,
                int across) {
  return evaluate(
      split, [&](const Frame& frame) { return evaluate_view(model, renderer, frame, across); }, on_view);
}

Scores evaluate(const Split& split, const std::function<View(const Frame&)>& view_of, const OnView& on_view) {
  Scores out;
  out.split = split.name;
  std::vector<double> psnrs, with_gain, psnrs_inside;
  double pixels = 0, pixels_inside = 0, inside = 0, ignored = 0;
  for (const Frame& frame : split.frames) {
    const Timer timer;
    const View v = view_of(frame);
    out.seconds += timer.seconds();
    out.views.push_back({frame.name, frame.time, v.psnr, v.ssim, v.ms_ssim, v.psnr_inside, v.psnr_best_gain});
    psnrs.push_back(v.psnr);
    with_gain.push_back(v.psnr_best_gain);
    pixels += double(v.truth.pixels());
    ignored += double(frame.ignored.count());
    if (v.psnr_inside) {
      psnrs_inside.push_back(*v.psnr_inside);
      pixels_inside += double(v.truth.pixels());
      inside += double(frame.inside.count());
    }
    if (on_view) on_view(frame, v);
  }
  out.psnr = mean_psnr(psnrs);
  out.psnr_best_gain = mean_psnr(with_gain);
  out.ssim = mean_of_finite(out.views, &ViewScore::ssim);
  out.ms_ssim = mean_of_finite(out.views, &ViewScore::ms_ssim);
  out.ignored_share = pixels > 0 ? ignored / pixels : 0;
  out.inside_views = psnrs_inside.size();
  if (!psnrs_inside.empty()) {
    out.psnr_inside = mean_psnr(psnrs_inside);
    out.inside_share = inside / pixels_inside;
  }
  return out;
}

Image layer_picture(const VoxelModel& model, const Rendered& r, const std::string& layer,
                    const Camera& camera) {
  const auto [near, far] = depth_range(model.box, camera);
  if (layer == "alpha") return grey(r.alpha);
  if (layer == "depth") return depth_colours(r, near, far, model.background.color);
  if (layer == "flow") return flow_colours(r, kFullFlow * model.box.longest_edge(), model.background.color);
  if (layer == "rigidity") return rigidity_colours(r, model.background.color);
  return clamped(r.rgb);
}

Image error_picture(const View& view, const Frame& frame) {
  return error_colours(without_ignored(view, frame), view.truth);
}

Image without_ignored(const View& view, const Frame& frame) {
  Image render = view.render;
  for (std::size_t i = 0; i < render.pixels(); ++i)
    if (frame.ignored.test(i)) std::copy_n(view.truth.data.begin() + 3 * i, 3, render.data.begin() + 3 * i);
  return render;
}

void save_view(const VoxelModel& model, const View& view, const Frame& frame, const std::string& folder) {
  std::vector<Image> pictures = {view.truth, view.render, error_picture(view, frame)};
  for (const char* layer : {"depth", "flow", "rigidity"})
    pictures.push_back(layer_picture(model, view.layers, layer, frame.camera));
  write_png(fmt::format("{}/{}.png", folder, frame.name), contact_sheet(pictures, 3));
  write_png(fmt::format("{}/{}_render.png", folder, frame.name), view.render);
}

}  // namespace splinevox::run
