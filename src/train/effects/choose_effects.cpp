// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <utility>

#include "data/times/seen_moments.hpp"
#include "splinevox/math/metrics.hpp"
#include "splinevox/train/effects.hpp"
#include "train/by_time.hpp"
#include "train/effects/effect_table.hpp"
#include "train/effects/film.hpp"
#include "train/effects/halves.hpp"
#include "train/effects/ladder.hpp"
#include "train/effects/still_proof.hpp"
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
constexpr float kThinLoss = 1.5f;  // dB: a fit too short for the points of presence loses up to 1.7 by them
constexpr double kPresenceChance = 0.1;  // of a gain that is none
/// What solid matter must gain by presence, dB, where so little of it is left at some time (least_matter).
/// What only moves keeps three quarters and more if it is large, half if it is small, and gains up to 2.2 by
/// a presence that stands in for its motion (docs/experiments/effects.md).
float least_presence_gain(double left) {
  return left < 0.5 ? 0.6f : left < 0.75 ? 1.5f : std::numeric_limits<float>::infinity();
}
/// Of effects that nobody tried out: what can stand in for others is not taken on trust.
constexpr const char* kTrusted = "every effect of the preset but presence and drift stays";

/// Leaves out an effect without a trial of its own. @param why  noted, unless something is noted already
void leave_out(EffectChoice& choice, Effect effect, const char* why) {
  if (!choice.chosen.has(effect)) return;
  choice.chosen = choice.chosen.without(effect);
  if (choice.note.empty()) choice.note = why;
}

/// Times that the pieces of a run's curves are halved.
int halvings_to_come(const Config& config) {
  return basis_of(config.motion.basis).halves() ? int(config.motion.halve_start.size()) : 0;
}

int points_for(Ladder& ladder, const EffectSet& effects, const Config& config, double stretch) {
  const Basis& basis = basis_of(config.motion.basis);
  int pieces = basis.pieces(config.motion.points), twice = pieces;
  while (pieces > 1 &&
         !(ladder.judge(effects, basis.points_of(pieces), basis.points_of(pieces / 2)).gain.mean >
           config.effects.min_gain))
    twice = std::exchange(pieces, pieces / 2);
  const int halvings = halvings_to_come(config);
  return std::clamp(basis.points_of(int(std::ceil(std::ldexp(twice / stretch, -halvings)))),
                    config.motion.points, basis.most_points(halvings));
}

/// What comes and goes is told moment by moment: about as many pieces in the end as there are moments, where
/// several cameras see each. At most thrice as many as configured.
/// @param halvings  of the pieces that are still to come
int points_for_moments(const Config& config, const Split& train, int halvings) {
  std::set<double> all;
  for (const Frame& f : train.frames) all.insert(f.time);
  const std::size_t moments = count_moments(times_of_cameras(train), all);
  const Basis& basis = basis_of(config.motion.basis);
  const bool elevates = !basis.halves() && !config.motion.elevate_points.empty();  // to points that are set
  if (2 * moments > train.frames.size() || basis.pieces(config.motion.points) <= 1 || elevates)
    return config.motion.points;
  const int pieces = std::min(int(std::ceil(std::ldexp(double(moments - 1), -halvings))),
                              3 * basis.pieces(config.motion.points));
  return std::clamp(basis.points_of(pieces), config.motion.points, basis.most_points(halvings));
}

/// The points that were found out, or as many as a model file has grids for, with those that it begins with.
int points_that_fit(const Config& config, const EffectChoice& choice) {
  Config c = config;
  apply(choice.chosen, c);
  for (c.motion.points = choice.points;
       c.motion.points > config.motion.points && grids_at_end(c) > kMostGrids;)
    --c.motion.points;
  return c.motion.points;
}

