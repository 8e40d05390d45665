// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "math/camera.hpp"
#include "render/views.hpp"

namespace splinevox {

/// What the samples of a pixel add up to beside its colour: the other layers of Rendered.
struct PixelSums {
  Vec3 flow{};
  float depth = 0, rigidity = 0, weights = 0;

  /// @param w  share of the sample in the pixel. @param distance  from the camera, scene units
  SPLINEVOX_INLINE void add(float w, float distance) {
    weights += w;
    depth += w * distance;
  }
  /// @param r  rigidity. @param motion  Delta_0: anything with an index
  template <class Motion>
  SPLINEVOX_INLINE void add_motion(float w, float r, const Motion& motion) {
    flow += (w * r) * Vec3{motion[0], motion[1], motion[2]};
    rigidity += w * r;
  }
  friend SPLINEVOX_INLINE PixelSums operator+(PixelSums a, const PixelSums& b) {
    a.flow += b.flow;
    a.depth += b.depth;
    a.rigidity += b.rigidity;
    a.weights += b.weights;
    return a;
  }
};

/// Where the samples of a pixel's ray lie, seen from the camera.
struct PixelDepth {
  float start;   ///< distance of sample 0
  float cosine;  ///< between the ray and the viewing axis

  /// @param input  the ray, clipped
  SPLINEVOX_HD PixelDepth(const Camera& camera, const Ray& ray, const RayInput<float>& input)
      : start(float(dot(cast<double>(input.origin) - ray.origin, ray.direction))),
        cosine(float(-dot(ray.direction, camera.axes[2]))) {}
  SPLINEVOX_INLINE float distance(float sample, float step) const { return start + sample * step; }
  /// Mean depth along the viewing axis, scene units; 0 where the ray met next to nothing.
  SPLINEVOX_HD float mean(const PixelSums& sums) const {
    constexpr float kNothing = 1e-4f;
    return sums.weights > kNothing ? cosine * sums.depth / sums.weights : 0;
  }
};

}  // namespace splinevox
