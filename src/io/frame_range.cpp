// SPDX-License-Identifier: Apache-2.0
#include "splinevox/io/frame_range.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "io/check_option.hpp"

namespace splinevox {
namespace {

constexpr double kPastEnd = 1 + 1e-9;  ///< in model time: the last frame may miss 1 by a rounding

}  // namespace

double FrameRange::length() const {
  if (seconds > 0) return seconds;
  return last > start() ? (last - start()) / fps : 1;
}

double FrameRange::time_at(int frame) const { return std::clamp(seconds_at(frame) / length(), 0.0, 1.0); }

double FrameRange::rate_at(int frame) const {
  const double time = seconds_at(frame) / length();
  return time >= 0 && time <= kPastEnd ? 1 / length() : 0;
}

void validate(const FrameRange& o) {
  check_option(o.first >= 0 && o.first <= o.last && o.last < 1'000'000, "--frames",
               "FIRST-LAST, 0 <= FIRST <= LAST < 1000000",
               std::to_string(o.first) + "-" + std::to_string(o.last));
  check_option(o.fps > 0 && o.fps <= 1000, "--fps", "a number in (0, 1000]", option_text(o.fps));
  check_option(o.seconds >= 0 && std::isfinite(o.seconds), "--seconds",
               "a number > 0, or 0 for the length of the sequence", option_text(o.seconds));
  if (!o.at) return;
  check_option(std::abs(*o.at) < 1'000'000, "--at", "a frame between -1000000 and 1000000",
               std::to_string(*o.at));
  check_option(o.seconds > 0 || *o.at < o.last, "--at",
               "a frame before the last one, or --seconds beside it, which says where the motion ends",
               std::to_string(*o.at));
}

}  // namespace splinevox