/// Whether effects stay, each judged beside all that do so far.
class Trials {
 public:
  /// @param brief  the fits are shorter than effects.steps of the run
  Trials(const Config& config, bool brief, const PictureStats& stats, TakenBy by, const Split& train,
         const TimeMap& time_map, const StillProof& proof, EffectChoice& out,
         const std::function<void(const EffectTrial&)>& on_trial)
      : config_(config),
        brief_(brief),
        thin_(stats.thin()),
        unit_(brightness(config, stats)),
        by_(by),
        train_(train),
        time_map_(time_map),
        out_(out),
        on_trial_(on_trial),
        level_(config.effects.level / float(most_comparisons(out.chosen))),
        halves_(divide(train, {frames_by_time(train)})),
        changing_(proof.says(StillVerdict::changed) ? changing_pixels(proof, halves_) : std::vector<Image>()),
        whole_(config, level_, unit_, halves_, time_map, out, on_trial) {
    out.held_out = int(halves_.held_out.frames.size());
  }

  /// Whether there is something to fit to and something to compare with.
  bool possible() const { return halves_.usable(); }

  bool stays(Effect effect) {
    switch (facts_of(effect).trial) {
      case Trial::none:
        return true;
      case Trial::by_mean:
        return gains(whole_.judge(effect, beside()));
      case Trial::by_place:
        return gains(elsewhere().judge(effect, beside()));
      case Trial::exposure:
        return sure(whole_.judge_exposure(beside()));
      case Trial::drift:
        drift_ = true;
        return drifts();
      case Trial::clock:
        clocks_ = true;
        return !out_.chosen.has(Effect::motion) || sure(whole_.judge_clock(beside(), train_));
      case Trial::motion:
        return moves();
      case Trial::alone:
        return out_.chosen.has(Effect::motion) || changes_alone(effect);
      case Trial::presence:
        presence_ = true;
        return comes_and_goes();
    }
    return true;
  }

 private:
  /// What the other effects are judged beside. Gains that drift come after those that do not, and of a film,
  /// where light could stand in for them, beside a still world. Clocks, which are told by what moves, come
  /// after motion, and presence, which can stand in for anything, last.
  EffectSet beside() const {
    EffectSet all = out_.chosen;
    if (!drift_) all = all.without(Effect::drift);
    if (!clocks_) all = all.without(Effect::clock);
    return presence_ ? all : all.without(Effect::presence);
  }
  /// Brief fits leave out only what surely gains nothing: what they do not tell is not worth less.
  bool kept_by_brief(const EffectVerdict& v) const { return v.decision != EffectDecision::off; }
  bool gains(const EffectVerdict& v) const {
    return brief_ ? kept_by_brief(v) : v.gain.mean > config_.effects.min_gain;
  }
  bool sure(const EffectVerdict& v) const {
    return brief_ ? kept_by_brief(v) : v.decision == EffectDecision::on;
  }
  /// Comparisons on held-out cameras of a rig: other pictures of a camera that trains are fitted by anything.
  /// On the whole split where too few cameras stand still.
  Ladder& elsewhere() {
    if (!places_) {
      places_ = divide_cameras(train_);
      if (places_->usable()) by_place_.emplace(config_, level_, unit_, *places_, time_map_, out_, on_trial_);
    }
    return by_place_ ? *by_place_ : whole_;
  }

