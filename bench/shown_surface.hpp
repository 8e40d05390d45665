// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "math/camera.hpp"
#include "splinevox/data/scene.hpp"
#include "splinevox/data/synth.hpp"

namespace splinevox {

/// Which surface the pictures of a film show, at any of its times.
class ShownSurface {
 public:
  ShownSurface(const SynthScene& scene, const Split& film) : scene_(scene), film_(film) {
    for (const Frame& f : film.frames) moments_.push_back(scene.at(f.time));
  }

  /// The pixels of a view that show a surface which none of them does.
  PixelMask unseen(const Frame& frame) const {
    const SynthMoment now = scene_.at(frame.time);
    const int w = frame.camera.width, h = frame.camera.height;
    PixelMask out(w, h);
    for (int y = 0; y < h; ++y)
      for (int x = 0; x < w; ++x)
        if (const auto hit = now.trace(camera_ray(frame.camera, x + 0.5, y + 0.5)); hit && !shows(*hit))
          out.set(std::size_t(y) * std::size_t(w) + std::size_t(x));
    return out;
  }

 private:
  bool shows(const SynthHit& point) const {
    constexpr double kNear = 0.02;  // share of the distance: the same surface, not what hides it
    for (std::size_t i = 0; i < moments_.size(); ++i) {
      const Camera& camera = film_.frames[i].camera;
      const Vec3d place = moments_[i].world_from_rest(point.body, point.rest);
      const Projection p = project(camera, place);
      if (!(p.depth > 0 && p.u >= 0 && p.v >= 0 && p.u < camera.width && p.v < camera.height)) continue;
      const auto hit = moments_[i].trace(camera_ray(camera, p.u, p.v));
      if (hit && length(hit->position - place) < kNear * hit->along) return true;
    }
    return false;
  }

  const SynthScene& scene_;
  const Split& film_;
  std::vector<SynthMoment> moments_;
};

}  // namespace splinevox
