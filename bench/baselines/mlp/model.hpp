// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "networks.hpp"
#include "splinevox/core/vec3.hpp"

namespace splinevox::mlp {

/// Rays as tensors, clipped to the scene's box.
struct Rays {
  torch::Tensor origin;     ///< [n, 3] where the ray enters the box, scene units
  torch::Tensor direction;  ///< [n, 3] unit length
  torch::Tensor length;     ///< [n, 1] way through the box, scene units; 0: it misses
  torch::Tensor time;       ///< [n, 1] in [0, 1]
};

/// What a picture or a loss needs of some rays.
struct Marched {
  torch::Tensor rgb;  ///< [n, 3] over the background
  torch::Tensor
      offset;  ///< scalar: mean of w (|Delta_0|^(2 - r) + lambda_r r), Eq. 6; undefined if not asked for
  torch::Tensor divergence;  ///< scalar: mean of w |div Delta|^2, Eq. 7; undefined if not asked for
};

/// Deformation and radiance of one variant, and how rays go through them.
struct MlpModelImpl : torch::nn::Module {
  explicit MlpModelImpl(const Settings& settings);

  /// Where its parameters are; rays come there and pictures return by themselves.
  torch::Device device() const { return background_.device(); }
  /// Draws stratified samples and composites. Differentiable, the divergence with its true gradient
  /// (create_graph; the released code drops it).
  Marched train_march(const Rays& rays);
  /// Without noise, jitter or gradients, in pieces that fit the cache. @return [n, 3], on the CPU
  torch::Tensor picture(const Rays& rays);

 private:
  Marched march(const Rays& rays, bool training);

  Settings settings_;
  torch::Tensor background_;  ///< [3]
  Deformation deformation_{nullptr};
  Radiance radiance_{nullptr};
};
TORCH_MODULE(MlpModel);

}  // namespace splinevox::mlp
