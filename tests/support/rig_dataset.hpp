// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "data/synth/view.hpp"

namespace splinevox::test {

/// A camera of a rig as it truly is.
struct CameraTruth {
  Vec3 gain{1, 1, 1};
  double offset = 0;  ///< model time
};

/// A built-in scene filmed by cameras that stand around it, each at every moment, over alpha.
inline Dataset make_rig(const std::string& scene_name, const std::vector<CameraTruth>& cameras, int moments,
                        int size, bool opaque = false) {
  const SynthScene scene = SynthScene::open(scene_name);
  Dataset out;
  out.has_alpha = !opaque;
  Split train{"train", {}};
  const int count = int(cameras.size());
  for (int c = 0; c < count; ++c) {
    const std::string name = std::to_string(c);
    out.cameras.push_back({name, true});
    const double angle = 2 * std::numbers::pi * c / count, height = c % 2 ? 0.5 : 0.8;
    const Vec3d from = 4.0 * normalize(Vec3d{std::cos(angle), std::sin(angle), height}),
                back = normalize(from), right = normalize(cross(Vec3d{0, 0, 1}, back)),
                up = cross(back, right);
    Camera camera = make_synth("ball", {.frames = 2, .size = size}).find("train")->frames[0].camera;
    camera.position = from;
    camera.axes = {right, up, back};
    for (int m = 0; m < moments; ++m) {
      const double time = double(m) / (moments - 1);
      const SynthMoment now = scene.at(std::clamp(time + cameras[c].offset, 0.0, 1.0));
      const Image picture = data::draw(now, camera, opaque, {1, 1, 1}, data::subject_mask(now)).picture;
      Image16 image{size, size, std::vector<std::uint16_t>(4 * picture.pixels())};
      for (std::size_t i = 0; i < image.rgba.size(); ++i) {
        const float gain = i % 4 < 3 ? cameras[std::size_t(c)].gain[int(i % 4)] : 1;
        image.rgba[i] = std::uint16_t(257 * std::lround(255 * std::min(1.0f, gain * picture.data[i])));
      }
      train.frames.push_back({std::string("c").append(name).append("_").append(std::to_string(m)), camera,
                              time, Picture(std::move(image)), c});
    }
  }
  out.splits.push_back(std::move(train));
  return out;
}

}  // namespace splinevox::test