  /// In a film light could stand in for gains, and once they are there, take half of what is theirs
  /// (docs/experiments/effects.md). So they are judged beside a still world, and light goes where they stay.
  bool drifts() {
    const bool film = by_ == TakenBy::film;
    const EffectVerdict v = whole_.judge_drift(film ? unchanging(beside()) : beside(), film);
    const bool on = v.decision == EffectDecision::on;
    if (film && on)
      leave_out(out_, Effect::light, "the exposure drifts: no light, which could not be told from it");
    return on;
  }
  bool moves() {
    if (out_.film && !out_.film->unexplained()) return false;
    const bool proved = !changing_.empty();
    bool found = proved ? moves_as_proved() : moves_in(whole_, true);
    const std::optional<Stretch> stretch = middle_stretch(train_);
    const Basis& basis = basis_of(config_.motion.basis);
    if (brief_ || !stretch || basis.smooth <= 0 || basis.pieces(config_.motion.points) <= 1) return found;
    const Halves parts = divide(train_, *stretch);
    if (!parts.usable()) return found;
    Ladder near(config_, level_, unit_, parts, time_map_, out_, on_trial_);
    if (const bool there = moves_in(near, false); there || (found && proved)) {
      found = true;
      out_.points = points_for(near, beside(), config_, stretch->length);
    }
    return found;
  }
  /// Something changes: that is motion unless light alone explains it as well.
  bool moves_as_proved() {
    const EffectSet all = beside(), light = all.without(Effect::motion);
    const std::size_t at = out_.verdicts.size();
    const EffectVerdict v = whole_.judge_where_changing(Effect::motion, all, changing_);
    bool lit = false;
    if (v.decision == EffectDecision::off && light.has(Effect::light)) {
      lit = whole_.judge_where_changing(Effect::light, light, changing_).decision == EffectDecision::on;
      out_.verdicts.pop_back();  // light has its own turn
    }
    if (!lit && v.decision != EffectDecision::on) out_.verdicts[at].decision = EffectDecision::proved;
    return !lit;
  }
  bool moves_in(Ladder& by, bool whole) {
    const EffectSet all = beside();
    // Undecided motion goes by its mean, and what is decided has its mean on the same side of min_gain.
    const bool enough = gains(by.judge(Effect::motion, all));
    if (out_.film && (out_.film->moves() || !brief_))  // the thresholds are those of whole fits
      return by.judge_film(all, out_.film->moves());
    if (whole && !enough) by.judge_where_needed(all);
    return gains(out_.verdicts.back());
  }
  bool of_film() const { return is_film(out_.view_told_by_time.value_or(0)); }

  bool changes_alone(Effect effect) {
    if (!changing_.empty()) return sure(whole_.judge_where_changing(effect, beside(), changing_));
    const bool on = sure(whole_.judge(effect, beside()));
    if (!on || !of_film()) return on;
    out_.verdicts.back().decision = EffectDecision::confounded;
    return false;
  }

  /// Whether matter comes and goes. In a film presence could stand in for anything, and of solid matter brief
  /// fits tell too little.
  bool comes_and_goes() {
    if ((brief_ && !thin_) || of_film()) return false;
    const int points = points_for_moments(config_, train_, 0);  // a fit halves nothing
    const bool on = thin_ ? thin_comes_and_goes(points) : solid_comes_and_goes(points);
    if (on)
      out_.points = std::max(out_.points, points_for_moments(config_, train_, halvings_to_come(config_)));
    EffectVerdict& v = out_.verdicts.back();
    if (!on && v.decision == EffectDecision::on) v.decision = EffectDecision::confounded;
    if (on && v.decision == EffectDecision::off) v.decision = EffectDecision::proved;
    return on;
  }
  /// Thin matter does, unless presence surely gains nothing. Where still cameras prove that it changes, it
  /// must surely lose more than so short a fit may.
  bool thin_comes_and_goes(int points) {
    const EffectVerdict v = whole_.judge(Effect::presence, beside(), points);
    if (v.decision == EffectDecision::off && (changing_.empty() || v.gain.hi < -kThinLoss)) return false;
    // It fits the cameras instead (docs/experiments/matter.md).
    leave_out(out_, Effect::view, "thin matter that comes and goes: no view dependence");
    return true;
  }
  /// Solid matter does if presence gains and there is not as much of it at all times. Presence can also stand
  /// in for a motion that so short a fit has not found yet; then what changes keeps its amount.
  bool solid_comes_and_goes(int points) {
    const EffectSet with = beside();
    std::optional<double> left;  // of the one fit, wherever its gain is asked
    const auto enough = [&](const EffectVerdict& v) {
      if (!(v.gain.mean > std::max(config_.effects.min_gain, least_presence_gain(0))) ||
          !(v.gain.p < kPresenceChance))
        return false;
      if (!left) left = whole_.least_matter(with, points);
      out_.verdicts.back().least_matter = left;
      return v.gain.mean > least_presence_gain(*left);
    };
    if (enough(whole_.judge(Effect::presence, with, points))) return true;
    if (changing_.empty()) return false;
    out_.verdicts.pop_back();  // it may be a small part
    return enough(whole_.judge_where_changing(Effect::presence, with, changing_, points));
  }

