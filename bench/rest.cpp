// SPDX-License-Identifier: Apache-2.0
// What motion costs where only a part of a scene moves: built-in scenes, and others if named, trained without motion, with motion that comes to
// rest where nothing moves, and with motion everywhere, in turn. PSNR on the test split and processor seconds of training.
//
//   bench_rest [DATASET]... [--preset fast] [--steps 2400] [--seeds 3]
//
// One JSON line per run, and one per scene with the medians of ratios; a round of three runs is compared within itself.
#include <fmt/core.h>
#include <tbb/global_control.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "cost/timing.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/data/synth.hpp"
#include "trained.hpp"

using namespace splinevox;

namespace {

enum Way { still, at_rest, everywhere, kWays };
constexpr const char* kNames[kWays] = {"no motion", "at rest", "everywhere"};

Config config_of(const Config& base, Way way) {
  Config c = base;
  if (way == still) c.motion.enabled = c.motion.rigidity = c.motion.light = false;
  if (way == everywhere) c.motion.rest = 0;
  return c;
}

void say(const nlohmann::json& j) { fmt::print("{}\n", j.dump()), std::fflush(stdout); }

void measure(const Config& base, const std::string& name, const Dataset& data, int seeds) {
  std::vector<double> psnr[kWays], ratio[kWays];
  for (int seed = 1; seed <= seeds; ++seed) {
    double seconds[kWays];
    for (const Way way : {still, at_rest, everywhere}) {
      Config c = config_of(base, way);
      c.run.seed = std::uint64_t(seed);
      const Trained run = train_to_end(c, data);
      seconds[way] = run.seconds;
      psnr[way].push_back(mean_psnr(run.model, *data.find("test")));
      ratio[way].push_back(seconds[way] / seconds[still]);
      say({{"scene", name}, {"seed", seed}, {"motion", kNames[way]}, {"psnr", psnr[way].back()}, {"seconds", seconds[way]}, {"moving_share", run.moving_share}});
    }
  }
  nlohmann::json j{{"scene", name}};
  for (const Way way : {still, at_rest, everywhere}) j[kNames[way]] = {{"psnr", cost::median_of(psnr[way]).value}, {"times_no_motion", cost::median_of(ratio[way]).value}};
  say(j);
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<std::string> datasets;
  std::string preset_name = "fast";
  int steps = 2400, seeds = 3;
  CLI::App app("what motion costs where a part of a scene moves");
  app.add_option("datasets", datasets);
  app.add_option("--preset", preset_name);
  app.add_option("--steps", steps);
  app.add_option("--seeds", seeds);
  CLI11_PARSE(app, argc, argv);
  try {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
    Config config = preset(preset_name);
    config.run.max_time = 0, config.run.max_steps = steps;
    for (const char* name : {"toy", "garden"}) measure(config, name, make_synth(name, {}), seeds);
    for (const std::string& path : datasets)
      measure(config, std::filesystem::path(path).filename().string(), load_dataset(path, {.downscale = 1, .splits = {"train", "test"}}), seeds);
  } catch (const Error& e) {
    fmt::print(stderr, "{}\n", e.what());
    return 1;
  }
}
