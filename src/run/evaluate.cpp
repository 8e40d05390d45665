// SPDX-License-Identifier: Apache-2.0
#include "run/evaluate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "math/camera.hpp"
#include "run/colours.hpp"
#include "run/train_options.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/data/image_write.hpp"
#include "splinevox/io/model_vdb.hpp"
#include "splinevox/math/metrics.hpp"

namespace splinevox::run {
namespace {

/// The nearest and the farthest corner of the box before a camera.
std::pair<float, float> depth_range(const Box& box, const Camera& camera) {
  float near = 1e30f, far = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3d p{corner & 1 ? box.hi.x : box.lo.x, corner & 2 ? box.hi.y : box.lo.y,
                  corner & 4 ? box.hi.z : box.lo.z};
    const float depth = float(project(camera, p).depth);
    near = std::min(near, depth), far = std::max(far, depth);
  }
  return {std::max(near, 0.0f), far};
}

}  // namespace

Run open_run(const std::string& path) {
  check_run(path);
  Run run;
  run.path = path;
  while (run.path.size() > 1 && run.path.back() == '/') run.path.pop_back();
  read_run_config(run.path, run.config, run.record);
  run.model = load_model(run.path + "/model.vdb", &run.notes);
  return run;
}

Run open_run(const std::string& path, const Otherwise& otherwise) {
  Run run = open_run(path);
  if (otherwise.downscale) run.config.run.downscale = *otherwise.downscale;
  if (!otherwise.background) return run;
  const std::vector<float> c = parse_background(*otherwise.background);
  run.model.background = {.color = {c[0], c[1], c[2]}};
  return run;
}

Dataset open_split(const Run& run, const std::string& dataset, const std::string& split) {
  LoadOptions load;
  load.downscale = run.config.run.downscale;
  load.splits = {split};
  load.time_map = run.record.time_map;
  return load_dataset(dataset.empty() ? run.record.dataset : dataset, load);
}

View evaluate_view(const Run& run, Renderer& renderer, const Frame& frame) {
  View v;
  v.truth = composite(frame.image, run.background());
  v.layers = renderer.render(frame.camera, frame.time);
  v.render = clamped(v.layers.rgb);
  v.psnr = psnr(v.render, v.truth);
  v.ssim = ssim(v.render, v.truth);
  v.ms_ssim = ms_ssim(v.render, v.truth);
  return v;
}

Image layer_picture(const Run& run, const Rendered& r, const std::string& layer, const Camera& camera) {
  const auto [near, far] = depth_range(run.model.box, camera);
  if (layer == "alpha") return grey(r.alpha);
  if (layer == "depth") return depth_colours(r, near, far, run.background());
  if (layer == "flow") return flow_colours(r, kFullFlow * run.model.box.longest_edge(), run.background());
  if (layer == "rigidity") return rigidity_colours(r, run.background());
  return clamped(r.rgb);
}

void save_view(const Run& run, const View& view, const Frame& frame, const std::string& folder) {
  std::vector<Image> pictures = {view.truth, view.render, error_colours(view.render, view.truth)};
  for (const char* layer : {"depth", "flow", "rigidity"})
    pictures.push_back(layer_picture(run, view.layers, layer, frame.camera));
  write_png(fmt::format("{}/{}.png", folder, frame.name), contact_sheet(pictures, 3));
  write_png(fmt::format("{}/{}_render.png", folder, frame.name), view.render);
}

}  // namespace splinevox::run
