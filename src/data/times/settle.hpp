// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "data/layouts/raw_scene.hpp"

namespace splinevox::data {

/// Where times come from, as a user asks for it.
struct TimesChoice {
  enum class Source {
    automatic,  ///< the data's own times, else times.txt, else the names
    none,       ///< all pictures are of one moment
    order,      ///< pictures follow each other evenly in the order of their names, as people count
    name,       ///< a group of digits in the names
    file,       ///< a file with a picture's name and a number per line
  };
  Source source = Source::automatic;
  int group = 0;               ///< for `name`, as times_of_group takes it
  std::filesystem::path file;  ///< for `file`
};

/// "", none, order, name:GROUP or a path. Throws Error (Fault::input).
TimesChoice parse_times(const std::string& text);

/// Gives every frame of all splits its time: the one place for it, whatever the layout. Splits that are
/// `timed` have times of the data's own. Says in notes what was used. Throws Error (Fault::input), also where
/// names leave the times unclear: the message lists what `--times` can be.
///
/// A times file (times.txt in the folder, or the one asked for) has a picture's name and a number per line;
/// # at the beginning or behind a blank begins a comment.
void settle_times(const std::filesystem::path& folder, const TimesChoice& choice,
                  std::vector<RawSplit>& splits, std::vector<std::string>& notes);

}  // namespace splinevox::data
