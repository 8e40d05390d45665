// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "run/run_folder.hpp"
#include "run/support.hpp"
#include "splinevox/data/scene.hpp"
#include "splinevox/field/model.hpp"
#include "splinevox/io/model_vdb.hpp"
#include "splinevox/render/render_image.hpp"

namespace splinevox::run {

/// A finished run as eval, render and report read it.
struct Run {
  std::string path;
  Config config;
  RunRecord record;
  VoxelModel model;
  ModelNotes notes;  ///< kept with the model

  Vec3 background() const { return model.background.color; }
};
/// Throws Error (input).
Run open_run(const std::string& path);

/// What a verb may be told instead of what the run says.
struct Otherwise {
  std::optional<int> downscale;
  std::optional<std::string> background;
  bool any() const { return downscale || background; }
};
/// open_run, changed accordingly. Throws Error (input).
Run open_run(const std::string& path, const Otherwise& otherwise);

/// The run's own pictures of one split, or those of `dataset` if not empty, with the run's downscale and time
/// map.
Dataset open_split(const Run& run, const std::string& dataset, const std::string& split);

/// One view of a run beside the picture it should be.
struct View {
  Image truth;   ///< over the run's background
  Image render;  ///< within [0, 1]
  Rendered layers;
  double psnr, ssim, ms_ssim;
};
/// @param renderer  of the run's model
View evaluate_view(const Run& run, Renderer& renderer, const Frame& frame);

/// Displacement of full colour in the layer "flow", share of the box's longest edge: the same for all frames.
inline constexpr float kFullFlow = 0.1f;

/// A layer of a render ("rgb", "alpha", "depth", "flow", "rigidity") as colours that can be looked at: 3
/// channels.
Image layer_picture(const Run& run, const Rendered& r, const std::string& layer, const Camera& camera);
/// folder/name.png: truth, render, error in one row and depth, flow, rigidity in the next;
/// folder/name_render.png: the render alone.
void save_view(const Run& run, const View& view, const Frame& frame, const std::string& folder);

}  // namespace splinevox::run
