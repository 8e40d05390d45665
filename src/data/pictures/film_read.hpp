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
  bool sideways = false;      ///< a player turns it by a quarter: width and height change places
  std::string transfer = {};  ///< the curve of its values as ffprobe calls it, "smpte2084"; may be empty
  int frames() const { return int(times.size()); }
};

/// Size and time stamps of a film's first video stream, asked of ffprobe, which reads no picture. What an
/// edit list hides (films cut without encoding again) is left out, as ffmpeg leaves it out. Time stamps
/// within a twentieth of a frame of an even rate are put onto that rate, so that films of one rate share
/// their moments. Throws Error (Fault::input) if the file is no film or larger than PNGs may be
/// (splinevox/data/image_io.hpp), or there is no ffprobe.
FilmFacts film_facts(const std::filesystem::path& path, const std::string& where);

/// Decodes a film with ffmpeg, frame by frame, opaque RGBA, and hands over those that are wanted.
/// @param wanted  numbers from 0, ascending. @param take  called with the place in `wanted` and the picture.
/// Throws Error (Fault::input) if ffmpeg fails or the film ends before the last of them.
void read_film(const std::filesystem::path& path, const PictureSize& size, const std::vector<int>& wanted,
               const std::function<void(std::size_t, Image16&&)>& take, const std::string& where);

/// Decodes a film as a player shows it: turned as its container says, and scaled to `size` by areas.
/// @param frames  that are handed over at most. @param take  called with the frame's number and its pixels,
/// [height * width * 3]; false: no more of them.
/// Throws Error (Fault::input) if ffmpeg fails or the film ends before.
void read_film_upright(const std::filesystem::path& path, const PictureSize& size, int frames,
                       const std::function<bool(int, std::span<const std::uint8_t>)>& take,
                       const std::string& where);

}  // namespace splinevox::data
