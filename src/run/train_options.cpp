// SPDX-License-Identifier: Apache-2.0
#include "run/train_options.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "run/support.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/run/train.hpp"
#include "train/effects/effect_table.hpp"

namespace splinevox::run {
namespace {

/// --effects: `auto` leaves those of the preset to choose from; `all` is every effect in full, which for view
/// dependence is the highest order; of a list, what is not named is off.
/// @return what was listed by name
EffectSet apply_effects(Config& c, const std::string& text) {
  if (text == "auto") return {};
  const bool all = text == "all";
  const std::vector<std::string> words = all              ? effect_names()
                                         : text == "none" ? std::vector<std::string>()
                                                          : split_list(text);
  if (words.empty() && text != "none")
    fail({"--effects", "no effect is listed",
          fmt::format("auto, all, none, or a list of {}", fmt::join(effect_names(), ", ")), "'" + text + "'",
          ""});
  EffectSet asked;
  for (const std::string& name : words) {
    const std::optional<Effect> effect = effect_named(name);
    if (!effect)
      fail({"--effects", fmt::format("there is no effect '{}'", name),
            fmt::format("auto, all, or a list of {}", fmt::join(effect_names(), ", ")), text, ""});
    const EffectFacts& facts = facts_of(*effect);
    asked = asked.with(*effect, std::max(facts.order_in(c), all ? facts.full : facts.least));
  }
  for (const Effect effect : kAllEffects)
    if (const EffectFacts& facts = facts_of(effect);
        asked.has(effect) && facts.needs && !asked.has(*facts.needs))
      fail({"--effects", facts.why_needs, fmt::format("{},{}", to_string(*facts.needs), facts.name), text,
            ""});
  apply(asked, c);
  return all ? EffectSet() : asked;
}

/// Settings can rule an effect out: presence has no place where every curve begins at zero.
void require_listed(const EffectSet& listed, const Config& c, const std::string& text) {
  for (const Effect effect : kAllEffects)
    if (listed.has(effect) && facts_of(effect).order_in(c) < 0)
      fail({"--effects", fmt::format("other settings rule {} out", to_string(effect)),
            effect == Effect::presence ? "curves whose first point is free" : "settings that leave it on",
            text, effect == Effect::presence ? "--set motion.first_point=free, or another preset" : ""});
}

}  // namespace

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
  const EffectSet listed = apply_effects(c, o.effects);
  for (const std::string& s : o.sets) set_config(c, s, "--set " + s);
  require_listed(listed, c, o.effects);
  const auto set = [&](const char* flag, const char* key, const auto& value) {
    if (value) set_config(c, fmt::format("{}={}", key, *value), flag);
  };
  set("--max-time", "run.max_time", o.max_time);
  set("--max-steps", "run.max_steps", o.max_steps);
  // Steps alone are no race against a clock that nobody asked for.
  if (o.max_steps && !o.max_time && c.run.max_time == preset(c.preset).run.max_time) c.run.max_time = 0;
  set("--seed", "run.seed", o.seed);
  set("--downscale", "run.downscale", o.downscale);
  if (o.background) {
    c.run.background = parse_background(*o.background);
    c.run.background_order = -1;
    if (c.sampling.background == BackgroundKind::random) c.sampling.background = BackgroundKind::ground;
  }
  validate(c);
  return c;
}

}  // namespace splinevox::run
