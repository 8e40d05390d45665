// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "run/capture/capture_talk.hpp"

/// From films or bare pictures to a data set: frames by ffmpeg, cameras by COLMAP, a nerfstudio folder.
namespace splinevox::run {

struct CaptureOptions {
  std::vector<std::string> sources;  ///< a film, a folder, or a film or folder per camera
  std::string out;
  std::string walk;  ///< a film or folder of a camera that walks past the others, to find their places by
  int every = 0;     ///< the sharpest of so many frames that follow each other; 0: not given
  int frames = 0;    ///< so many frames of each camera; 0: not given
  double from = 0, to = std::numeric_limits<double>::infinity();  ///< seconds of a film
  int max_size = 1280;  ///< longer side of frames of films, pixels; 0: as they are
  double fps = 1;       ///< of pictures, a second
  std::string masks;    ///< what masks beside pictures are for; see find_capture_masks
  std::string lens;     ///< a name of capture_lenses(); empty: as the kind of input asks for
  int moments = 3;      ///< at which cameras that stand still are placed
  int threads = 0;      ///< 0: every core
  bool fresh = false;   ///< what an earlier call left in the folder is replaced
};

/// Names of lenses: "pinhole", "radial", "opencv", "fisheye".
std::vector<std::string> capture_lenses();

/// Frames of a film, unless options say otherwise.
constexpr int kUsualFrames = 150;
/// The share of pictures or cameras that must find their place.
constexpr double kLeastPlaced = 1.0 / 3;

/// Writes the data set, going on where an earlier call with the same options was stopped: transforms.json,
/// images, masks, capture.json, and in `work` what COLMAP made. One that begins anew keeps in
/// `earlier_capture` what was there, until the new data set is.
/// @return what capture.json holds: docs/capture.md
/// Throws CaptureStopped if the talk was asked to stop. Throws Error: Fault::input for options, sources,
/// missing programs and pictures that find no place; Fault::output.
Json capture(const CaptureOptions& options, CaptureTalk& talk);

}  // namespace splinevox::run
