// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "data/layouts/masks.hpp"
#include "data/layouts/raw_scene.hpp"
#include "splinevox/core/image.hpp"
#include "splinevox/core/pixel_mask.hpp"
#include "splinevox/data/image_io.hpp"

namespace splinevox::data {

/// The masks of one split's frames, found and measured but not decoded.
struct MaskPlan {
  MaskUse use = {};
  std::vector<std::filesystem::path> files = {};  ///< of each frame, empty where there is none
  std::vector<std::string> where = {};            ///< how errors name each
  std::vector<int> turns = {};                    ///< as the picture is turned, 1 where the mask is upright
  std::size_t guessed = 0;  ///< turned ones whose size does not tell whether they are upright already
  std::string misfit = {};  ///< the first of those that are of another size than their picture and not used
  std::size_t misfits = 0;
  /// Whether the mask of frame i becomes the alpha of its picture.
  bool cuts_out(std::size_t i) const { return use.what == MaskUse::What::subject && !files[i].empty(); }
};

/// Reads the headers of a split's masks. One of another size than its picture is an Error (Fault::input) if
/// masks are used, else it is left out. A mask lies as its picture is stored or upright, as its size tells;
/// one whose size does not lies as stored.
/// @param sizes  of the pictures once they are turned
MaskPlan plan_masks(const std::filesystem::path& folder, const RawSplit& split, const MaskUse& use,
                    const std::vector<PictureSize>& sizes, const std::vector<int>& turns);

/// One mask as it is stored, turned: 65535 is white.
struct Mask {
  int width = 0, height = 0;
  std::vector<std::uint16_t> white;  ///< [height * width]
  bool of_ones = false;              ///< its file holds 0 and 1
  /// Mean over the pixels, in [0, 1].
  double mean() const;
};
/// Reads the mask of frame i. What it says is its grey; its alpha where that is not the same everywhere and
/// the colours say nothing (one colour, or the cut-out picture); else grey times alpha. Throws Error
/// (Fault::input) for a bad file, and for colours without such an alpha.
/// @pre it has one
Mask read_mask(const MaskPlan& plan, std::size_t i);

/// The picture of frame i without what its mask of the subject leaves out: alpha times the kept share. The
/// same picture where masks are for something else. @pre it is of the mask's size
Image16 cut_out(Image16 picture, const MaskPlan& plan, std::size_t i);

/// Of each frame the pixels that its mask says to ignore: in blocks of `downscale` pixels any of which is
/// less than half kept.
std::vector<PixelMask> read_ignored(const MaskPlan& plan, int downscale);
/// Of each frame the squares in which any pixel moves: all of them where there is no mask.
/// @param sizes  of the pictures once they are turned
std::vector<CoarseMask> read_moving(const MaskPlan& plan, const std::vector<PictureSize>& sizes,
                                    int downscale);
/// Of each frame the pixels whose blocks are white for at least a half.
std::vector<PixelMask> read_inside(const MaskPlan& plan, int downscale);

/// Below it a mask's brightest value may be the number of a part.
constexpr std::uint16_t kLabels = 32 * 257;

/// What some masks, evenly chosen among all, look like.
struct MaskLook {
  std::size_t looked_at = 0, black = 0, white = 0;  ///< of those, wholly black and wholly white ones
  double mean = 0;                                  ///< share of white
  std::uint16_t brightest = 0;
  std::size_t ones = 0, numbers = 0;  ///< of 0 and 1, and with higher values that are all but black
};
/// @param most  masks to read. Throws Error (Fault::input) for the first bad one.
MaskLook look_at_masks(const std::vector<const MaskPlan*>& plans, std::size_t most = 32);

}  // namespace splinevox::data
