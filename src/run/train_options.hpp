// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "splinevox/train/config.hpp"

namespace splinevox::run {

/// The command line of `train` as typed.
struct TrainOptions {
  std::string dataset, out, config_file, device = "auto", effects = "auto";
  std::optional<std::string> preset, background;
  std::vector<std::string> sets;
  std::optional<double> max_time;
  std::optional<int> max_steps, downscale;
  std::optional<std::uint64_t> seed;
  int threads = 0;
  bool resume = false, quiet = false, json = false, list_settings = false, deterministic = false;
};

/// The effective configuration: preset (or, when a run is resumed, the one it has), then the TOML file, then
/// --set, then the named flags. Validated. Throws Error.
Config effective_config(const TrainOptions& options, const Config* resumed);

/// "white", "black" or "R,G,B" as three numbers. Throws Error naming --background.
std::vector<float> parse_background(const std::string& text);

}  // namespace splinevox::run
