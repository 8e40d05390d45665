// SPDX-License-Identifier: Apache-2.0
#include "splinevox/train/effects.hpp"

#include <algorithm>

namespace splinevox {

const std::vector<std::string>& effect_names() {
  static const std::vector<std::string> names{"motion", "rigidity", "view", "light", "background"};
  return names;
}

bool EffectSet::has(const std::string& effect) const {
  return effect == "motion"     ? motion
         : effect == "rigidity" ? rigidity
         : effect == "view"     ? view >= 0
         : effect == "light"    ? light
                                : background >= 0;
}

EffectSet EffectSet::without(const std::string& effect) const {
  EffectSet out = *this;
  if (effect == "motion")
    out.motion = out.rigidity = false;
  else if (effect == "rigidity")
    out.rigidity = false;
  else if (effect == "view")
    out.view = -1;
  else if (effect == "light")
    out.light = false;
  else
    out.background = -1;
  return out;
}

EffectSet effects_of(const Config& c) {
  return {c.motion.enabled, c.motion.enabled && c.motion.rigidity, c.motion.light, c.radiance.sh_order,
          c.run.background_order};
}

void apply(const EffectSet& e, Config& c) {
  c.motion.enabled = e.motion, c.motion.rigidity = e.motion && e.rigidity, c.motion.light = e.light;
  c.radiance.sh_order = e.view, c.run.background_order = e.background;
}

std::string to_string(const EffectSet& effects) {
  std::string out;
  for (const std::string& name : effect_names())
    if (effects.has(name)) out += (out.empty() ? "" : ", ") + name;
  return out.empty() ? "none" : out;
}

double EffectTrial::mean() const {
  double sum = 0;
  for (const double db : psnr) sum += db;
  return sum / double(std::max<std::size_t>(1, psnr.size()));
}

}  // namespace splinevox
