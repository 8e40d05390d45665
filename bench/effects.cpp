// SPDX-License-Identifier: Apache-2.0
// Does the choice of effects see what is in a scene? Built-in scenes of known make-up, thirty-two kinds,
// several seeds each, and real ones if named: what was chosen, what should have been, and a count at the end,
// over what is judged at all: motion, light where nothing moves, a background behind opaque pictures, matter
// that comes and goes, and cameras that differ.
//
//   bench_effects [DATASET]... [--seeds 10] [--steps 200] [--size 96] [--frames 60] [--kind NAME] [--orbit
//   TURNS]
//
// One JSON line per scene.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "splinevox/core/error.hpp"
#include "splinevox/data/synth.hpp"
#include "splinevox/train/prepare.hpp"

using namespace splinevox;

namespace {

struct Kind {
  std::string name;
  std::vector<std::string> scenes;  ///< one for each seed in turn
  SynthLook look;
  std::set<std::string> truth;    ///< effects that are there
  int frames = 0;                 ///< 0: as asked for
  std::vector<double> orbits{0};  ///< SynthOptions::orbit, one for each seed in turn
  SynthRig rig = {};
  std::set<std::string> either = {};  ///< effects that may as well be chosen as not
  double drift = 0;                   ///< SynthOptions::drift
};

std::vector<Kind> kinds() {
  const std::vector<std::string> movers{"dancer", "ball", "snake"}, still{"static"};
  const std::vector<double> around{0.3, 0.5, 1, 1.5};
  const SynthRig turns{.cameras = 12, .turns = true}, all{.cameras = 8},
      exposures{.cameras = 8, .exposures = 0.14}, late{.cameras = 8, .late = 0.5};
  constexpr int kMoments = 12;  // of a rig whose cameras see them all
  constexpr int kGas = 24;      // gas changes faster
  constexpr double kDrift = 0.25;
  return {
      {"static, matte", still, {}, {}},
      {"static, glossy", still, {.gloss = 0.6}, {"view"}},
      {"moving, matte", movers, {}, {"motion"}},
      {"moving, glossy", movers, {.gloss = 0.6}, {"motion", "view"}},
      {"static, light fades", still, {.fade = 0.6}, {"light"}},
      {"moving, light fades", movers, {.fade = 0.6}, {"motion", "light"}},
      {"moving, opaque", movers, {.opaque = true}, {"motion", "background"}},
      {"moving, dark", movers, {.light = 0.1}, {"motion"}},
      {"static, few frames", still, {}, {}, 6},
      {"a twentieth moves", {"toy"}, {}, {"motion"}},
      {"a fifth moves", {"garden"}, {}, {"motion"}},
      {"film, static, matte", still, {}, {}, 0, around},
      {"film, static, glossy", still, {.gloss = 0.6}, {"view"}, 0, around},
      {"film, moving", movers, {}, {"motion"}, 0, around},
      {"film, a twentieth moves", {"toy"}, {}, {"motion"}, 0, around},
      {"turns, static", still, {}, {}, 0, {0}, turns},
      {"turns, moving", movers, {}, {"motion"}, 0, {0}, turns},
      {"turns, a twentieth moves", {"toy"}, {}, {"motion"}, 0, {0}, turns},
      {"turns, light fades", still, {.fade = 0.6}, {"light"}, 0, {0}, turns},
      {"rig, static", still, {}, {}, kMoments, {0}, all},
      {"rig, moving, opaque", movers, {.opaque = true}, {"motion", "background"}, kMoments, {0}, all},
      {"rig, a twentieth moves", {"toy"}, {}, {"motion"}, kMoments, {0}, all},
      {"rig, light fades", still, {.fade = 0.6}, {"light"}, kMoments, {0}, all},
      {"rig, exposures", movers, {}, {"motion", "exposure"}, kMoments, {0}, exposures},
      {"rig, static, exposures", still, {}, {"exposure"}, kMoments, {0}, exposures},
      {"rig, one late", movers, {}, {"motion", "clock"}, 2 * kMoments, {0}, late},
      {"film, static, exposures drift", still, {}, {"drift"}, 0, around, {}, {}, kDrift},
      {"rig, exposures drift", movers, {}, {"motion", "drift"}, 2 * kMoments, {0}, all, {"exposure"}, kDrift},
      {"rig, smoke", {"smoke"}, {}, {"presence"}, kGas, {0}, all, {"motion", "light"}},
      {"rig, fire", {"fire"}, {}, {"presence"}, kGas, {0}, all, {"motion", "light"}},
      {"rig, enters", {"enters"}, {}, {"motion", "presence"}, kMoments, {0}, all},
      {"rig, leaves", {"leaves"}, {}, {"motion", "presence"}, kMoments, {0}, all}};
}

nlohmann::json describe(const EffectChoice& choice) {
  nlohmann::json j{{"chosen", to_string(choice.chosen)},
                   {"view_told_by_time", choice.view_told_by_time.value_or(0)},
                   {"seconds", choice.seconds},
                   {"note", choice.note}};
  if (choice.still)
    j["still"] = fmt::format("{} of {} cameras, {:.4f} of their pixels", choice.still->changing,
                             choice.still->cameras, choice.still->share);
  if (choice.film)
    j["film"] = fmt::format("{:.1f} dB still, {:.3f}% of the pixels move, {:.3f}% in hue", choice.film->psnr,
                            100 * choice.film->share, 100 * choice.film->coloured);
  for (const EffectVerdict& v : choice.verdicts) {
    j["gains"][to_string(v.effect)] = fmt::format("{:.2f} [{:.2f}, {:.2f}] beside {}", v.gain.mean, v.gain.lo,
                                                  v.gain.hi, to_string(v.with.without(v.effect)));
    if (v.spread) j["spread"][to_string(v.effect)] = *v.spread;
    if (v.apart) j["apart"][to_string(v.effect)] = *v.apart;
    if (v.whole) j["whole"][to_string(v.effect)] = *v.whole;
    if (v.least_matter) j["least_matter"] = *v.least_matter;
    for (const ClockDoubt& d : v.clocks)
      j["clocks"].push_back(fmt::format("{:.2f} [{:.2f}, {:.2f}]", d.offset.mean, d.offset.lo, d.offset.hi));
  }
  for (const EffectTrial& t : choice.trials)
    j["fits"][to_string(t.effects)] =
        fmt::format("{:.2f} dB, {} steps, {:.2f} s", t.mean(), t.steps, t.seconds);
  return j;
}

/// Effects that fits or the cameras themselves decided.
std::set<Effect> judged_in(const EffectChoice& choice) {
  std::set<Effect> out;
  for (const EffectVerdict& v : choice.verdicts) out.insert(v.effect);
  if (choice.film) out.insert(Effect::motion);
  if (choice.still && choice.still->verdict == StillVerdict::unchanged)
    out.insert({Effect::motion, Effect::light});
  return out;
}

void say(const nlohmann::json& j) {
  fmt::print("{}\n", j.dump());
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("does the choice of effects see what is in a scene?");
  std::vector<std::string> scenes;
  int seeds = 10, size = 96, frames = 60, steps = 200;
  double orbit = 0;
  std::string only;
  app.add_option("scenes", scenes, "data sets; none: the built-in kinds");
  app.add_option("--seeds", seeds);
  app.add_option("--steps", steps, "of each fit");
  app.add_option("--size", size);
  app.add_option("--frames", frames);
  app.add_option("--kind", only, "of the built-in ones");
  app.add_option("--orbit", orbit, "times that the camera goes around; 0: as the kind has it");
  CLI11_PARSE(app, argc, argv);
  Config config = preset("fast");
  config.effects.steps = steps;
  try {
    for (const std::string& scene : scenes) {
      Dataset data = load_dataset(scene, {.splits = {"train"}});
      nlohmann::json j = describe(prepare(config, data).effects);
      j["scene"] = std::filesystem::path(scene).filename().string();
      say(j);
    }
    if (!scenes.empty()) return 0;
    std::map<std::string, int> absent, switched_on, present, missed;
    int right = 0, all = 0;
    for (const Kind& kind : kinds()) {
      if (!only.empty() && kind.name != only) continue;
      for (int seed = 1; seed <= seeds; ++seed) {
        const double turns = orbit != 0 ? orbit : kind.orbits[std::size_t(seed) % kind.orbits.size()];
        const std::string scene = kind.scenes[std::size_t(seed) % kind.scenes.size()];
        Dataset data = make_synth(scene, {.frames = kind.frames ? kind.frames : frames,
                                          .size = size,
                                          .seed = std::uint64_t(seed),
                                          .orbit = turns,
                                          .film = kind.drift > 0 && turns > 0,
                                          .drift = kind.drift,
                                          .look = kind.look,
                                          .rig = kind.rig});
        config.run.seed = std::uint64_t(seed);
        const EffectChoice choice = prepare(config, data).effects;
        bool same = true;
        const std::set<Effect> judged = judged_in(choice);
        for (const Effect e : judged) {
          const std::string effect = to_string(e);
          if (kind.either.count(effect)) continue;
          const bool there = kind.truth.count(effect), on = choice.chosen.has(e);
          ++(there ? present : absent)[effect];
          if (there != on) {
            ++(there ? missed : switched_on)[effect];
            same = false;
          }
        }
        nlohmann::json j = describe(choice);
        j["kind"] = kind.name;
        j["orbit"] = turns;
        j["scene"] = scene;
        j["seed"] = seed;
        j["right"] = same;
        say(j);
        if (judged.empty()) continue;
        right += same;
        ++all;
      }
    }
    nlohmann::json sum{{"right", right}, {"of", all}};
    for (const std::string effect :
         {"motion", "light", "background", "presence", "exposure", "clock", "drift"})
      sum[effect] = {
          {"switched on where absent", fmt::format("{} of {}", switched_on[effect], absent[effect])},
          {"missed where present", fmt::format("{} of {}", missed[effect], present[effect])}};
    say(sum);
  } catch (const Error& error) {
    fmt::print(stderr, "bench_effects: {}\n", error.what());
    return 2;
  }
}
