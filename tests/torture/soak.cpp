// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <fstream>

#include "splinevox/data/synth.hpp"
#include "splinevox/train/trainer.hpp"
#include "torture/trial.hpp"

namespace splinevox::torture {
namespace {

constexpr std::int64_t kLongEnough = 20'000;  ///< steps after which buffers have met their largest batch

/// Memory in use, bytes.
double resident() {
  double all = 0, here = 0;
  std::ifstream("/proc/self/statm") >> all >> here;
  return here * double(::sysconf(_SC_PAGESIZE));
}

bool finite(const VoxelModel& model) {
  for (const float v : model.radiance.raw.values)
    if (!std::isfinite(v)) return false;
  for (const Channels& level : model.motion.levels)
    for (const float v : level.values)
      if (!std::isfinite(v)) return false;
  return true;
}

/// Small, with every term of the loss, and with batches of one size: what grows then should not.
Config small(std::int64_t steps) {
  Config c = preset("draft");
  c.run.max_time = 0;
  c.run.max_steps = int(steps);
  c.grid.radiance = {12, 20};
  c.grid.radiance_start = {0, 0.05f};
  c.grid.motion = {4, 8};
  c.grid.motion_start = {0.02f, 0.08f};
  c.radiance.sh_start = {0, 0.1f};
  c.motion.halve_start = {0.15f};
  c.loss.offset = 1e-3f;
  c.loss.divergence = 1e-3f;
  c.sampling.rays = 128;
  c.sampling.growth = 1;
  c.sampling.frames = 2;
  return c;
}

}  // namespace

Line try_soak(const Options& o, double seconds) {
  const Clock::time_point begin = Clock::now();
  const Dataset data = make_synth("ball", {.frames = 8, .size = 24, .seed = 3});
  double drift = 0, each = 0;  // of the memory; seconds per step of the second half
  std::uint64_t bad = 0;
  const auto run = [&](std::int64_t steps) {
    Trainer trainer(small(steps), *data.find("train"), data.time_map);
    double warm = 0;
    Clock::time_point half;
    std::int64_t done = 0;
    while (!trainer.done()) {
      const StepReport report = trainer.step();
      bad += report.discarded || !std::isfinite(report.loss);
      // Buffers reach their size with the largest batch seen, which takes a while after the last refinement.
      if (++done == steps / 2) {
        warm = resident();
        half = Clock::now();
      }
    }
    drift = resident() / warm - 1;
    each = since(half) / double(steps - steps / 2);
    bad += !finite(trainer.model());
    return done;
  };
  run(400);
  const bool all =
      o.seconds >= 3600;  // an hour's figures are quoted: whatever the machine, they are of as many steps
  const std::int64_t steps =
      all ? o.soak_steps
          : std::clamp<std::int64_t>(std::int64_t((seconds - since(begin)) / each), 200, o.soak_steps);
  Line line{"soak", "ball"};
  line.tried = std::uint64_t(run(steps));
  line.lost = bad + (drift > 0.01 && steps >= kLongEnough ? 1 : 0);
  line.seconds = since(begin);
  line.note = fmt::format("steps; {} not finite; memory {:+.2f}% over the second half", bad, 100 * drift);
  return line;
}

}  // namespace splinevox::torture
