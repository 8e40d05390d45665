// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "backend/step.hpp"
#include "math/depth_loss.hpp"
#include "math/robust_line.hpp"
#include "render/views.hpp"
#include "splinevox/data/scene.hpp"
#include "train/volume.hpp"

namespace splinevox {

/// From the numbers of a frame's depth map to depth (DepthKind). `known` is 0 until it was fitted.
struct DepthFit {
  Line line{};              ///< from a number to depth, or of inverse maps to its inverse
  std::uint64_t known = 0;  ///< 1: it is; as wide as its neighbours, so that every byte of a state is told
};
/// Of each training frame. Empty: no depth is asked for.
using DepthFits = std::vector<DepthFit>;

/// Whether any frame has depth.
bool has_depth(const Split& train);
/// Whether a backend's steps would leave out depth that is there and asked for.
bool leaves_out_depth(const StepBackend& steps, const Config& config, const Split& train);
/// Throws Error (input) then.
void check_learns_depth(const StepBackend& steps, const Config& config, const Split& train);
/// What is known before training: metric maps. Empty if no frame has depth, or the weight of its loss is 0.
DepthFits starting_depth_fits(const Split& train, float weight);
/// The weight of the loss: of metric maps as it is, of others a tenth. Their fits err by some percent, and
/// what they are fitted to follows (docs/experiments/effects.md).
float depth_weight(const Split& train, float weight);
/// Whether a step is one of those before which maps are fitted: 50, 75, 100, 150, 200, 300 and so on. The
/// scene changes ever more slowly.
bool depth_fit_is_due(std::int64_t step);
/// Fits the maps that are not metric to what the model shows in their pictures, as it is. The same bits for
/// any number of threads. Maps whose numbers do not follow what is shown get unknown.
/// @param window  frames that are trained; others stay as they are
void fit_depths(const Setting& setting, const Volume& volume, const TimeWindow& window, DepthFits& fits);

/// What a pixel's depth map says of its ray. Partly transparent pixels mix depths and say nothing.
/// @param clipped  the ray in the box. @param step  between its samples, scene units
DepthTarget<float> depth_target(const Frame& frame, int x, int y, const Ray& ray, const DepthFit& fit,
                                const RayInput<float>& clipped, float step);

}  // namespace splinevox
