// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>

#include "data/pictures/pictures.hpp"
#include "data/pictures/tiff_read.hpp"
#include "splinevox/core/image.hpp"

namespace splinevox::data {

/// What the pixels of one picture tell, found in one pass.
struct PictureFacts {
  std::uint64_t hash = 0;    ///< of size and pixels
  bool see_through = false;  ///< some pixel has alpha < 1
  bool invisible = true;     ///< every pixel has alpha 0
  bool black = true;         ///< every pixel is black or has alpha 0
  bool odd = false;          ///< the file has values below 0 or that are not finite; facts_of cannot know
};
PictureFacts facts_of(const Picture& image);

struct Decoded {
  Picture picture;
  PictureFacts facts;
};
/// One picture of a plan without films: turned, averaged and as a screen shows it. Averages are of what the
/// file holds: of linear light, if it is that. Where colours were stored times alpha, or a mask cuts the
/// picture out, they count by alpha. Throws Error (input).
Decoded decode_one(const PicturePlan& plan, std::size_t i);
/// The pixels it is made of: the file's own numbers, turned and cut out.
FilePixels kept_pixels(const PicturePlan& plan, std::size_t i);

/// Called with a picture's place in the plan, one at a time, in any order.
using TakePicture = std::function<void(std::size_t i, Picture&& picture, const PictureFacts& facts)>;

/// Decodes on all cores and hands over each picture once. Of those that are not handed over yet there are a
/// few per core. If several pictures are bad, the Error is always that of the first of them.
void decode(const PicturePlan& plan, const TakePicture& take);

/// Bytes that pictures take.
struct PictureMemory {
  double kept = 0;     ///< all of them, once they are decoded
  double pixels = 0;   ///< of them all, after the downscale
  double passing = 0;  ///< beside them while they are decoded
};
PictureMemory memory_for(const PicturePlan& plan, int threads);

}  // namespace splinevox::data
