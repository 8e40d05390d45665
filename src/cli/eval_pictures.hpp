// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "run/other_pictures.hpp"
#include "splinevox/run/run.hpp"

namespace splinevox::cli {

/// The words of `eval`.
struct EvalOptions {
  std::string run, data, split = "test", images, pictures, truth_volume, device = "auto", masks, out,
                         antialias = "auto";
  std::string match = "name";
  std::vector<std::string> metrics;
  int threads = 0;
  bool json = false, truth = false;
  run::Otherwise otherwise;
  run::PictureRoom room;
};

/// Whether a file that --out would replace is one of figures.
bool are_figures(std::string_view start);

/// `eval --pictures`: another method's pictures on the truth of a run, or of --data alone.
int eval_pictures(const EvalOptions& options);

}  // namespace splinevox::cli
