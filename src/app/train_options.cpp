// SPDX-License-Identifier: Apache-2.0
#include "app/train_options.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "app/support.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/math/sh.hpp"
#include "splinevox/train/effects.hpp"

namespace splinevox::app {
namespace {

/// Means over the six D-NeRF scenes at 400x400 that docs/benchmarks.md lists, on two cores.
struct Measured {
  const char* preset;
  double psnr, memory;  ///< dB on the test split; peak, GB
};
constexpr Measured kMeasured[] = {
#include "app/preset_figures.inc"  // written by bench/quality.sh
};

std::string preset_help() {
  std::string text = "where the numbers start from:";
  for (const Preset& p : presets()) {
    text += fmt::format("\n  {:<11} {}", p.name, p.summary);
    for (const Measured& m : kMeasured)
      if (m.preset == std::string(p.name)) text += fmt::format("; measured {:.2f} dB, {:.2f} GB", m.psnr, m.memory);
  }
  return text;
}

std::string preset_names() {
  std::vector<std::string> names;
  for (const Preset& p : presets()) names.push_back(p.name);
  return fmt::format("{{{}}}", fmt::join(names, ","));
}

/// --effects: `auto` leaves those of the preset to choose from; `all` is every effect in full, which for view dependence is the highest order; of a list, what is
/// not named is off.
void apply_effects(Config& c, const std::string& text) {
  if (text == "auto") return;
  const std::vector<std::string>& known = effect_names();
  const std::vector<std::string> names = text == "all" ? known : split_list(text);
  for (const std::string& n : names)
    if (std::find(known.begin(), known.end(), n) == known.end())
      fail({"--effects", fmt::format("there is no effect '{}'", n), fmt::format("auto, all, or a list of {}", fmt::join(known, ", ")), text, ""});
  const auto on = [&](const char* name) { return std::find(names.begin(), names.end(), name) != names.end(); };
  if (on("rigidity") && !on("motion"))
    fail({"--effects", "rigidity scales motion, so it needs motion", "motion,rigidity", text, ""});
  c.motion.enabled = on("motion");
  c.motion.rigidity = on("rigidity");
  c.motion.light = on("light");
  c.radiance.sh_order = text == "all" ? kMaxShOrder : on("view") ? std::max(c.radiance.sh_order, 1) : -1;
  c.run.background_order = on("background") ? std::max(c.run.background_order, 0) : -1;
}

}  // namespace

void add_train_options(CLI::App& verb, TrainOptions& o) {
  verb.add_option("DATASET", o.dataset, "folder of a data set: D-NeRF, nerfstudio, COLMAP and others (docs/data.md)");
  verb.add_option("--out", o.out, "folder of the run (config.toml, model.vdb, checkpoint, metrics, preview)");
  verb.add_option("--preset", o.preset, preset_help())->type_name(preset_names());
  verb.add_option("--config", o.config_file, "TOML file over the preset");
  verb.add_option("--set", o.sets, "one number over both, group.key=value; may be repeated")->allow_extra_args(false);
  verb.add_option("--max-time", o.max_time,
                  "seconds training may take, loading included; schedules are laid out over it");
  verb.add_option("--max-steps", o.max_steps, "optimiser steps; alone, the same seed gives the same bits");
  add_threads(verb, o.threads);
  verb.add_option("--seed", o.seed, "seed of every random draw");
  add_device(verb, o.device);
  verb.add_flag("--deterministic", o.deterministic, "on a CUDA device too: the same bits in every run, for some of its speed (the CPU always has them)");
  verb.add_option("--downscale", o.downscale, "average KxK pixel blocks of the pictures");
  verb.add_option("--background", o.background, "white, black or R,G,B in 0..1, behind pictures with alpha, and behind opaque ones instead of a learned colour");
  verb.add_option("--effects", o.effects, "auto (those the scene calls for, tried out first), all (each in full: view dependence of order 3), or a list of motion,rigidity,view,light,background")
      ->capture_default_str();
  verb.add_flag("--resume", o.resume, "go on with the run in --out, or start it if there is no checkpoint");
  verb.add_flag("--quiet", o.quiet, "say nothing but errors");
  verb.add_flag("--json", o.json, "progress as JSON lines on stdout");
  verb.add_flag("--list-settings", o.list_settings, "print every setting of the preset as TOML and stop");
}

std::vector<float> parse_background(const std::string& text) {
  if (text == "white") return {1, 1, 1};
  if (text == "black") return {0, 0, 0};
  const char* expected = "white, black or three numbers R,G,B in 0..1";
  const std::vector<double> v = numbers(text, ',', "--background", expected);
  if (v.size() != 3 || *std::min_element(v.begin(), v.end()) < 0 || *std::max_element(v.begin(), v.end()) > 1)
    fail({"--background", "this is not a colour", expected, text, ""});
  return {float(v[0]), float(v[1]), float(v[2])};
}

Config effective_config(const TrainOptions& o, const Config* resumed) {
  const std::string name = o.preset.value_or(resumed ? resumed->preset : "fast");
  Config c = preset(name);
  if (resumed) {
    if (resumed->preset != name)
      fail({"--preset", "the run in --out was made with another preset", resumed->preset, name,
            "leave --preset out, or another folder for --out"});
    c = *resumed;
  }
  if (!o.config_file.empty()) {
    read_config(c, o.config_file);
    if (o.preset && c.preset != *o.preset)
      fail({o.config_file, "this file and --preset name different presets", *o.preset, c.preset,
            "leave one of them out"});
  }
  apply_effects(c, o.effects);
  for (const std::string& s : o.sets) set_config(c, s, "--set " + s);
  const auto set = [&](const char* flag, const char* key, const auto& value) {
    if (value) set_config(c, fmt::format("{}={}", key, *value), flag);
  };
  set("--max-time", "run.max_time", o.max_time);
  set("--max-steps", "run.max_steps", o.max_steps);
  if (o.max_steps && !o.max_time) c.run.max_time = 0;
  set("--seed", "run.seed", o.seed);
  set("--downscale", "run.downscale", o.downscale);
  if (o.background) c.run.background = parse_background(*o.background), c.run.background_order = -1;
  validate(c);
  return c;
}

}  // namespace splinevox::app
