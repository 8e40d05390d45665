// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "data/pictures/decode.hpp"

namespace splinevox::data {

/// Decoded pictures of a split in a file that is mapped: for those that do not fit into memory. It may be
/// deleted at any time; who has it open keeps it. docs/formats.md has its format.
struct PictureCache {
  std::string path;       ///< one for a folder, split and downscale: what is out of date is replaced
  std::uint64_t key = 0;  ///< of what was decoded: paths, sizes and times of the files, and how
  std::string about;      ///< a line of text at the beginning of the file
};

struct StoredPictures {
  std::vector<Picture> pictures;
  std::vector<PictureFacts> facts;
};

/// `asked`, else splinevox in $XDG_CACHE_HOME, else in ~/.cache. Throws Error (input) if there is no home.
std::string cache_folder(const std::string& asked);

PictureCache cache_of(const std::string& folder, const std::string& dataset, const std::string& split,
                      const PicturePlan& plan);

/// @param why  set where a file is there that cannot be used
std::optional<StoredPictures> open_cache(const PictureCache& cache, const PicturePlan& plan,
                                         std::string& why);

/// Opens a cache, or decodes the pictures into it first. Of processes that want the same one, one makes it
/// and the others wait. Throws Error: output if it cannot be written, input for bad pictures.
StoredPictures through_cache(const PictureCache& cache, const PicturePlan& plan,
                             std::vector<std::string>& notes);

}  // namespace splinevox::data
