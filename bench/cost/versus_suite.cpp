// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "core/process.hpp"
#include "present.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/train/prepare.hpp"
#include "suites.hpp"
#include "timing.hpp"
#include "trained.hpp"

namespace splinevox::cost {
namespace {

namespace fs = std::filesystem;

/// What one run or several of one setting came to.
Record point(const std::string& scene, const std::string& system, const std::vector<double>& seconds,
             const std::vector<double>& db) {
  std::vector<double> error;
  for (const double v : db) error.push_back(std::pow(10, -v / 20));
  Record r;
  r.suite = "versus";
  r.scene = scene;
  r.knob = system;
  r.seconds = median_of(seconds);
  r.order = r.seconds.value;
  r.runs = int(db.size());
  r.error = median_of(error);
  r.quality = -20 * std::log10(r.error.value);
  return r;
}

/// Short runs are what `draft` is for, long ones what `standard` is.
const char* preset_for(int steps) { return steps <= 400 ? "draft" : steps <= 6400 ? "fast" : "standard"; }

Record voxels(const std::string& path, const Dataset& tests, const std::string& scene, int steps, int seeds,
              int stride) {
  std::vector<double> seconds, db;
  double samples = 0;
  const double before = peak_memory();
  for (int seed = 1; seed <= seeds; ++seed) {
    const double start = processor_seconds();
    Dataset data = load_dataset(path, {.splits = {"train"}});
    Config config = preset(preset_for(steps));
    config.run.max_time = 0;
    config.run.max_steps = steps;
    config.run.seed = std::uint64_t(seed);
    const Trained run = train_to_end(prepare(config, data).config, data);
    seconds.push_back(processor_seconds() - start);
    db.push_back(mean_psnr(run.model, *tests.find("test"), stride));
    samples += run.samples_per_ray / seeds;
  }
  Record r = point(scene, "voxels", seconds, db);
  r.value = fmt::format("{}, {} steps", preset_for(steps), steps);
  r.samples = samples;
  // A process' peak never falls: what an earlier run had more of hides what these took.
  r.memory = peak_memory() > before ? peak_memory() : 0;
  return r;
}

/// What a picture of nothing but the background would have: where a method has hardly begun, its PSNR says as
/// little.
Record nothing(const Dataset& tests, const std::string& scene, int stride) {
  const Vec3 white{1, 1, 1};
  double db = 0;
  const auto& frames = tests.find("test")->frames;
  for (const Frame& f : frames) {
    const Image truth = strided(composite(f.image, white), stride);
    Image empty = truth;
    std::fill(empty.data.begin(), empty.data.end(), 1.0f);
    db += capped_psnr(psnr(empty, truth)) / double(frames.size());
  }
  Record r = point(scene, kBackgroundAlone, {0}, {db});
  r.value = "white";
  return r;
}

/// Finished runs of splinevox-mlp on one scene, and every how many pixels of the test views they were
/// measured at.
struct Perceptrons {
  std::vector<Record> points;
  int stride = 1;
};

Perceptrons perceptrons(const std::string& run) {
  std::ifstream metrics(run + "/metrics.json"), config(run + "/config.toml");
  const Json figures = Json::parse(metrics, nullptr, false);
  std::string scene, line;
  while (std::getline(config, line)) {
    if (line.rfind("dataset = \"", 0) == 0)
      scene = fs::path(line.substr(11, line.size() - 12)).filename().string();
    // The voxels' pictures are whole and on white.
    for (const auto& [key, wanted] :
         {std::pair{"background = ", "[1, 1, 1]"}, std::pair{"downscale = ", "1"}})
      if (line.rfind(key, 0) == 0 && line.substr(std::strlen(key)) != wanted)
        fail({run, "has other pictures than the voxels it stands beside", std::string(key) + wanted, line,
              "splinevox-mlp train --background white, without --downscale"});
  }
  if (!figures.is_object() || !figures.value("cpu_time", false) || !figures.contains("tests") ||
      scene.empty())
    fail({run, "this is no finished run of splinevox-mlp in processor time",
          "metrics.json with 'tests' and 'cpu_time', and config.toml", "",
          "train it with --cpu-time and --test-at"});
  std::vector<Record> out;
  const int stride = figures.at("test_stride");
  for (const Json& t : figures["tests"]) {
    Record r = point(scene, fmt::format("MLP {}", figures.at("kind").get<std::string>()),
                     {double(t.at("seconds")) * double(figures.at("threads"))}, {t.at("psnr")});
    r.where = fmt::format("splinevox-mlp on {}, {} threads, a run of its own", figures.value("device", "cpu"),
                          figures.at("threads").get<int>());
    r.value = fmt::format("{} steps", t.at("step").get<std::int64_t>());
    r.memory = figures.at("peak_memory_bytes");
    out.push_back(r);
  }
  return {out, stride};
}

}  // namespace

void versus_suite(const SuiteOptions& o, const std::vector<std::string>& runs, const OnRecord& on_record) {
  std::vector<Record> others;
  int stride = runs.empty() ? 1 : perceptrons(runs.front()).stride;
  for (const std::string& run : runs) {
    const Perceptrons p = perceptrons(run);
    if (p.stride != stride)
      fail({run, "was measured at other pixels than the runs before it", fmt::format("--stride {}", stride),
            fmt::format("{}", p.stride), "splinevox-mlp train with one --stride for all"});
    others.insert(others.end(), p.points.begin(), p.points.end());
  }
  if (o.scenes.empty())
    fail({"--suite versus", "there is no scene", "data sets that have been trained by both", "", ""});
  for (const std::string& path : o.scenes) {
    const std::string scene = fs::path(path).filename().string();
    const Dataset tests = load_dataset(path, {.splits = {"test"}});
    const auto tell = [&](Record r) {
      r.note = stride > 1 ? fmt::format("every {}th pixel and row of the test views", stride) : "";
      on_record(r);
    };
    tell(nothing(tests, scene, stride));
    for (const int steps : o.versus_steps) tell(voxels(path, tests, scene, steps, o.seeds, stride));
    for (const Record& r : others)
      if (r.scene == scene) tell(r);
  }
}

}  // namespace splinevox::cost
