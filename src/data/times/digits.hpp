// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace splinevox::data {

/// A group of digits in a picture's path, as a number.
struct NameNumber {
  enum class Kind {
    count,    ///< whole numbers such as 0007
    decimal,  ///< 0.25
    clock,    ///< date and time of day, or milli-, micro- or nanoseconds since 1970
  };
  double value = 0;              ///< of a clock in seconds since any one moment that all names share
  std::int64_t nanoseconds = 0;  ///< of a clock, since 1970: a double of seconds has no microseconds left
  Kind kind = Kind::count;
  std::string digits;  ///< as written
  std::string before;  ///< the letters right before it, in lower case, separators left out; may be empty
  std::string after;   ///< the letters right behind it, likewise
};

/// A path in parts: what is counted, and everything else.
struct NameParts {
  std::vector<NameNumber> folder, stem;  ///< groups of digits in the folders and in the file's own name
  std::string folder_text, stem_text;    ///< the rest, with '#' where a group was
};

/// Takes a path within a data set apart. The ending of a picture is left out, and so are: the copy number of
/// " (1)", units such as the 1080p of "_1080p" or the 2x of "_2x", and identifiers (UUIDs, long hexadecimal
/// numbers), whose digits count nothing.
/// @param decimals  whether two groups with a point between them are one number.
NameParts take_apart(std::string_view path, bool decimals);

/// Gives clocks their values: seconds since the first of them.
void count_from_first(std::vector<NameNumber>& clocks);

/// The path without the ending of a picture and without a leading "./".
std::string_view bare_name(std::string_view path);

}  // namespace splinevox::data
