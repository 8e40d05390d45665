// SPDX-License-Identifier: Apache-2.0
#include "app/evaluate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "splinevox/core/error.hpp"
#include "splinevox/data/image_write.hpp"
#include "splinevox/io/model_vdb.hpp"
#include "splinevox/io/pictures.hpp"
#include "splinevox/math/metrics.hpp"

namespace splinevox::app {

Run open_run(const std::string& path) {
  check_run(path);
  Run run;
  run.path = path;
  while (run.path.size() > 1 && run.path.back() == '/') run.path.pop_back();
  read_run_config(run.path, run.config, run.record);
  run.model = load_model(run.path + "/model.vdb");
  return run;
}

Dataset open_split(const Run& run, const std::string& dataset, const std::string& split) {
  LoadOptions load;
  load.downscale = run.config.run.downscale;
  load.splits = {split};
  load.time_map = run.record.time_map;
  return load_dataset(dataset.empty() ? run.record.dataset : dataset, load);
}

View evaluate_view(const Run& run, const Frame& frame) {
  View v;
  v.truth = composite(frame.image, run.background());
  v.layers = render_image(run.model, frame.camera, frame.time);
  v.render = clamped(v.layers.rgb);
  v.psnr = psnr(v.render, v.truth);
  v.ssim = ssim(v.render, v.truth);
  v.ms_ssim = ms_ssim(v.render, v.truth);
  return v;
}

}  // namespace splinevox::app
