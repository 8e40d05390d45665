// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace splinevox {

/// Where the time of a layer runs.
struct UsdTime {
  int first = 1, last = 1;  ///< time codes, which are frame numbers
  double fps = 24;          ///< of them a second
};

/// The first lines of a .usda layer whose default prim is `root`. Z is up, a scene unit is a metre.
/// @param doc  empty: none
std::string usd_head(const std::string& root, const UsdTime& time, const std::string& doc = "");

/// The time codes a second that usd_head wrote; none: the text is no such layer.
std::optional<double> usd_rate(const std::string& text);

/// Of `count` samples those that are needed: one that is like both beside it says nothing new, in whatever
/// way programs go from sample to sample. @param same  whether samples i and j are
std::vector<std::size_t> usd_samples(std::size_t count,
                                     const std::function<bool(std::size_t, std::size_t)>& same);

/// Lines of an attribute within a prim of the layer's root: one value, or one for each of these time codes.
/// @param declaration  type and name  @param value  text of sample i
/// @param samples  which of the frames have one; `plain`: there is one value, the first, for all time
std::string usd_attribute(const std::string& declaration, const std::vector<int>& frames,
                          const std::vector<std::size_t>& samples, bool plain,
                          const std::function<std::string(std::size_t)>& value);

}  // namespace splinevox
