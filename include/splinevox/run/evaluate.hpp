// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "splinevox/core/image.hpp"
#include "splinevox/data/scene.hpp"
#include "splinevox/field/model.hpp"
#include "splinevox/render/render_image.hpp"

namespace splinevox::run {

/// A picture of a view beside the one it should be.
struct View {
  Image truth;                 ///< over the background
  Image render;                ///< within [0, 1]
  Rendered layers;             ///< of a model's view
  double psnr, ssim, ms_ssim;  ///< of the pixels that are not ignored; NaN: no window of the metric is left
  std::optional<double> psnr_inside;  ///< of the pixels inside the mask, where there are any
  double psnr_best_gain;  ///< after the gain per channel that brings the render nearest to the truth
};
/// @param render  3 channels within [0, 1], of the frame's size. @param background  behind the truth
View compare(Image render, const Frame& frame, const Vec3& background);
/// A model's view, over its background. @param renderer  of the model
/// @param across  as RenderOptions
View evaluate_view(const VoxelModel& model, Renderer& renderer, const Frame& frame, int across = 0);

/// The figures of one view.
struct ViewScore {
  std::string name;  ///< of the frame
  double time = 0;   ///< of the model
  double psnr = 0, ssim = 0, ms_ssim = 0;
  std::optional<double> psnr_inside;
  double psnr_best_gain = 0;  ///< see View
};

/// The figures of a split.
struct Scores {
  std::string split;
  double psnr = 0, ssim = 0, ms_ssim = 0;  ///< means over the views that have the figure
  double psnr_best_gain = 0;               ///< likewise
  std::optional<double> psnr_inside;       ///< the same inside the masks, where some view has one
  std::size_t inside_views = 0;
  double inside_share = 0;       ///< of those views' pixels
  double ignored_share = 0;      ///< of all views' pixels: what masks leave out of every figure
  std::vector<ViewScore> views;  ///< in the split's order
  double seconds = 0;            ///< of rendering and comparing
};

/// Called after each view; may be empty.
using OnView = std::function<void(const Frame&, const View&)>;
/// Every view of a split against its picture, as `splinevox eval` does it.
/// @param renderer  of the model: on the calling arena's threads, or on a device (make_renderer)
Scores evaluate(const VoxelModel& model, Renderer& renderer, const Split& split, const OnView& on_view = {},
                int across = 0);
/// The same of any pictures. @param view_of  called once for each frame, in order
Scores evaluate(const Split& split, const std::function<View(const Frame&)>& view_of,
                const OnView& on_view = {});

/// Displacement of full colour in the layer "flow", share of the box's longest edge: the same for all frames.
inline constexpr float kFullFlow = 0.1f;

/// A layer of a render ("rgb", "alpha", "depth", "flow", "rigidity") as colours that can be looked at: 3
/// channels.
Image layer_picture(const VoxelModel& model, const Rendered& r, const std::string& layer,
                    const Camera& camera);

/// The render with the truth where pixels are ignored.
Image without_ignored(const View& view, const Frame& frame);

/// What is wrong with a view (error_colours); nothing where pixels are ignored.
Image error_picture(const View& view, const Frame& frame);

/// folder/name.png: truth, render, error in one row and depth, flow, rigidity in the next;
/// folder/name_render.png: the render alone. Throws Error (output).
void save_view(const VoxelModel& model, const View& view, const Frame& frame, const std::string& folder);

}  // namespace splinevox::run
