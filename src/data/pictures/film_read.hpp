// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "splinevox/core/image.hpp"

namespace splinevox::data {

struct FilmFacts {
  int width = 0, height = 0;  ///< pixels as stored, before any rotation a player would do
  int frames = 0;
};

/// Size and number of frames of a film's first video stream, asked of ffprobe. Throws Error (Fault::input) if
/// the file is no film or larger than PNGs may be (splinevox/data/image_io.hpp), or there is no ffprobe.
FilmFacts film_facts(const std::filesystem::path& path, const std::string& where);

/// Decodes a film with ffmpeg, frame by frame, opaque RGBA, and hands over those that are wanted.
/// @param wanted  numbers from 0, ascending. @param take  called with the place in `wanted` and the picture.
/// Throws Error (Fault::input) if ffmpeg fails or the film ends before the last of them.
void read_film(const std::filesystem::path& path, const FilmFacts& facts, const std::vector<int>& wanted,
               const std::function<void(std::size_t, Image16&&)>& take, const std::string& where);

}  // namespace splinevox::data
