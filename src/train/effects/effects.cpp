// SPDX-License-Identifier: Apache-2.0
#include "splinevox/train/effects.hpp"

#include <algorithm>

#include "math/sh.hpp"
#include "train/effects/effect_table.hpp"

namespace splinevox {
namespace {

constexpr int switched(bool on) { return on ? 0 : EffectSet::kOff; }

constexpr EffectFacts kTable[] = {
    {.effect = Effect::motion,
     .name = "motion",
     .brings = ColumnKind::control,
     .order_in = [](const Config& c) { return switched(c.motion.enabled); },
     .set = [](Config& c, int order) { c.motion.enabled = order >= 0; },
     .trial = Trial::motion,
     .turn = 5,
     .comparisons = 2,
     .fits = 1},
    {.effect = Effect::rigidity,
     .name = "rigidity",
     .needs = Effect::motion,
     .why_needs = "rigidity scales motion, so it needs motion",
     .brings = ColumnKind::rigidity,
     .order_in = [](const Config& c) { return switched(c.motion.enabled && c.motion.rigidity); },
     .set = [](Config& c, int order) { c.motion.rigidity = order >= 0; }},
    {.effect = Effect::view,
     .name = "view",
     .brings = ColumnKind::sh,
     .ordered = true,
     .least = 1,
     .full = kMaxShOrder,
     .order_in = [](const Config& c) { return c.radiance.sh_order; },
     .set = [](Config& c, int order) { c.radiance.sh_order = order; }},
    {.effect = Effect::light,
     .name = "light",
     .brings = ColumnKind::light,
     .order_in = [](const Config& c) { return switched(c.motion.light); },
     .set = [](Config& c, int order) { c.motion.light = order >= 0; },
     .trial = Trial::alone,
     .turn = 7,
     .comparisons = 1,
     .fits = 1},
    {.effect = Effect::background,
     .name = "background",
     .ordered = true,
     .opaque_only = true,
     .order_in = [](const Config& c) { return c.run.background_order; },
     .set = [](Config& c, int order) { c.run.background_order = order; },
     .trial = Trial::by_mean,
     .turn = 4,
     .comparisons = 1,
     .fits = 1},
    {.effect = Effect::surroundings,
     .name = "surroundings",
     .needs = Effect::background,
     .why_needs = "surroundings stand before a learned background",
     .opaque_only = true,
     .order_in = [](const Config& c) { return switched(c.run.surroundings && c.run.background_order >= 0); },
     .set = [](Config& c, int order) { c.run.surroundings = order >= 0; },
     .trial = Trial::by_place,
     .turn = 1,  // a guess costs a rig 2 to 5 dB, where time ends before its trial
     .comparisons = 1,
     .fits = 2},
    {.effect = Effect::exposure,
     .name = "exposure",
     .taken_by = TakenBy::rig,
     .order_in = [](const Config& c) { return switched(c.cameras.exposure); },
     .set = [](Config& c, int order) { c.cameras.exposure = order >= 0; },
     .trial = Trial::exposure,
     .turn = 2,
     .comparisons = 1,
     .fits = 2},
    {.effect = Effect::clock,
     .name = "clock",
     .needs = Effect::motion,
     .why_needs = "a camera's clock is told by what moves, so it needs motion",
     .taken_by = TakenBy::rig,
     .order_in = [](const Config& c) { return switched(c.motion.enabled && c.cameras.clock); },
     .set = [](Config& c, int order) { c.cameras.clock = order >= 0; },
     .trial = Trial::clock,
     .turn = 6,
     .comparisons = 1,
     .fits = 6},
    {.effect = Effect::presence,
     .name = "presence",
     .brings = ColumnKind::presence,
     .order_in =
         [](const Config& c) {
           const bool pinned = basis_of(c.motion.basis).pinnable && c.motion.first_point == FirstPoint::zero;
           return switched(c.motion.presence && !pinned);
         },
     .set = [](Config& c, int order) { c.motion.presence = order >= 0; },
     .trial = Trial::presence,
     .turn = 8,
     .comparisons = 2,
     .fits = 2},
    {.effect = Effect::drift,
     .name = "drift",
     .taken_by = TakenBy::film,
     .order_in = [](const Config& c) { return switched(c.cameras.drift); },
     .set = [](Config& c, int order) { c.cameras.drift = order >= 0; },
     .trial = Trial::drift,
     .turn = 3,
     .comparisons = 1,
     .fits = 1},
};

constexpr bool in_order() {
  for (int i = 0; i < int(std::size(kTable)); ++i)
    if (int(kTable[i].effect) != i || kAllEffects[i] != kTable[i].effect) return false;
  return std::size(kTable) == std::size(kAllEffects);
}
static_assert(in_order(), "effects stand in the table as in the enum");

}  // namespace

const EffectFacts& facts_of(Effect effect) { return kTable[int(effect)]; }

std::vector<Effect> in_turn(const EffectSet& effects) {
  std::vector<Effect> out;
  for (const EffectFacts& f : kTable)
    if (f.trial != Trial::none && effects.has(f.effect)) out.push_back(f.effect);
  std::sort(out.begin(), out.end(), [](Effect a, Effect b) { return facts_of(a).turn < facts_of(b).turn; });
  return out;
}

int most_comparisons(const EffectSet& effects) {
  int count = 0;
  for (const EffectFacts& f : kTable) count += f.moving() || effects.has(f.effect) ? f.comparisons : 0;
  return count;
}

EffectSet learnable_in(const EffectSet& effects, bool opaque, TakenBy by) {
  EffectSet out = effects;
  for (const EffectFacts& f : kTable)
    if ((f.opaque_only && !opaque) || by < f.taken_by) out = out.without(f.effect);
  return out;
}

EffectSet unchanging(const EffectSet& effects) {
  EffectSet out = effects;
  for (const EffectFacts& f : kTable)
    if (f.moving()) out = out.without(f.effect);
  return out;
}

bool changes(const EffectSet& effects) {
  return std::any_of(std::begin(kTable), std::end(kTable),
                     [&](const EffectFacts& f) { return f.moving() && effects.has(f.effect); });
}

void store(const EffectSet& effects, MotionField& motion) {
  for (const EffectFacts& f : kTable)
    if (f.moving()) motion.*facts_of(*f.brings).stored = effects.has(f.effect);
}

EffectSet EffectSet::with(Effect effect, int order) const {
  EffectSet out = *this;
  out.order_[int(effect)] = order;
  return out;
}

EffectSet EffectSet::without(Effect effect) const {
  EffectSet out = *this;
  for (const EffectFacts& f : kTable)
    if (f.effect == effect || f.needs == effect) out.order_[int(f.effect)] = kOff;
  return out;
}

const char* to_string(Effect effect) { return facts_of(effect).name; }

std::optional<Effect> effect_named(const std::string& name) {
  for (const EffectFacts& f : kTable)
    if (name == f.name) return f.effect;
  return {};
}

std::vector<std::string> effect_names() {
  std::vector<std::string> names;
  for (const EffectFacts& f : kTable) names.emplace_back(f.name);
  return names;
}

EffectSet effects_of(const Config& config) {
  EffectSet out;
  for (const EffectFacts& f : kTable) out = out.with(f.effect, f.order_in(config));
  return out;
}

void apply(const EffectSet& effects, Config& config) {
  for (const EffectFacts& f : kTable) {
    const bool stands = !f.needs || effects.has(*f.needs);
    f.set(config, stands ? effects.order(f.effect) : EffectSet::kOff);
  }
}

std::string to_string(const EffectSet& effects) {
  std::string out;
  for (const EffectFacts& f : kTable)
    if (effects.has(f.effect)) out += (out.empty() ? "" : ", ") + std::string(f.name);
  return out.empty() ? "none" : out;
}

double EffectTrial::mean() const {
  double sum = 0;
  for (const double db : psnr) sum += db;
  return sum / double(std::max<std::size_t>(1, psnr.size()));
}

}  // namespace splinevox
