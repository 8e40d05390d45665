// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "data/layouts/colmap_model.hpp"
#include "run/capture/capture_frames.hpp"

namespace splinevox::run {

/// Frames of the data set with the cameras that were found for them.
struct CapturedScene {
  struct Placed {
    std::size_t frame = 0;            ///< which of the frames
    std::array<double, 16> matrix{};  ///< camera to world, row-major, OpenGL axes
    Camera camera;
  };
  std::vector<Placed> frames;
  Box box{};         ///< around the points, without the outermost hundredth on every side
  double scale = 1;  ///< of the data set's units to COLMAP's
  /// How far cameras went or stand apart (the longest edge of the box around them), in distances of the
  /// points from them (median): what depth can be told from.
  double parallax = 0;
  /// Of cameras that stand still: how far a camera's places at several moments lie apart at most, in the same
  /// unit.
  double unrest = 0;
  int placed = 0, asked = 0;          ///< pictures of the camera that moves, or cameras that stand still
  int odd_lenses = 0;                 ///< of those that found none for a lens that no camera has
  std::vector<std::string> left_out;  ///< names of pictures or cameras that found no place
};

/// The folder of the model with the most images in what COLMAP's mapper wrote, and how many models there are;
/// none where it wrote none.
std::optional<std::pair<std::filesystem::path, int>> largest_model(const std::filesystem::path& folder);

/// Whether a lens is one that cameras have: a focal length of a fifth to five times the longer side, and a
/// distortion that can be undone in all of the picture.
bool is_likely_lens(const Camera& camera);

/// Turns the model so that z is the cameras' mean up, moves its points' box to the origin and gives the box a
/// longest edge of 2. Cameras that stand still get the mean of their poses, for all their frames. Those
/// with a lens that no camera has found no place.
/// @param rig  names of the cameras that stand still, as their folders are called; empty: one that moves
/// Throws Error (Fault::input).
CapturedScene place_frames(const data::ColmapModel& model, const std::vector<CaptureFrame>& frames,
                           const std::vector<std::string>& rig);

/// What to say of models beside the largest, whose share is given; empty where the largest lacks nothing.
std::string models_note(int models, const CapturedScene& scene, const std::string& share);

}  // namespace splinevox::run
