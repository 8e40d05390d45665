// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace splinevox::data {

/// A picture as far as its name and its camera's place go.
struct NamedPicture {
  std::string path;       ///< within the data set, as written there
  std::size_t place = 0;  ///< equal for pictures of one pose
  std::size_t split = 0;  ///< which of the data's own splits lists it
};

/// What the names of all pictures of a set say of their times.
struct NamesRead {
  enum class Verdict {
    times,       ///< a number in every name is its time
    one_moment,  ///< the numbers count cameras or photographs
    unclear,     ///< the user must say
  };
  Verdict verdict = Verdict::unclear;
  bool sure = false;          ///< false: a guess, to be said with what to give if it is wrong
  std::vector<double> times;  ///< one per picture; empty unless verdict is `times`
  std::string reason;         ///< why, as half a sentence
};

/// Understands names over the whole set. Evidence, strongest first:
///  1. a date and time of day, nanoseconds since 1970, or decimals: the time;
///  2. poses that repeat: a camera that stands still is in the numbers that are the same at one pose, and
///     time in the one that changes;
///  3. words right before or behind a number: camera, view ...; frame, time ...;
///  4. folders: a number that counts up within folders that have numbers or words of their own;
///  5. what is left over, if it is one number that counts up.
/// A number that lies far off all others makes the result unclear.
NamesRead read_names(const std::vector<NamedPicture>& pictures);

/// The times that one group of digits gives. @param group  from 1 at the left, or from -1 at the right, over
/// folders and name. Throws Error (Fault::input) naming the first picture that has no such group.
std::vector<double> times_of_group(const std::vector<NamedPicture>& pictures, int group);

/// The groups of digits of a path, numbered as `--times name:GROUP` counts them: "1: 0007, 2: 03".
std::string list_groups(const std::string& path);

/// Orders names as people count: a2 before a10.
bool natural_less(const std::string& a, const std::string& b);

}  // namespace splinevox::data
