// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>

#include "solid_preset.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/data/synth.hpp"
#include "suites.hpp"
#include "timing.hpp"
#include "trained.hpp"

namespace splinevox::cost {
namespace {

struct Setting {
  std::string knob, value;
  double order;
  std::vector<std::string> changes;  ///< group.key=value
  double steps = 1;                  ///< times the suite's
  bool dominated = false;
  const char* preset = "fast";
  bool halves =
      true;  ///< the preset's halvings of spans, which make more control points in the course of a run
};

std::vector<Setting> settings(bool micro) {
  std::vector<Setting> out{{"default", "preset fast", 0, {}}};
  out.push_back({"steps", "a quarter", -2, {}, 0.25});
  out.push_back({"steps", "half", -1, {}, 0.5});
  // It has to come out behind: the check that the diagram can tell.
  out.push_back({"deliberately worse",
                 "short steps, heavy total variation",
                 0,
                 {"sampling.step=0.25", "loss.tv_density=0.01", "loss.tv_final=1"},
                 1,
                 true});
  if (micro) return out;
  out.push_back({"preset", "draft", -1, {}, 1, false, "draft"});
  out.push_back({"preset", "standard", 1, {}, 1, false, "standard"});
  out.push_back({"preset", "high", 2, {}, 1, false, "high"});
  out.push_back({"step of the march", "a quarter voxel", 2, {"sampling.step=0.25"}});
  out.push_back({"steps", "double", 1, {}, 2});
  out.push_back({"step of the march", "1.5 voxels", -1, {"sampling.step=1.5"}});
  out.push_back({"radiance cells", "64", -4, {"grid.radiance=40,64", "grid.radiance_start=0,.25"}});
  out.push_back({"radiance cells", "96", -3, {"grid.radiance=40,64,96", "grid.radiance_start=0,.12,.25"}});
  out.push_back(
      {"radiance cells", "144", -2, {"grid.radiance=40,64,96,144", "grid.radiance_start=0,.12,.25,.4"}});
  out.push_back({"radiance cells",
                 "192",
                 -1,
                 {"grid.radiance=40,64,96,144,192", "grid.radiance_start=0,.12,.25,.4,.6"}});
  out.push_back({"motion cells", "8", -2, {"grid.motion=4,8", "grid.motion_start=0,.08"}});
  out.push_back({"motion cells", "16", -1, {"grid.motion=4,8,16", "grid.motion_start=0,.08,.25"}});
  out.push_back({"motion cells", "64", 1, {"grid.motion=4,8,16,32,64", "grid.motion_start=0,.08,.25,.5,.7"}});
  for (const int k : {4, 7, 12, 21})
    out.push_back({"control points",
                   fmt::format("{} from the start", k),
                   double(k - 21),
                   {fmt::format("motion.points={}", k)},
                   1,
                   false,
                   "fast",
                   false});
  for (const int k : {7, 21})
    out.push_back({"control points",
                   fmt::format("{}, in the end {}", k, 2 * k - 3),
                   double(2 * k - 24),
                   {fmt::format("motion.points={}", k)}});
  out.push_back({"basis",
                 "Bezier of 5 points",
                 -1,
                 {"motion.basis=bezier", "motion.points=5"},
                 1,
                 false,
                 "fast",
                 false});
  for (const int order : {-1, 0, 1, 3})
    out.push_back({"harmonics",
                   fmt::format("order {}", order),
                   double(order - 2),
                   {fmt::format("radiance.sh_order={}", order)}});
  out.push_back({"rays a step", "2048", -1, {"sampling.rays=2048"}});
  out.push_back({"rays a step", "8192", 1, {"sampling.rays=8192"}});
  out.push_back({"frames a step", "4", -1, {"sampling.frames=4"}});
  out.push_back({"light", "off", -1, {"motion.light=false"}});
  out.push_back({"rigidity", "off", -1, {"motion.rigidity=false"}});
  out.push_back({"total variation", "does not fade", 1, {"loss.tv_final=1"}});
  return out;
}

struct Outcome {
  double rms, seconds, samples;
};

Config config_of(const SuiteOptions& o, const Setting& s, int seed) {
  Config config = solid_preset(s.preset);
  if (!s.halves) config.motion.halve_start.clear();
  if (o.micro) {
    config.grid.radiance = {24, 40};
    config.grid.radiance_start = {0, .3f};
    config.grid.motion = {4, 8};
    config.grid.motion_start = {0, .2f};
    config.sampling.rays = 1024;
  }
  for (const std::string& change : s.changes) set_config(config, change, "cost");
  config.run.max_time = 0;
  config.run.max_steps = std::max(1, int(o.steps * s.steps));
  config.run.seed = std::uint64_t(seed);
  return config;
}

Outcome train(Dataset& data, const Config& config) {
  const Trained run = train_to_end(config, data);
  return {std::pow(10, -mean_psnr(run.model, *data.find("test")) / 20), run.seconds, run.samples_per_ray};
}

/// Finished runs, a line each, by what they were trained on and with, where and by which program: a suite of
/// hours that was stopped goes on where it was. Programs of no known commit, or of one with changes, leave no
/// line: who could tell them apart?
class Finished {
 public:
  Finished(const std::string& path, const std::string& where) : path_(path), where_(where) {
    lasting_ = where.find("unknown commit") == std::string::npos && where.find("-dirty") == std::string::npos;
    std::ifstream in(path);
    for (std::string line; lasting_ && std::getline(in, line);)
      if (const Json j = Json::parse(line, nullptr, false); j.is_object())
        known_[j.at("key")] = {j.at("rms"), j.at("seconds"), j.at("samples")};
  }
  Outcome run(Dataset& data, const std::string& scene, const Config& config) {
    const std::string key = where_ + "\n" + scene + "\n" + write_config(config);
    if (const auto it = known_.find(key); it != known_.end()) return it->second;
    const Outcome x = train(data, config);
    if (!lasting_) return x;
    std::ofstream out(path_, std::ios::app);
    if (!(out << Json{{"key", key}, {"rms", x.rms}, {"seconds", x.seconds}, {"samples", x.samples}}.dump()
              << "\n"
              << std::flush))
      fail_output({path_, "this file could not be written", "", "a full disk?", ""});
    return known_[key] = x;
  }

