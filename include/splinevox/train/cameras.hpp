// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "splinevox/data/scene.hpp"

namespace splinevox {

/// What a run has learned of one camera.
struct CameraFit {
  /// Display values of its pictures over those of the model, per channel: one for all time, or at times that
  /// divide [0, 1] evenly and straight in between.
  std::vector<Vec3> gains{{1, 1, 1}};
  double offset = 0;     ///< model time that its pictures show later than their times say
  double interval = 0;   ///< model time between its pictures, the median
  bool trained = false;  ///< it took enough of the training pictures to learn from

  /// Between two of the gains: the first of them, and how far the time is on its way to the next, 0..1.
  struct Between {
    std::size_t first = 0;
    float share = 0;
  };
  Between between(double time) const {
    if (gains.size() < 2) return {};
    const double at = std::clamp(time, 0.0, 1.0) * double(gains.size() - 1);
    const std::size_t first = std::min(std::size_t(at), gains.size() - 2);
    return {first, float(at - double(first))};
  }
  Vec3 gain_at(double time) const {
    const auto [first, share] = between(time);
    if (share == 0) return gains[first];
    return (1 - share) * gains[first] + share * gains[first + 1];
  }
  /// Mean over time of the logarithm of a channel's gains.
  double mean_log(int channel) const {
    double sum = 0;
    for (const Vec3& gain : gains) sum += std::log(double(gain[channel]));
    return sum / double(gains.size());
  }
};

/// What a run has learned of all of them, by Frame::camera_id. Empty: nothing is.
class CameraFits {
 public:
  std::vector<CameraFit> cameras;
  bool film = false;  ///< there is one camera, which took every frame

  /// Which of `cameras` took a frame; -1: nobody knows.
  int index_of(const Frame& frame) const { return film ? 0 : frame.camera_id; }
  bool knows(int camera) const {
    return camera >= 0 && camera < int(cameras.size()) && cameras[std::size_t(camera)].trained;
  }
  /// 1 where nothing is known of the camera.
  Vec3 gain_of(const Frame& frame) const {
    const int camera = index_of(frame);
    return knows(camera) ? cameras[std::size_t(camera)].gain_at(frame.time) : Vec3{1, 1, 1};
  }
  /// Model time that a frame shows. A camera's clock leads no further than to the ends of the curves.
  double time_of(const Frame& frame) const {
    const double offset = knows(frame.camera_id) ? cameras[std::size_t(frame.camera_id)].offset : 0;
    if (offset == 0) return frame.time;
    const double t = frame.time + offset;
    return t < 0 ? 0 : t > 1 ? 1 : t;
  }
};

}  // namespace splinevox
