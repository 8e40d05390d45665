// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "run/capture/capture.hpp"
#include "run/capture/capture_input.hpp"
#include "run/capture/frame_choice.hpp"

namespace splinevox::run {

/// A picture of the data set to be.
struct CaptureFrame {
  std::string name;  ///< its path in `images`: "cam00/000012.png"
  int camera = 0;
  double time = 0;   ///< seconds
  std::string mask;  ///< path in the data set; empty: none
};

/// What will be taken of one camera.
struct CapturePlan {
  CaptureCamera camera;
  std::vector<double> times;       ///< of all its frames, seconds
  std::vector<FrameGroup> groups;  ///< of each the sharpest is taken
  int width = 0, height = 0;       ///< of frames of a film, as they will be written
  data::MaskPlan masks;            ///< of pictures; with no files where there are none
};

/// Which frames are taken, and what is odd about films and pictures' names as notes. Cameras that stand still
/// get the same moments. Where names of pictures tell these, a camera that lacks one has a gap. Nothing is
/// written. Throws Error (Fault::input).
std::vector<CapturePlan> plan_capture(std::vector<CaptureCamera> cameras, const CaptureOptions& options,
                                      CaptureTalk& talk);
/// The same of a walk past cameras that stand still, of which all is taken that helps.
CapturePlan plan_walk(CaptureCamera camera, const CaptureOptions& options, CaptureTalk& talk);

/// Writes `images`, `masks`, and masks for COLMAP in work/masks. Films become PNG; pictures are copied byte
/// for byte, but for those that EXIF turns, which become upright PNG. Throws Error, CaptureStopped.
std::vector<CaptureFrame> write_capture_frames(const std::vector<CapturePlan>& plans,
                                               const std::filesystem::path& folder, CaptureTalk& talk);

}  // namespace splinevox::run
