// SPDX-License-Identifier: Apache-2.0
// What motion costs where only a part of a scene moves: two built-in scenes, or those named, trained without
// motion, with motion that is frozen in static regions, and with motion everywhere. PSNR on the test
// split and processor seconds of training.
//
//   taskset -c 0 bench_rest [NAME|DATASET]... [--preset fast] [--steps 2400] [--seeds 3] [--same-box]
//
// One JSON line per run, and one per scene with the medians of ratios. The three runs of a round are made at
// the same time, a thread each; on one core, as above, they share its speed, which on a busy machine changes
// by half within minutes. --same-box: all runs of a scene have the box that a short one ends with, and so the
// same lattices; a box of their own shrinks in some and stays in others.
#include <fmt/core.h>
#include <tbb/global_control.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <future>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/process.hpp"
#include "cost/timing.hpp"
#include "solid_preset.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/data/synth.hpp"
#include "trained.hpp"

using namespace splinevox;

namespace {

enum Way { without, frozen, everywhere, kWays };
constexpr const char* kNames[kWays] = {"no motion", "at rest", "everywhere"};

Config config_of(const Config& base, Way way) {
  Config c = base;
  if (way == without) c.motion.enabled = c.motion.rigidity = c.motion.light = false;
  if (way == everywhere) c.motion.rest = 0;
  return c;
}

void say(const nlohmann::json& j) {
  fmt::print("{}\n", j.dump());
  std::fflush(stdout);
}

/// The box that a run of a quarter of the steps ends with.
std::vector<float> box_of(Config c, Dataset& data) {
  c.run.max_steps /= 4;
  const Box box = train_to_end(c, data).model.box;
  return {box.lo.x, box.lo.y, box.lo.z, box.hi.x, box.hi.y, box.hi.z};
}

void measure(const Config& base, const std::string& name, Dataset& data, int seeds) {
  std::vector<double> psnr[kWays], ratio[kWays];
  for (int seed = 1; seed <= seeds; ++seed) {
    Trained runs[kWays];
    {
      std::vector<std::future<void>> threads;
      for (const Way way : {without, frozen, everywhere})
        threads.push_back(std::async(std::launch::async, [&, way, own = data]() mutable {
          Config c = config_of(base, way);
          c.run.seed = std::uint64_t(seed);
          const double start = thread_seconds();
          runs[way] = train_to_end(c, own);  // prepare writes into the data
          runs[way].seconds = thread_seconds() - start;
        }));
      for (std::future<void>& thread : threads) thread.get();
    }
    for (const Way way : {without, frozen, everywhere}) {
      const Trained& run = runs[way];
      psnr[way].push_back(mean_psnr(run.model, *data.find("test")));
      ratio[way].push_back(run.seconds / runs[without].seconds);
      say({{"scene", name},
           {"seed", seed},
           {"motion", kNames[way]},
           {"psnr", psnr[way].back()},
           {"seconds", run.seconds},
           {"moving_share", run.moving_share}});
    }
  }
  nlohmann::json j{{"scene", name}};
  for (const Way way : {without, frozen, everywhere})
    j[kNames[way]] = {{"psnr", cost::median_of(psnr[way]).value},
                      {"times_no_motion", cost::median_of(ratio[way]).value}};
  say(j);
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<std::string> scenes{"toy", "garden"};
  std::string preset_name = "fast";
  int steps = 2400, seeds = 3;
  CLI::App app("what motion costs where a part of a scene moves");
  app.add_option("scenes", scenes, "names of built-in scenes, folders of data sets");
  app.add_option("--preset", preset_name);
  app.add_option("--steps", steps);
  app.add_option("--seeds", seeds);
  bool same_box = false;
  app.add_flag("--same-box", same_box);
  CLI11_PARSE(app, argc, argv);
  try {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
    Config config = solid_preset(preset_name);
    config.run.max_time = 0;
    config.run.max_steps = steps;
    for (const std::string& scene : scenes) {
      const std::vector<std::string> built_in = synth_scenes();
      const bool made = std::find(built_in.begin(), built_in.end(), scene) != built_in.end();
      Dataset data =
          made ? make_synth(scene, {}) : load_dataset(scene, {.downscale = 1, .splits = {"train", "test"}});
      Config c = config;
      if (same_box) c.grid.box = box_of(config, data);
      measure(c, std::filesystem::path(scene).filename().string(), data, seeds);
    }
  } catch (const Error& e) {
    fmt::print(stderr, "{}\n", e.what());
    return 1;
  }
}
