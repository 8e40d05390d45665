// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "data/layouts/raw_scene.hpp"

namespace splinevox::test {

/// A split of frames of which only the times are known.
inline data::RawSplit split_of(const std::string& name, const std::vector<double>& times) {
  data::RawSplit split{name, "s/transforms_" + name + ".json", true, {}};
  for (const double t : times) {
    split.frames.emplace_back();
    split.frames.back().time = t;
  }
  return split;
}

}  // namespace splinevox::test
