// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
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

/// Names of ways that CameraRequest::camera knows.
///
/// | name | way |
/// | --- | --- |
/// | auto | orbit where training cameras surround the scene, else what suits them; the choice is noted |
/// | orbit | round the box, z upwards |
/// | stabilised | that of a film of one camera, without its shake |
/// | interpolate | through the training cameras and back |
/// | spiral | an ellipse around the mean training camera |
/// | held | one training camera, the one in the middle, while time runs |
/// | data | the data set's own: transforms_render.json in its folder |
std::vector<std::string> camera_ways();

struct CameraRequest {
  /// One of camera_ways(), "dataset:SPLIT", "dataset:SPLIT:INDEX" or the path of a transforms file.
  std::string camera = "auto";
  std::string times;  ///< "", "T" or "A:B:N"
  std::string data;   ///< the data set, empty = the run's own
  int size = 0;       ///< width of pictures: of an orbit, 0 = 400; of another way, 0 = that of the training
                      ///< pictures; of a camera of a file that does not say, 0 = 400
  double elevation = 20;  ///< of the orbit, degrees
  double window = 0.2;    ///< of stabilised: the share of the film that a camera is fitted to, in (0, 1]
  std::vector<double> moments = {};  ///< in place of `times`: the model times themselves, in [0, 1]
};

/// What to render. N times and C cameras give N shots that go through the cameras in order (one camera stands
/// still); without times each camera has its own. A way is as long as its times: without any it has 60 shots,
/// or as many as the film that it follows, 600 at most. Throws Error (input).
/// @param on_note  called with a line on what was chosen; may be empty
std::vector<Shot> plan_shots(const Run& run, const CameraRequest& request,
                             const std::function<void(const std::string&)>& on_note = {});

/// Cameras of a transforms file whose frames are numbered (`frame`), as `render --format cameras` and
/// load_in_blender.py write them. Empty where CameraRequest::camera is no file, has one camera, or where a
/// frame has no number of its own. Throws Error (input).
std::map<int, Camera> numbered_cameras(const Run& run, const CameraRequest& request,
                                       const std::function<void(const std::string&)>& on_note = {});

}  // namespace splinevox::run
