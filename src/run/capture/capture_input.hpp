// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "data/pictures/mask_read.hpp"

namespace splinevox::run {

/// What one camera took: a film, or pictures.
struct CaptureCamera {
  std::string name;  ///< the film's or folder's, for its folder of frames; empty where there is one camera
  std::filesystem::path film;
  std::vector<std::filesystem::path> pictures;  ///< in the order in which people count their names
  std::filesystem::path root;                   ///< the folder in which their masks are looked for

  bool is_film() const { return !film.empty(); }
};

/// The cameras that sources stand for. One film, or one folder of pictures: one camera that moves. Several
/// films or folders, or one folder with several of them: as many cameras that stand still. Throws Error
/// (Fault::input) naming what was found.
std::vector<CaptureCamera> find_capture_input(const std::vector<std::string>& sources);

/// Looks for masks as data sets have them (docs/data.md): a plan with one entry per picture, or with none.
/// @param use  --masks of other commands, "subject", "ignore" ...; empty: "ignore" where there are any
/// Throws Error (Fault::input): masks that are asked for and not there, or of another size.
data::MaskPlan find_capture_masks(const CaptureCamera& camera, const std::string& use);

/// Where COLMAP may find features, 1 = there, [height * width * 1]: of masks that say what to ignore in the
/// rest, of masks of a subject around it, since subjects move.
Image feature_mask(const data::MaskPlan& masks, std::size_t i);

}  // namespace splinevox::run
