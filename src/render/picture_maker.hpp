// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "field/lattice/slice.hpp"
#include "render/occupancy.hpp"
#include "splinevox/core/camera.hpp"

namespace splinevox {

struct Rendered;

/// Draws pictures of one model for a Renderer, elsewhere than on its own threads (backend/pictures.hpp).
class PictureMaker {
 public:
  virtual ~PictureMaker() = default;
  /// What the next pictures show.
  virtual void set_time(const MotionSlice& slice, const BitGrid& occupied) = 0;
  /// Fills every layer. @param step  march step, scene units. @param stop  as RenderOptions.
  virtual void draw(const Camera& camera, float step, float stop, Rendered& out) = 0;
};

}  // namespace splinevox