  const Config& config_;
  const bool brief_, thin_;
  const float unit_;  ///< of brightness
  const TakenBy by_;
  const Split& train_;
  const TimeMap& time_map_;
  EffectChoice& out_;
  const std::function<void(const EffectTrial&)>& on_trial_;
  const float level_;
  const Halves halves_;
  const std::vector<Image> changing_;  ///< of the held-out pictures, where cameras that stand still prove it
  Ladder whole_;
  std::optional<Halves> places_;  ///< whole cameras are held out
  std::optional<Ladder> by_place_;
  bool drift_ = false, clocks_ = false, presence_ = false;  ///< their turn has come
};

/// Steps of a fit: effects.steps, or its share of a run that is short for them.
int fit_steps(const Config& config) {
  const double share = config.run.max_time > 0 ? config.run.max_time / kShortestTime
                                               : config.run.max_steps / (kShortest * config.effects.steps);
  return int(config.effects.steps * std::min(share, 1.0));
}

/// Why nothing can be tried out in this configuration; empty: it can.
std::string untried(const Config& config) {
  if (config.effects.steps == 0)
    return fmt::format("effects.steps is 0: nothing was tried, and {}", kTrusted);
  if (fit_steps(config) < std::min(kShortestFit, config.effects.steps))
    return fmt::format("too short a run to try effects out ({} steps for a fit, {} at least): {}",
                       fit_steps(config), kShortestFit, kTrusted);
  return {};
}

/// What kTrusted says.
EffectChoice on_trust(EffectChoice out) {
  out.chosen = out.chosen.without(Effect::presence).without(Effect::drift);
  return out;
}

bool one_moment(const Split& train) {
  const auto [first, last] =
      std::minmax_element(train.frames.begin(), train.frames.end(),
                          [](const Frame& a, const Frame& b) { return a.time < b.time; });
  return first->time == last->time;
}

}  // namespace

EffectChoice choose_effects(const Config& config, const Split& train, const TimeMap& time_map,
                            const std::function<void(const EffectTrial&)>& on_trial,
                            const std::function<void(const FilmEvidence&)>& on_film) {
  const auto start = std::chrono::steady_clock::now();
  EffectChoice out;
  const PictureStats stats = picture_stats(train);
  const TakenBy by = taken_by(train);
  out.chosen = learnable_in(effects_of(config), !stats.see_through, by);
  out.points = config.motion.points;
  out.note = untried(config);
  if (!out.note.empty()) return on_trust(std::move(out));
  if (one_moment(train)) {
    out.chosen = unchanging(out.chosen);
    out.note = "every view is of one time: nothing can be seen to change";
  }
  const StillProof proof = prove(train, brightness(config, stats));
  out.still = proof.evidence;
  if (proof.says(StillVerdict::unchanged)) {
    out.chosen = unchanging(out.chosen);
    if (out.note.empty()) out.note = "every camera stands still, and nothing changes before any";
  }
  if (int(train.frames.size()) < kFewestViews) {
    if (out.note.empty()) out.note = fmt::format("too few views to hold some out: {}", kTrusted);
    return on_trust(std::move(out));
  }
  const std::vector<Effect> tried = in_turn(out.chosen);
  if (tried.empty()) return out;
  if (changes(out.chosen)) {
    out.view_told_by_time = view_told_by_time(config, train, starting_middle(config, train));
  }
  Config fitted = config;
  fitted.effects.steps = fit_steps(config);
  const bool brief = fitted.effects.steps < config.effects.steps;
  if (brief && out.note.empty())
    out.note =
        fmt::format("a short run: fits have {} steps, not {}, and leave out only what surely gains nothing",
                    fitted.effects.steps, config.effects.steps);
  Trials trials(fitted, brief, stats, by, train, time_map, proof, out, on_trial);
  if (!trials.possible()) {
    out.note = fmt::format("masks leave too little of small pictures: {}", kTrusted);
    return on_trust(std::move(out));
  }
  for (const Effect e : tried) {
    if (e == Effect::motion) {
      Config still = config;
      still.cameras.drift = out.chosen.has(Effect::drift);
      out.film = motion_told(still, train, time_map, *out.view_told_by_time, out.moving, on_film);
    }
    if (out.chosen.has(e) && !trials.stays(e)) out.chosen = out.chosen.without(e);
  }
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
  out.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return out;
}

}  // namespace splinevox
