// SPDX-License-Identifier: Apache-2.0
#include "splinevox/train/prepare.hpp"

#include <fmt/format.h>

#include "core/process.hpp"
#include "splinevox/core/error.hpp"
#include "train/effects/effect_table.hpp"
#include "train/start.hpp"

namespace splinevox {
namespace {

const Split& train_split(const Dataset& data) {
  const Split* train = data.find("train");
  if (!train || train->frames.empty())
    fail({data.path, "there is nothing to train on", "a split named train, if it was read", "", ""});
  return *train;
}

/// Whether the data's own box is what bounds the scene: nothing else does.
bool takes_box(const Config& config, const Dataset& data) {
  return !data.has_alpha && data.box && config.grid.box.empty();
}

EffectChoice kept(const Config& config) {
  EffectChoice out;
  out.chosen = effects_of(config);
  out.points = config.motion.points;
  return out;
}

}  // namespace

Prepared prepare(const Config& config, const Dataset& data, const PrepareOptions& options) {
  const Split& train = train_split(data);
  Prepared out;
  out.config = config;
  out.policy = options.effects;
  const auto tell = [&](const std::string& text) {
    if (options.on_note) options.on_note(text);
  };
  const auto note = [&](std::string text) {
    tell(text);
    out.notes.push_back(std::move(text));
  };
  if (takes_box(config, data)) {
    const Box& b = *data.box;
    out.config.grid.box = {b.lo.x, b.lo.y, b.lo.z, b.hi.x, b.hi.y, b.hi.z};
    note(
        fmt::format("opaque pictures: the box is the data's own, {:.4g} x {:.4g} x {:.4g} (--set "
                    "grid.box=... for another)",
                    b.extent().x, b.extent().y, b.extent().z));
  }
  out.brightness = brightness(out.config, picture_stats(train));
  if (out.brightness < 1)
    note(fmt::format("dark pictures: colours are trained in units of {:.3g}", out.brightness));
  if (options.effects == EffectPolicy::keep) {
    out.effects = kept(out.config);
  } else {
    if (config.effects.steps > 0) tell("trying out which effects the scene calls for");
    out.effects = choose_effects(out.config, train, data.time_map, options.on_trial);
    release_freed_memory();  // of the fits
  }
  if (options.effects == EffectPolicy::choose) {
    apply(out.effects.chosen, out.config);
    out.config.motion.points = out.effects.points;
  }
  out.used = learnable_in(effects_of(out.config), !data.has_alpha);
  return out;
}

}  // namespace splinevox