 private:
  std::string path_, where_;
  bool lasting_;
  std::map<std::string, Outcome> known_;
};

double decibels(double rms) { return -20 * std::log10(rms); }

}  // namespace

void train_suite(const SuiteOptions& o, const std::string& runs, const OnRecord& on_record) {
  Finished finished(runs, o.where);
  for (const std::string& scene : o.scenes.empty() ? std::vector<std::string>{""} : o.scenes) {
    Dataset data = scene.empty() ? make_synth("dancer", {.frames = 40, .size = o.micro ? 48 : 200})
                                 : load_dataset(scene, {.splits = {"train", "test"}});
    std::vector<Setting> list = settings(o.micro);
    if (!o.knobs.empty())
      std::erase_if(list, [&](const Setting& s) {
        return s.knob != "default" && std::find(o.knobs.begin(), o.knobs.end(), s.knob) == o.knobs.end();
      });
    list.push_back({"A/A", "the default with other seeds", 0, {}});
    std::vector<std::vector<Outcome>> outcomes(list.size());
    std::vector<std::string> failures(list.size());
    for (int seed = 1; seed <= o.seeds; ++seed)
      for (std::size_t i = 0; i < list.size(); ++i) try {
          outcomes[i].push_back(
              finished.run(data, scene, config_of(o, list[i], list[i].knob == "A/A" ? 1000 + seed : seed)));
        } catch (const Error& error) {  // a setting that cannot be trained is a result too
          failures[i] = fmt::format("seed {}: {}", seed, error.what());
        }
    for (std::size_t i = 0; i < list.size(); ++i) {
      std::vector<double> error, seconds;
      Record r;
      for (const Outcome& x : outcomes[i]) {
        error.push_back(x.rms);
        seconds.push_back(x.seconds);
        r.samples += x.samples / double(outcomes[i].size());
      }
      r.suite = "train";
      r.scene = scene.empty() ? "dancer" : std::filesystem::path(scene).filename().string();
      r.knob = list[i].knob;
      r.value = list[i].value;
      r.order = list[i].order;
      r.runs = int(error.size());
      r.note = failures[i];
      if (!error.empty()) {
        r.error = median_of(error);
        r.seconds = median_of(seconds);
        r.quality = decibels(r.error.value);
      }
      r.failed = !failures[i].empty() || !std::isfinite(r.error.value);
      r.is_default = r.knob == "default";
      r.expected_dominated = list[i].dominated;
      on_record(r);
    }
  }
}

}  // namespace splinevox::cost
