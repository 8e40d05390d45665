// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "splinevox/core/error.hpp"
#include "splinevox/core/process.hpp"
#include "splinevox/train/effects.hpp"
#include "suites.hpp"
#include "trained.hpp"

namespace splinevox::cost {
namespace {

namespace fs = std::filesystem;

Figure exactly(double v) { return {v, v, v}; }

Record point(const std::string& scene, const std::string& system, double seconds, double db) {
  Record r;
  r.suite = "versus", r.scene = scene, r.knob = system, r.order = seconds, r.seconds = exactly(seconds), r.runs = 1;
  r.quality = db, r.error = exactly(std::pow(10, -db / 20));
  return r;
}

/// Short runs are what `draft` is for.
const char* preset_for(int steps) { return steps <= 400 ? "draft" : "fast"; }

Record voxels(const std::string& path, const Dataset& tests, const std::string& scene, int steps) {
  const double start = processor_seconds();
  const Dataset data = load_dataset(path, {.splits = {"train"}});
  Config config = preset(preset_for(steps));
  config.run.max_time = 0, config.run.max_steps = steps;
  const EffectChoice choice = choose_effects(config, *data.find("train"), data.time_map);
  apply(choice.chosen, config), config.motion.points = choice.points;
  const Trained run = train_to_end(config, data);
  const double seconds = processor_seconds() - start;
  Record r = point(scene, "voxels", seconds, mean_psnr(run.model, *tests.find("test")));
  r.value = fmt::format("{}, {} steps", config.preset, steps), r.samples = run.samples_per_ray, r.memory = peak_memory(), r.is_default = steps >= 5000;
  return r;
}

std::vector<Record> perceptrons(const std::string& run) {
  std::ifstream metrics(run + "/metrics.json"), config(run + "/config.toml");
  const Json figures = Json::parse(metrics, nullptr, false);
  std::string scene, line;
  while (std::getline(config, line))
    if (line.rfind("dataset = \"", 0) == 0) scene = fs::path(line.substr(11, line.size() - 12)).filename().string();
  if (!figures.is_object() || !figures.value("cpu_time", false) || !figures.contains("tests") || scene.empty())
    fail({run, "this is no finished run of splinevox-mlp in processor time", "metrics.json with 'tests' and 'cpu_time', and config.toml", "", "train it with --cpu-time and --test-at"});
  std::vector<Record> out;
  for (const Json& t : figures["tests"]) {
    Record r = point(scene, fmt::format("MLP {}", figures.at("kind").get<std::string>()), double(t.at("seconds")) * double(figures.at("threads")), t.at("psnr"));
    r.value = fmt::format("{} steps", t.at("step").get<std::int64_t>()), r.memory = figures.at("peak_memory_bytes");
    r.note = fmt::format("every {}th pixel and row of the test views", figures.at("test_stride").get<int>());
    out.push_back(r);
  }
  return out;
}

}  // namespace

void versus_suite(const SuiteOptions& o, const std::vector<std::string>& runs, const Told& told) {
  std::vector<Record> others;
  for (const std::string& run : runs)
    for (const Record& r : perceptrons(run)) others.push_back(r);
  for (const std::string& path : o.scenes) {
    const std::string scene = fs::path(path).filename().string();
    const Dataset tests = load_dataset(path, {.splits = {"test"}});
    for (const int steps : o.versus_steps) told(voxels(path, tests, scene, steps));
    for (const Record& r : others)
      if (r.scene == scene) told(r);
  }
}

}  // namespace splinevox::cost
