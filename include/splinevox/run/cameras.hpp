// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "splinevox/core/camera.hpp"
#include "splinevox/run/run.hpp"

namespace splinevox::run {

/// One picture to render.
struct Shot {
  Camera camera;
  double time = 0;  ///< the model's, in [0, 1]
};

struct CameraRequest {
  std::string camera =
      "orbit";        ///< "dataset:SPLIT", "dataset:SPLIT:INDEX", "orbit" or the path of a transforms file
  std::string times;  ///< "", "T" or "A:B:N"
  std::string data;   ///< data set of dataset:..., empty = the run's own
  int size = 0;  ///< width of pictures whose camera does not say, and of orbits; 0 = the data set's or 400
  double elevation = 20;  ///< of the orbit, degrees
};

/// What to render. N times and C cameras give N shots that go through the cameras in order (one camera stands
/// still); without times each camera has its own. Throws Error (input).
std::vector<Shot> plan_shots(const Run& run, const CameraRequest& request);

}  // namespace splinevox::run
