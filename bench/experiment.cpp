// SPDX-License-Identifier: Apache-2.0
// One row of docs/experiments.md: trains scenes with a preset and some changes, and prints PSNR on a held-out
// split.
//
//   bench_experiment SCENE... [--preset fast] [--set group.key=value]... [--steps 1000] [--seeds 1] [--split
//   val] [--threads 2]
//                    [--pictures FOLDER]
//
// Runs are cut by steps (--steps 0: by the preset's time), so that a row does not depend on what else the
// machine does. One JSON line per run.
#include <fmt/core.h>
#include <tbb/global_control.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "solid_preset.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/data/image_io.hpp"
#include "splinevox/data/scene.hpp"
#include "splinevox/math/metrics.hpp"
#include "splinevox/render/render_image.hpp"
#include "trained.hpp"

using namespace splinevox;

namespace {

struct Options {
  std::vector<std::string> scenes, changes;
  std::string preset = "fast", split = "val", pictures;
  int steps = 1000, seeds = 1, threads = 2;
};

struct Score {
  double mean = 0, worst = 1e9;  ///< dB
};

/// Scores every n-th view of a split; writes the renders where `pictures` (a prefix) is not empty.
Score score(const VoxelModel& model, const Split& split, std::size_t every, const std::string& pictures) {
  Score out;
  Renderer renderer(model);
  int count = 0;
  for (std::size_t f = 0; f < split.frames.size(); f += every, ++count) {
    const Frame& frame = split.frames[f];
    const Image render = clamped(renderer.render(frame.camera, frame.time).rgb);
    const double db = psnr(render, composite(frame.image, model.background.color));
    out.mean += db;
    out.worst = std::min(out.worst, db);
    if (!pictures.empty()) write_png(fmt::format("{}_{:03}.png", pictures, f), render);
  }
  out.mean /= count;
  return out;
}

void run(const Options& options, const Config& base, const std::string& scene, int seed) {
  Dataset data = load_dataset(scene, {.downscale = base.run.downscale, .splits = {"train", options.split}});
  const std::string name = std::filesystem::path(scene).filename().string();
  Config config = base;
  config.run.seed = std::uint64_t(seed);
  if (options.steps > 0) {
    config.run.max_time = 0;
    config.run.max_steps = options.steps;
  }
  const Trained run = train_to_end(config, data);
  const Score held_out = score(run.model, *data.find(options.split), 1,
                               options.pictures.empty() ? "" : options.pictures + "/" + name);
  const Split& train = *data.find("train");
  const Score trained = score(run.model, train, std::max<std::size_t>(1, train.frames.size() / 20), "");
  const PhaseSeconds& s = run.phases;
  const nlohmann::json line{
      {"scene", name},
      {"seed", seed},
      {"set", options.changes},
      {"psnr", held_out.mean},
      {"worst", held_out.worst},
      {"train_psnr", trained.mean},
      {"samples_per_ray", run.samples_per_ray},
      {"seconds", run.seconds},
      {"phases", fmt::format("slices {:.1f} rays {:.1f} scatter {:.1f} regularise {:.1f} update {:.1f} "
                             "occupancy {:.1f} refine {:.1f}",
                             s.slices, s.rays, s.scatter, s.regularise, s.update, s.occupancy, s.refine)}};
  fmt::print("{}\n", line.dump());
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app("one row of docs/experiments.md");
  app.add_option("scenes", options.scenes)->required();
  app.add_option("--preset", options.preset);
  app.add_option("--set", options.changes);
  app.add_option("--steps", options.steps);
  app.add_option("--seeds", options.seeds);
  app.add_option("--split", options.split);
  app.add_option("--threads", options.threads);
  app.add_option("--pictures", options.pictures);
  CLI11_PARSE(app, argc, argv);
  try {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, options.threads);
    Config config = solid_preset(options.preset);
    for (const std::string& change : options.changes) set_config(config, change, "--set");
    if (!options.pictures.empty()) std::filesystem::create_directories(options.pictures);
    for (int seed = 1; seed <= options.seeds; ++seed)
      for (const std::string& scene : options.scenes) run(options, config, scene, seed);
  } catch (const Error& e) {
    fmt::print(stderr, "{}\n", e.what());
    return 1;
  }
}
