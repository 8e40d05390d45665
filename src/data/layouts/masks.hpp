// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "data/layouts/raw_scene.hpp"

namespace splinevox::data {

/// What masks are for, as DatasetRules::masks says.
struct MaskUse {
  enum class What { unsaid, none, subject, ignore, moving };
  /// What of a mask is the scene: what is kept. Of what moves: what stands still.
  enum class Kept { by_name, white, black };
  std::string text = {};
  What what = What::unsaid;
  Kept kept = Kept::white;
  bool of_alpha = false;  ///< masks are the pictures' own alpha, and the pictures opaque

  bool used() const { return what != What::unsaid && what != What::none; }
  /// Whether black is what is kept of this mask. dynamic_mask_NAME marks what moves in white, which is what
  /// nobody wants to see who ignores something.
  bool keeps_black(const std::filesystem::path& mask) const;
};
/// Whether a mask is called dynamic_mask_NAME, whatever its case.
bool is_dynamic_mask(const std::filesystem::path& mask);
/// Throws Error (Fault::input) for what is no use of masks.
MaskUse parse_masks(const std::string& text);

/// What was found. Examples are paths in the data set, empty where there is none.
struct MaskSearch {
  std::size_t frames = 0, found = 0;
  std::string first;
  std::size_t absent = 0;  ///< masks that the data names and that are not there
  std::string first_absent;
  std::size_t several = 0;  ///< pictures for which there were several, none better than the others
  std::string first_several;
  std::string shared;  ///< a mask that by its name is for pictures of several folders
  std::size_t of_films = 0;
};

/// Looks for every picture's mask and sets RawFrame::mask_file: named by the data (RawFrame::mask), beside
/// the picture (dynamic_mask_NAME.png, NAME_mask.png, NAME.png.png), or in a folder of masks (is_mask_folder)
/// in the data set, beside the picture or its folder. Folders in those must not be another picture's.
/// @pre leave_out found the pictures
MaskSearch find_masks(const std::filesystem::path& root, RawScene& scene);

/// Where alpha says what to ignore (RawScene::alpha_ignores) and nobody said what masks are for: every
/// picture becomes its own mask, and `use` is to ignore by alpha. None if pictures have no alpha.
/// @pre leave_out found the pictures
std::optional<MaskSearch> masks_of_alpha(RawScene& scene, MaskUse& use);

/// Where masks are asked for: throws Error (Fault::input) if there are none, or if it is not clear which
/// picture one is for. A picture without its mask is as good as missing where masks show the subject. All of
/// it is used where they say what to ignore, and may move where they say what does, unless `rules` refuse it.
void require_masks(RawScene& scene, const MaskUse& use, const MaskSearch& search, const DatasetRules& rules);

}  // namespace splinevox::data
