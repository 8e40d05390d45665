// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "run/capture/capture_input.hpp"
#include "run/capture/capture_talk.hpp"

namespace splinevox::run {

/// Frames [first, second) that follow each other, of which one is taken.
using FrameGroup = std::pair<int, int>;

/// Divides the frames whose time is in [from, to].
/// @param times  ascending. @param every  frames of a group; 0: as many groups of one length as `most` says
/// @param most   groups; 0: every frame is one. Of fewer frames than that every frame is one.
std::vector<FrameGroup> frame_groups(const std::vector<double>& times, double from, double to, int every,
                                     int most);

/// For every moment the frame that is nearest to it in time, no frame twice. @param times  ascending
std::vector<FrameGroup> frames_at(const std::vector<double>& times, const std::vector<double>& moments);

/// Times of pictures that follow each other evenly, seconds. @param fps  pictures a second
std::vector<double> ordered_times(std::size_t count, double fps);

/// When the pictures of folders were taken.
struct PictureTimes {
  std::vector<std::vector<double>> times;  ///< of each camera's pictures, seconds, ascending
  bool by_names = false;  ///< names tell them: cameras that saw one moment have the same time for it
};

/// Times by the numbers in the pictures' names, `fps` a second at their usual distance. Where these count no
/// time, pictures follow each other evenly: those of one camera as they are, those of several by the names
/// that most of them share. Cameras with no name in common are paired by order. Notes say what is missing,
/// what is uneven, and what is paired by order.
/// @param cameras  of pictures. Throws Error (Fault::input) where cameras share some names and most not.
PictureTimes picture_times(const std::vector<CaptureCamera>& cameras, double fps, CaptureTalk& talk);

/// How sharp a picture is: the variance of the Laplacian (four neighbours) of its brightness, inside its
/// border; brightness is from 0 to 255. Motion blur and a wrong focus lower it. Pictures smaller than 3 x 3
/// have 0. @param rgb  [height * width * 3]
double sharpness(std::span<const std::uint8_t> rgb, int width, int height);

}  // namespace splinevox::run
