// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "splinevox/data/scene.hpp"

namespace splinevox {

/// What a run has learned of one camera of a rig.
struct CameraFit {
  Vec3 gain{1, 1, 1};    ///< display values of its pictures over those of the model, per channel
  double offset = 0;     ///< model time that its pictures show later than their times say
  double interval = 0;   ///< model time between its pictures, the median
  bool trained = false;  ///< it took enough of the training pictures to learn from
};

/// What a run has learned of all of them, by Frame::camera_id. Empty: nothing is.
class CameraFits {
 public:
  std::vector<CameraFit> cameras;

  bool knows(int camera) const {
    return camera >= 0 && camera < int(cameras.size()) && cameras[std::size_t(camera)].trained;
  }
  /// 1 where nothing is known of the camera.
  Vec3 gain_of(const Frame& frame) const {
    return knows(frame.camera_id) ? cameras[std::size_t(frame.camera_id)].gain : Vec3{1, 1, 1};
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
