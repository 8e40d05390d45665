// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

namespace splinevox {

/// Which frames of a shot are written, and which moment of the model each of them shows. The moments depend
/// on `at`, `fps` and `seconds` alone where these are given: any part of a shot has the times of the whole.
struct FrameRange {
  int first = 1, last = 120;   ///< frame numbers, inclusive; 0 <= first <= last < 1000000
  double fps = 24;             ///< frames per second, in (0, 1000]
  double seconds = 0;          ///< how long model time 0..1 lasts; 0: frame `last` is model time 1
  std::optional<int> at = {};  ///< the frame that shows model time 0; absent: `first`

  int count() const { return last - first + 1; }
  int start() const { return at.value_or(first); }
  /// How long model time 0..1 lasts, seconds, > 0. One frame alone lasts a second.
  double length() const;
  /// From the motion's first moment to a frame, seconds; negative before it.
  double seconds_at(int frame) const { return (frame - start()) / fps; }
  /// What a frame shows, model time in [0, 1]: before the motion its first moment, after it its last.
  double time_at(int frame) const;
  /// Units of model time per second at a frame: 0 before and after the motion.
  double rate_at(int frame) const;
};

/// Throws Error (Fault::input) naming the option, its range and what was given.
void validate(const FrameRange& range);

}  // namespace splinevox
