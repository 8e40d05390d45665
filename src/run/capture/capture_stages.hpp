// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "run/capture/capture_cameras.hpp"
#include "run/capture/colmap_program.hpp"

namespace splinevox::run {

/// What an earlier call has done in the folder, and with which options: work/state.json.
struct CaptureState {
  Json request;       ///< what was asked for; another one is another data set
  int done = 0;       ///< stages that are finished
  bool wide = false;  ///< pictures were compared with more of the others, since too few were placed at first
  bool straight = false;  ///< lenses have no distortion, since with one no camera's lens was found
  bool numbered = false;  ///< COLMAP knows frames by numbers; see needs_numbers
  std::vector<CaptureFrame> frames;
  std::vector<std::string> rig;  ///< names of cameras that stand still
  std::vector<std::string> notes;
  Json seconds = Json::object();  ///< of each stage

  bool of_rig() const { return !rig.empty(); }
  /// Whether a frame is of the walk past cameras that stand still.
  bool of_walk(const CaptureFrame& frame) const {
    return of_rig() && std::size_t(frame.camera) >= rig.size();
  }
  bool has_walk() const { return !frames.empty() && of_walk(frames.back()); }
  /// Where COLMAP's models lie, in the folder of the data set.
  const char* models() const { return straight ? kStraightModels : "work/sparse"; }
  static constexpr const char* kStraightModels = "work/sparse_straight";
};
/// Empty if there is none. Throws Error (Fault::input) naming the file.
CaptureState read_capture_state(const std::filesystem::path& folder);
void write_capture_state(const std::filesystem::path& folder, const CaptureState& state);

/// Whether names of frames would mislead COLMAP: its lists end a name at a blank and leave out lines that
/// begin with #, and it takes the order of characters for the order in which one camera took its pictures.
bool needs_numbers(const CaptureState& state);
/// What COLMAP calls a frame: its name, or its number if the state says so.
std::string colmap_name(const CaptureState& state, std::size_t frame);
/// Gives the images of a model, which COLMAP called so, the names of the frames.
void name_frames(data::ColmapModel& model, const CaptureState& state);

constexpr const char* kWalk = "walk";  ///< the name of that camera

/// Of a camera that moves so many pictures are all compared with each other, at first.
constexpr int kAllCompared = 40;

/// What is asked of COLMAP, stage after stage. All throw Error (Fault::input) with what to do, and
/// CaptureStopped. @param folder  of the data set
/// @{
void find_features(const std::filesystem::path& folder, const CaptureState& state,
                   const CaptureOptions& options, ColmapProgram& colmap, CaptureTalk& talk);
/// @param wide  compare pictures with more of the others
void match_features(const std::filesystem::path& folder, const CaptureState& state,
                    const CaptureOptions& options, ColmapProgram& colmap, bool wide);
void find_cameras(const std::filesystem::path& folder, const CaptureState& state,
                  const CaptureOptions& options, ColmapProgram& colmap);
/// @}

/// How many pictures COLMAP is given: all of a camera that moves, those of a few moments of a rig.
int pictures_for_colmap(const CaptureState& state, const CaptureOptions& options);

/// What to film differently. @param figures  what came out, for `got`
[[noreturn]] void fail_placing(const CaptureState& state, const std::string& figures);

/// Writes transforms.json and reads it back. Throws Error.
void write_transforms(const std::filesystem::path& folder, const CaptureState& state,
                      const CapturedScene& scene);

/// Masks that somebody laid beside the frames of an earlier call, which lies in `folder`/`aside`, are not
/// capture's to remove: moves its masks to `folder`/earlier_masks if there are such.
/// @return where they are; empty: there are none
std::filesystem::path keep_drawn_masks(const std::filesystem::path& folder, const std::string& aside);

}  // namespace splinevox::run
