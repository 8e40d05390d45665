// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "data/layouts/raw_scene.hpp"
#include "data/pictures/mask_read.hpp"
#include "splinevox/data/image_io.hpp"

namespace splinevox::data {

/// The pictures of one split, found and measured but not decoded.
struct PicturePlan {
  std::vector<std::filesystem::path> paths;
  std::vector<std::string> where;  ///< how errors name each
  std::vector<PictureSize> sizes;  ///< pixels, after turning
  std::vector<int> asked;          ///< EXIF's orientation or a film's, 1 where there is none
  std::vector<int> turns;          ///< the same where it is obeyed, else 1: cameras are for the stored pixels
  bool guessed = false;            ///< EXIF turns a picture whose lens does not tell for which pixels it is
  bool alpha = false;              ///< some file has a channel for it
  std::vector<int> pixel_bytes;    ///< that each is likely to take once it is decoded
  std::vector<char> real, linear;  ///< whether each holds floats, and whether they stand for light
  std::string layer = {};          ///< of OpenEXR
  int downscale = 1;
  std::vector<int> film_frame;  ///< as in RawFrame
  MaskPlan masks = {};          ///< what of the pictures is kept
  bool film() const { return !film_frame.empty() && film_frame[0] >= 0; }
};

/// A name for each frame, as its own file's or what the data set calls it, that no other frame of the split
/// has and no path can trip over.
std::vector<std::string> frame_names(const RawSplit& raw, const PicturePlan& plan);

/// "400 x 300".
std::string size_text(const PictureSize& size);
/// Whether both may be of one picture, of which one is smaller: sides were rounded to whole pixels.
bool same_shape(const PictureSize& a, const PictureSize& b);

/// Reads the headers of a split's pictures, which were found. Throws Error (Fault::input) for the first frame
/// whose picture is not a PNG, JPEG or film, smaller than the downscale, or of another size than frame
/// 0's though its lens does not say what size it is for (w, h, fl_x): an angle of view means nothing for a
/// picture that was cropped. Where neither sizes nor angles tell whether cameras are for pictures turned by
/// EXIF, pictures are as stored: programs that find cameras ignore the tag. Films are upright then: cameras
/// were found in pictures as players show them.
/// @param rules    transfer and layer
PicturePlan plan_pictures(const std::filesystem::path& folder, const RawSplit& split, int downscale,
                          const DatasetRules& rules = {});

/// What was taken for light, and how it is trained.
void note_transfer(const RawSplit& raw, const PicturePlan& plan, std::vector<std::string>& notes);

}  // namespace splinevox::data
