// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "core/stopwatch.hpp"
#include "splinevox/train/effects.hpp"
#include "train/effects/effect_table.hpp"
#include "train/effects/film.hpp"
#include "train/effects/still_proof.hpp"
#include "train/effects/trials.hpp"
#include "train/film/still_world.hpp"
#include "train/learn_cameras.hpp"
#include "train/start.hpp"

namespace splinevox {
namespace {

constexpr int kFewestViews = 8;  // to hold some out
constexpr double kShortest = 8;  // steps of training for one of a fit, on coarser lattices and with fewer
                                 // rays: all fits cost under a tenth
constexpr double kShortestTime = 25;  // seconds of training, for the same reason
constexpr int kShortestFit = 100;     // steps of a fit: fewer were never tried (docs/experiments/effects.md)

/// The points that were found out, or as many as a model file has grids for, with those that it begins with.
int points_that_fit(const Config& config, const EffectChoice& choice) {
  Config c = config;
  apply(choice.chosen, c);
  for (c.motion.points = choice.points;
       c.motion.points > config.motion.points && grids_at_end(c) > kMostGrids;)
    --c.motion.points;
  return c.motion.points;
}

/// Steps of a fit: effects.steps, or its share of a run that is short for them.
int fit_steps(const Config& config) {
  double share = 1;
  if (config.run.max_time > 0) share = std::min(share, config.run.max_time / kShortestTime);
  if (config.run.max_steps > 0)
    share = std::min(share, config.run.max_steps / (kShortest * config.effects.steps));
  return int(config.effects.steps * share);
}

/// Why nothing can be tried out in this configuration; empty: it can.
std::string untried(const Config& config) {
  if (config.effects.steps == 0) return "effects.steps is 0: nothing was tried";
  if (fit_steps(config) < std::min(kShortestFit, config.effects.steps))
    return fmt::format("too short a run to try effects out ({} steps for a fit, {} at least)",
                       fit_steps(config), kShortestFit);
  return {};
}

/// Effects that nobody tried out: what can stand in for others is not taken on trust.
EffectChoice on_trust(EffectChoice out, const std::string& why) {
  if (out.note.empty()) {
    out.note = why;
    out.on_trust = true;
  }
  out.chosen = out.chosen.without(Effect::presence).without(Effect::drift);
  return out;
}

/// Whether there is time to try an effect. A slow machine would spend a short run on its trials alone.
class TrialTime {
 public:
  /// @param share  of what is left of run.max_time, for all trials; 0: there is time
  /// @param used   seconds of it that are gone
  TrialTime(const RunConfig& run, double share, double used)
      : most_(run.max_time > 0 && share > 0 ? share * std::max(0.0, run.max_time - used)
                                            : std::numeric_limits<double>::infinity()) {}
  double spent() const { return timer_.seconds(); }
  /// @param fits  that were made so far
  bool left_for(Effect effect, std::size_t fits) const {
    const double fit = spent() / double(std::max<std::size_t>(1, fits));
    return spent() + facts_of(effect).fits * fit <= most_;
  }

 private:
  const Timer timer_;
  const double most_;
};

bool one_moment(const Split& train) {
  const auto [first, last] =
      std::minmax_element(train.frames.begin(), train.frames.end(),
                          [](const Frame& a, const Frame& b) { return a.time < b.time; });
  return first->time == last->time;
}

}  // namespace

EffectChoice choose_effects(const Config& config, const Split& train, const TimeMap& time_map,
                            const std::function<void(const EffectTrial&)>& on_trial,
                            const std::function<void(const FilmEvidence&)>& on_film, bool by_clock,
                            double used) {
  const TrialTime time(config.run, by_clock ? config.effects.most_time : 0, used);
  EffectChoice out;
  const PictureStats stats = picture_stats(train);
  const TakenBy by = taken_by(train);
  out.chosen = learnable_in(effects_of(config), !stats.see_through, by);
  out.points = config.motion.points;
  if (one_moment(train)) {
    out.chosen = unchanging(out.chosen);
    out.note = "every view is of one time: nothing can be seen to change";
  }
  if (const std::string why = untried(config); !why.empty()) return on_trust(std::move(out), why);
  const StillProof proof = prove(train, brightness(config, stats));
  out.still = proof.evidence;
  if (proof.says(StillVerdict::unchanged)) {
    out.chosen = unchanging(out.chosen);
    if (out.note.empty()) out.note = "every camera stands still, and nothing changes before any";
  }
  if (int(train.frames.size()) < kFewestViews)
    return on_trust(std::move(out), "too few views to hold some out");
  const std::vector<Effect> tried = in_turn(out.chosen);
  if (tried.empty()) return out;
  if (changes(out.chosen)) {
    out.view_told_by_time = view_told_by_time(config, train, starting_middle(config, train));
  }
  Config fitted = config;
  fitted.effects.steps = fit_steps(config);
  const bool brief = fitted.effects.steps < config.effects.steps;
  Trials trials(fitted, brief, stats, by, train, time_map, proof, out, on_trial);
  if (!trials.possible()) return on_trust(std::move(out), "masks leave too little of small pictures");
  if (brief && out.note.empty())
    out.note =
        fmt::format("a short run: fits have {} steps, not {}, and leave out only what surely gains nothing",
                    fitted.effects.steps, config.effects.steps);
  std::vector<std::string> no_time;
  for (const Effect e : tried) {
    const bool can = time.left_for(e, out.trials.size());
    if (e == Effect::motion && can) {
      Config still = config;
      still.cameras.drift = out.chosen.has(Effect::drift);
      out.film = motion_told(still, train, time_map, *out.view_told_by_time, out.moving, on_film);
    }
    if (!out.chosen.has(e)) continue;
    if (!can) no_time.push_back(to_string(e));
    if (!(can ? trials.stays(e) : trials.stays_untried(e))) out.chosen = out.chosen.without(e);
  }
  if (!no_time.empty())
    out.note += fmt::format(
        "{}trials took {:.0f} of {:.0f} seconds, and there was no time to try {}. That stays, but drift, "
        "presence of solid matter, and light where nothing moves do not",
        out.note.empty() ? "" : "; ", time.spent(), config.run.max_time - used, fmt::join(no_time, ", "));
  // Light would learn the highlights of such a film, and show them from elsewhere. Motion was judged beside
  // it.
  if (std::any_of(out.verdicts.begin(), out.verdicts.end(), [](const EffectVerdict& v) {
        return v.effect == Effect::drift && v.decision == EffectDecision::confounded;
      }))
    leave_out(out, Effect::light,
              "brightness changes with the camera's way: no light, which could not be told from that");
  out.points = points_that_fit(config, out);
  // Of a long sequence the whole and a stretch may differ: what either finds is used.
  for (EffectVerdict& v : out.verdicts)
    if (v.decision == EffectDecision::confounded && out.chosen.has(v.effect))
      v.decision = EffectDecision::undecided;
  out.seconds = time.spent();
  return out;
}

}  // namespace splinevox
