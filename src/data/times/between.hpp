// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "data/layouts/raw_scene.hpp"

namespace splinevox::data {

/// A part of a data set's time, in its own unit; both ends belong to it.
struct Between {
  double from, to;
};

/// "FROM:TO", FROM < TO; empty: none. Throws Error (Fault::input).
std::optional<Between> parse_between(const std::string& text);

/// Leaves out the frames of all splits that lie outside, and splits of which none is left, and says so.
/// Throws Error (Fault::input) where nothing is left of the first split or of one that is asked for.
/// @pre times are settled
void keep_between(const Between& part, const std::vector<std::string>& asked, std::vector<RawSplit>& splits,
                  std::vector<std::string>& notes);

}  // namespace splinevox::data
