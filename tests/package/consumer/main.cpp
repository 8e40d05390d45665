// SPDX-License-Identifier: Apache-2.0
// consumer DIR : what a program does with the library, through its public headers alone: trains by hand and
// into a run folder, stops and goes on, opens the run, evaluates, renders, exports. 0: everything is as it
// should be.
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "splinevox/core/error.hpp"
#include "splinevox/core/version.hpp"
#include "splinevox/data/image_io.hpp"
#include "splinevox/data/synth.hpp"
#include "splinevox/field/sample.hpp"
#include "splinevox/io/export_vdb.hpp"
#include "splinevox/io/inspect.hpp"
#include "splinevox/run/cameras.hpp"
#include "splinevox/run/evaluate.hpp"
#include "splinevox/run/run.hpp"
#include "splinevox/run/train.hpp"
#include "splinevox/train/prepare.hpp"

#ifdef __AVX__
#error "this is compiled for any processor, whatever the library was compiled for"
#endif

using namespace splinevox;

namespace {

constexpr int kSteps = 40;
int failed = 0;

void check(bool good, const char* what) {
  if (!good) {
    std::printf("failed: %s\n", what);
    ++failed;
  }
}

/// The same model from a trainer: the data's box and the effects as `train` settles them.
VoxelModel trained_by_hand(const run::TrainOptions& options) {
  LoadOptions load;
  load.splits = {"train"};
  Dataset data = load_dataset(options.dataset, load);
  PrepareOptions how;
  how.effects = EffectPolicy::keep;
  const Prepared ready = prepare(run::effective_config(options), data, how);
  check(ready.used.has(Effect::motion) && ready.brightness == 1, "effects are kept");
  Trainer trainer(ready.config, *data.find("train"), data.time_map);
  while (!trainer.done()) trainer.step();
  return trainer.model();
}

/// Trains into a folder, stopped once on the way.
void train_into(run::TrainOptions options) {
  std::vector<std::string> notes;
  int steps = 0;
  run::TrainEvents events;
  events.note = [&](const std::string& text) { notes.push_back(text); };
  events.step = [&](const StepReport& report) {
    ++steps;
    return report.step < kSteps / 2;
  };
  const run::TrainEnd half = run::train(options, events);
  check(!half.finished && half.steps == kSteps / 2 && steps == kSteps / 2, "a run stops when it is told to");
  check(!notes.empty(), "a run says what it does");
  options.resume = true;
  const run::TrainEnd whole = run::train(options);
  check(whole.finished && whole.steps == kSteps, "a run goes on where it was");
  check(whole.figures.find("\"finished\": true") != std::string::npos, "figures are those of metrics.json");
}

void use(const std::string& folder, const std::string& path, const VoxelModel& by_hand) {
  const run::Run run = run::open_run(path);
  check(run.config.run.max_steps == kSteps && run.model.motion.moves(), "a run knows how it was made");
  for (const FileCheck& file : verify(path)) check(file.ok, file.file.c_str());

  const Dataset data = run::open_split(run, "", "test");
  Renderer renderer(run.model), other(by_hand);
  const run::Scores scores = run::evaluate(run.model, renderer, *data.find("test"));
  const run::Scores same = run::evaluate(by_hand, other, *data.find("test"));
  check(scores.views.size() == data.find("test")->frames.size() && scores.psnr > 12,
        "it looks like the ball");
  check(scores.psnr == same.psnr, "a run and a trainer make the same model");
  std::printf("splinevox %s: a ball after %d steps, %.2f dB\n", kVersion, kSteps, scores.psnr);

  run::CameraRequest orbit;
  orbit.times = "0:1:2";
  orbit.size = 24;
  const std::vector<run::Shot> shots = run::plan_shots(run, orbit);
  check(shots.size() == 2, "two pictures are planned");
  for (const run::Shot& shot : shots)
    write_png(folder + "/shot.png", renderer.render(shot.camera, shot.time).rgb);
  check(FrameSampler(run.model, 0.5).warp(run.model.box.center()).rigidity > 0, "motion can be sampled");

  ExportOptions options;
  options.last = 2;
  const ExportResult result = export_vdb(run.model, folder + "/vdb", options);
  check(result.finished && result.frames.size() == 2, "an export ends");
  check(!inspect_vdb(folder + "/vdb/" + result.frames[0].file.name).grids.empty(), "its frames have grids");
}

}  // namespace

int main(int count, char** words) {
  static_assert(SPLINEVOX_VERSION_NUMBER >= 100, "the first version with this header is 0.1.0");
  const std::string folder = count > 1 ? words[1] : ".";
  try {
    run::TrainOptions options;
    options.dataset = folder + "/ball";
    options.out = folder + "/ball_run";
    options.preset = "draft";
    options.effects = "all";
    options.sets = {"grid.radiance=16", "grid.radiance_start=0", "effects.steps=0", "radiance.sh_order=1"};
    options.max_steps = kSteps;
    SynthOptions scene;
    scene.frames = 8;
    scene.size = 32;
    write_synth("ball", options.dataset, scene);
    train_into(options);
    use(folder, options.out, trained_by_hand(options));
    run::open_run(folder + "/none");
    check(false, "there is no such run");
  } catch (const Error& error) {
    if (error.fault != Fault::input || error.problem.where != folder + "/none") {
      std::printf("failed: %s\n", error.what());
      return 1;
    }
  }
  return failed ? 1 : 0;
}
