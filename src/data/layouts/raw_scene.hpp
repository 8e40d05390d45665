// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "data/camera_check.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/core/vec3.hpp"
#include "splinevox/data/image_io.hpp"
#include "splinevox/data/scene.hpp"

namespace splinevox::data {

/// One frame as a reader understood it: checked, its picture not yet read.
struct RawFrame {
  std::string file_path;            ///< as written: a picture, or a film
  double time = 0;                  ///< the data's own, if the split is timed; else settle_times gives it
  std::array<double, 16> matrix{};  ///< camera to world, row-major, OpenGL axes
  RigidPose pose;
  Lens lens;
  int film_frame = -1;         ///< which picture of a film, from 0; -1: file_path is a picture
  PictureSize film_size = {};  ///< of that film's pictures, as stored
  int film_turn = 1;           ///< how a player turns them, as EXIF's orientation would say it
  std::string name = {};       ///< as reports show it; empty: the file's name without folder and extension
  std::string label = {};      ///< how messages name it; empty: by its number
  std::optional<Error> fault = {};  ///< what is wrong with its camera, for leave_out
  std::filesystem::path found =
      {};                 ///< the file that file_path names, links resolved, once it was looked for
  std::string mask = {};  ///< its mask's path as the data names it, or as find_masks found it
  std::filesystem::path mask_file = {};   ///< the file of that, links resolved; empty: there is none
  std::string depth = {};                 ///< its depth map's path as the data names it; empty: none
  std::optional<double> depth_unit = {};  ///< scene units of one of its numbers, where the data says that
  std::string camera = {};                ///< the name of the camera that took it, where the data names one
  int camera_id = -1;                     ///< which of Dataset::cameras, by settle_cameras
  std::size_t order = 0;                  ///< in time among all pictures of all splits, by open_scene
};

/// Sets a frame's matrix and pose. A matrix that is no camera becomes the frame's fault.
void set_pose(RawFrame& frame, const std::array<double, 16>& matrix, const std::string& where);

/// One part of a data set: a transforms file, or some of the frames of another layout.
struct RawSplit {
  std::string name;   ///< "train", "val" or "test"
  std::string file;   ///< how messages name the file the cameras come from
  bool timed = true;  ///< whether the data gives its frames times
  std::vector<RawFrame> frames;
  std::vector<std::string> notes = {};  ///< what its file made one wonder about
  std::string tracks = {};              ///< path of the tracks that its file names; empty: none

  /// "lego/transforms_train.json, frame 12"
  std::string where(std::size_t frame) const {
    return file + ", " +
           (frame < frames.size() && !frames[frame].label.empty() ? frames[frame].label
                                                                  : "frame " + std::to_string(frame));
  }
};

/// What a reader understood of a folder.
struct RawScene {
  std::vector<RawSplit> splits;  ///< train first
  bool one_list = false;        ///< the data names no splits: `splits` has one with all frames, to be divided
  std::optional<Box> box = {};  ///< where the scene lies, scene units
  std::vector<std::string> notes = {};
  std::vector<RigCamera> cameras = {};
  bool alpha_ignores = false;  ///< the pictures' alpha is 0 at pixels to ignore, not where nothing is
};

/// Leaves out frames that are faulty or of which `look_for` does not find what it looks for, and says how
/// many. Throws the first one's Error where `rules` or their number forbid it.
/// @param look_for  sets the frame's `found`, or says what is missing
/// @param lack      what is said of those, before "left out"
void leave_out(RawScene& scene, const DatasetRules& rules,
               const std::function<std::optional<Error>(RawFrame&, const std::string& where)>& look_for,
               const std::string& lack = "pictures are missing and");

/// Divides a scene that has one list. Of a rig (rig_cameras.hpp, cameras_to_hold_out) whole cameras become
/// the test split. Else it is every eighth frame in the order of time, of each camera in its turn, and the
/// others train. The first and the last moment always train: pictures of theirs are held out only where four
/// or more cameras see them. Says so in notes. Throws Error (Fault::input) where `rule` names no camera, or
/// all of them.
/// @param rule  DatasetRules::hold_out
void hold_out(RawScene& scene, const std::string& rule);

/// Sorts frames by time, then by picture and place in the film.
void sort_by_time(RawSplit& split);

/// A camera-to-world matrix from the rows of a rotation and a position. @param columns  the camera's x, y and
/// z axes in the world.
std::array<double, 16> matrix_of(const std::array<Vec3d, 3>& columns, const Vec3d& position);

/// The camera-to-world matrix, OpenGL axes, of a camera that maps x of the world to R x + t with OpenCV's
/// axes.
/// @param rows  of R: the camera's axes in the world, right, down and forwards
std::array<double, 16> matrix_of_opencv(const std::array<Vec3d, 3>& rows, const Vec3d& t);

/// The box around what all cameras of `split` see between their depths, the nearest and furthest tenth of the
/// cameras' left out. `near_far`: one pair per frame, depths along the axis in scene units; pictures are
/// taken to be w x h of their lens.
Box frusta_box(const RawSplit& split, const std::vector<std::array<double, 2>>& near_far);

/// The box around points, without the outermost hundredth on every side, made a tenth wider. None for fewer
/// than 10 points.
std::optional<Box> points_box(std::vector<Vec3d> points);

/// Readers of one layout each: whether the folder looks like it, and everything it says. All throw Error
/// (Fault::input).
/// @{
bool is_nerfstudio(const std::filesystem::path& folder);
RawScene read_nerfstudio(const std::filesystem::path& folder);
bool is_gibson(const std::filesystem::path& folder);
RawScene read_gibson(const std::filesystem::path& folder);
bool is_colmap(const std::filesystem::path& folder);
RawScene read_colmap(const std::filesystem::path& folder);
bool is_nerfies(const std::filesystem::path& folder);
RawScene read_nerfies(const std::filesystem::path& folder);
bool is_llff(const std::filesystem::path& folder);
RawScene read_llff(const std::filesystem::path& folder);
bool is_nrnerf(const std::filesystem::path& folder);
RawScene read_nrnerf(const std::filesystem::path& folder);
bool is_dynerf(const std::filesystem::path& folder);
RawScene read_dynerf(const std::filesystem::path& folder);
bool is_dynamic_gaussians(const std::filesystem::path& folder);
RawScene read_dynamic_gaussians(const std::filesystem::path& folder);
bool is_pinf(const std::filesystem::path& folder);
RawScene read_pinf(const std::filesystem::path& folder);
bool is_easymocap(const std::filesystem::path& folder);
RawScene read_easymocap(const std::filesystem::path& folder);
/// @}

}  // namespace splinevox::data
