// SPDX-License-Identifier: Apache-2.0
// Samples per second of training, forward and backward with motion, and where the time of a step goes.
//
//   bench_training [DATASET] [threads]     DATASET: default $SPLINEVOX_DATA/dnerf_trex, or the built-in
//   dancer
//
// The run is cut by steps, so it does the same work on every machine. The last 500 steps are measured: all
// levels are on, and one refresh of the occupancy falls among them, as it does in any 500 steps.
#include <fmt/core.h>
#include <tbb/global_control.h>

#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string>

#include "solid_preset.hpp"
#include "splinevox/data/synth.hpp"
#include "splinevox/train/prepare.hpp"
#include "splinevox/train/trainer.hpp"

using namespace splinevox;

namespace {
constexpr int kSteps = 1200, kMeasured = 500;
}

int main(int argc, char** argv) {
  const char* root = std::getenv("SPLINEVOX_DATA");
  const std::string path = argc > 1 && *argv[1] ? argv[1] : root ? std::string(root) + "/dnerf_trex" : "";
  const int threads = argc > 2 ? std::atoi(argv[2]) : 1;
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
  Dataset data = path.empty() ? make_synth("dancer", {.frames = 100, .size = 200})
                              : load_dataset(path, {.splits = {"train"}});

  Config config = solid_preset("fast");
  config.run.max_time = 0;
  config.run.max_steps = kSteps;
  const Prepared ready = prepare(config, data, {.effects = EffectPolicy::keep});
  Trainer trainer(ready.config, *data.find("train"), data.time_map);
  PhaseSeconds before{};
  std::int64_t samples = 0, rays = 0;
  while (!trainer.done()) {
    const StepReport report = trainer.step();
    if (report.step == kSteps - kMeasured) before = trainer.phases();
    if (report.step > kSteps - kMeasured) {
      samples += report.samples;
      rays += report.rays;
    }
  }
  const PhaseSeconds after = trainer.phases();
  const double ray_loop = after.rays + after.scatter - before.rays - before.scatter;
  const double outside =
      after.slices + after.regularise + after.update + after.occupancy + after.refine -
      (before.slices + before.regularise + before.update + before.occupancy + before.refine);
  const auto per_step = [&](double PhaseSeconds::*phase) {
    return (after.*phase - before.*phase) / kMeasured * 1e3;
  };
  const nlohmann::json line{{"bench", "training"},
                            {"data", path.empty() ? "built-in dancer" : path},
                            {"threads", threads},
                            {"samples_per_second", double(samples) / ray_loop},
                            {"samples_per_second_per_thread", double(samples) / ray_loop / threads},
                            {"rays_per_second", double(rays) / (ray_loop + outside)},
                            {"samples_per_ray", double(samples) / double(rays)},
                            {"share_outside_ray_loop", outside / (ray_loop + outside)},
                            {"milliseconds_per_step",
                             {{"rays", per_step(&PhaseSeconds::rays)},
                              {"scatter", per_step(&PhaseSeconds::scatter)},
                              {"slices", per_step(&PhaseSeconds::slices)},
                              {"regularise", per_step(&PhaseSeconds::regularise)},
                              {"update", per_step(&PhaseSeconds::update)},
                              {"occupancy", per_step(&PhaseSeconds::occupancy)}}}};
  fmt::print("{}\n", line.dump());
}
