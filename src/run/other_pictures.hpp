// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "data/pictures/pictures.hpp"
#include "splinevox/core/image.hpp"
#include "splinevox/data/scene.hpp"

namespace splinevox::run {

/// How pictures of a folder and frames of a split belong together.
enum class MatchBy {
  name,  ///< a picture's name, without its ending, is the frame's
  order  ///< the first in the order in which people count (9 before 10) is of the first frame, and so on
};

/// Pictures that another method made of a split: PNG, JPEG, OpenEXR or TIFF in one folder. Other files in it,
/// and those whose names begin with a dot, do not count.
class OtherPictures {
 public:
  /// Finds and measures all of them. Throws Error (input) naming the first frames without a picture, the
  /// first pictures without a frame, or the first picture of another size than its frame's.
  /// @param split  with its pictures, whose sizes count
  /// @param transfer  DatasetRules::transfer of the split, which floats among the pictures have too
  OtherPictures(const std::string& folder, const Split& split, MatchBy by, const std::string& transfer = "");
  /// The file of a frame's picture, without its folder.
  std::string name(std::size_t frame) const { return plan_.paths[frame].filename().string(); }
  /// The picture of a frame of the split: 3 channels in [0, 1]; what has alpha lies over the background,
  /// light (OpenEXR, floats in TIFF) is as a screen shows it. Throws Error (input).
  Image read(std::size_t frame, const Vec3& background) const;

 private:
  data::PicturePlan plan_;  ///< in the split's order
};

}  // namespace splinevox::run
