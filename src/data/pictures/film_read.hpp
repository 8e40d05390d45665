// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "splinevox/core/image.hpp"
#include "splinevox/data/image_io.hpp"

namespace splinevox::data {

struct FilmFacts {
  int width = 0, height = 0;  ///< pixels as stored, before any rotation a player would do
  double rate = 1;            ///< frames a second, on the mean
  std::vector<double> times;  ///< of each frame that is shown, seconds from the first, ascending
  int rotation = 0;           ///< degrees by which a player turns it clockwise: 0, 90, 180 or 270
  std::string transfer = {};  ///< the curve of its values as ffprobe calls it, "smpte2084"; may be empty
  double pixel_aspect = 1;    ///< width of a stored pixel over its height
  bool interlaced = false;    ///< each frame holds two moments, in every other row
  int frames() const { return int(times.size()); }
  /// The rotation as EXIF says it, for `turned` (picture_header.hpp).
  int orientation() const { return rotation == 90 ? 6 : rotation == 180 ? 3 : rotation == 270 ? 8 : 1; }
};

/// Size and time stamps of a film's first video stream, asked of ffprobe, which reads no picture. What an
/// edit list hides (films cut without encoding again) is left out, as ffmpeg leaves it out. Time stamps
/// within a twentieth of a frame of an even rate are put onto that rate, so that films of one rate share
/// their moments. Throws Error (Fault::input) if the file is no film or larger than PNGs may be
/// (splinevox/data/image_io.hpp), or there is no ffprobe.
FilmFacts film_facts(const std::filesystem::path& path, const std::string& where);

/// What a user should know of a film whose pictures do not look as a player shows them, and what to do: that
/// it is interlaced, or HDR.
std::vector<std::string> oddities_of(const FilmFacts& film);

/// Decodes a film with ffmpeg 5.1 or later, frame by frame, and hands over those wanted, opaque RGBA.
/// @param size     of its frames, once they are turned
/// @param upright  whether they are turned as a player turns them; else they come as stored
/// @param wanted   numbers from 0, ascending
/// @param take     called with the place in `wanted` and the picture
/// Throws Error (Fault::input) if ffmpeg fails or the film ends before the last of them.
void read_film(const std::filesystem::path& path, const PictureSize& size, bool upright,
               const std::vector<int>& wanted, const std::function<void(std::size_t, Image16&&)>& take,
               const std::string& where);

/// The same of a film upright, scaled to `size` by areas.
/// @param frames  that are handed over at most, 1 or more
/// @param take    called with the frame's number and its pixels, [height * width * 3]; false: no more of them
/// Throws Error (Fault::input) if ffmpeg fails or the film ends before.
void read_film_scaled(const std::filesystem::path& path, const PictureSize& size, int frames,
                      const std::function<bool(int, std::span<const std::uint8_t>)>& take,
                      const std::string& where);

}  // namespace splinevox::data
