// SPDX-License-Identifier: Apache-2.0
#include "train/effects/trials.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "data/times/seen_moments.hpp"
#include "train/by_time.hpp"
#include "train/effects/film.hpp"
#include "train/learn_cameras.hpp"

namespace splinevox {
namespace {

constexpr float kThinLoss = 1.5f;  // dB: a fit too short for the points of presence loses up to 1.7 by them
constexpr double kPresenceChance = 0.1;  // of a gain that is none
/// What solid matter must gain by presence, dB, where so little of it is left at some time (least_matter).
/// What only moves keeps three quarters and more if it is large, half if it is small, and gains up to 2.2 by
/// a presence that stands in for its motion (docs/experiments/effects.md).
float least_presence_gain(double left) {
  return left < 0.5 ? 0.6f : left < 0.75 ? 1.5f : std::numeric_limits<float>::infinity();
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
  const std::size_t moments = moments_of(train).size();
  const Basis& basis = basis_of(config.motion.basis);
  const bool elevates = !basis.halves() && !config.motion.elevate_points.empty();  // to points that are set
  if (2 * moments > train.frames.size() || basis.pieces(config.motion.points) <= 1 || elevates)
    return config.motion.points;
  const int pieces = std::min(int(std::ceil(std::ldexp(double(moments - 1), -halvings))),
                              3 * basis.pieces(config.motion.points));
  return std::clamp(basis.points_of(pieces), config.motion.points, basis.most_points(halvings));
}

}  // namespace

void leave_out(EffectChoice& choice, Effect effect, const char* why) {
  if (!choice.chosen.has(effect)) return;
  choice.chosen = choice.chosen.without(effect);
  if (choice.note.empty()) choice.note = why;
}

Trials::Trials(const Config& config, bool brief, const PictureStats& stats, TakenBy by, const Split& train,
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

bool Trials::stays(Effect effect) {
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

bool Trials::stays_untried(Effect effect) {
  switch (facts_of(effect).trial) {
    case Trial::drift:
      return false;
    case Trial::clock:
      clocks_ = true;
      return true;
    case Trial::alone:
      return out_.chosen.has(Effect::motion);
    case Trial::presence:
      if (!thin_ || of_film()) return false;
      use_presence();
      return true;
    default:
      return true;
  }
}

EffectSet Trials::beside() const {
  EffectSet all = out_.chosen;
  if (!drift_) all = all.without(Effect::drift);
  if (!clocks_) all = all.without(Effect::clock);
  return presence_ ? all : all.without(Effect::presence);
}

Ladder& Trials::elsewhere() {
  if (!places_) {
    places_ = divide_cameras(train_);
    if (places_->usable()) by_place_.emplace(config_, level_, unit_, *places_, time_map_, out_, on_trial_);
  }
  return by_place_ ? *by_place_ : whole_;
}

bool Trials::drifts() {
  const bool film = by_ == TakenBy::film;
  if (!film) {  // with one gain a camera a fit would tell exposures alone
    CamerasConfig gains;
    gains.exposure = gains.clock = false;
    const CameraFits learned = cameras_to_learn(gains, halves_.fitted);
    if (learned.cameras.empty() || learned.cameras.front().gains.size() < 2) return false;
  }
  const EffectVerdict v = whole_.judge_drift(film ? unchanging(beside()) : beside(), film);
  const bool on = v.decision == EffectDecision::on;
  if (film && on)
    leave_out(out_, Effect::light, "the exposure drifts: no light, which could not be told from it");
  return on;
}

bool Trials::moves() {
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

bool Trials::moves_as_proved() {
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

bool Trials::moves_in(Ladder& by, bool whole) {
  const EffectSet all = beside();
  // Undecided motion goes by its mean, and what is decided has its mean on the same side of min_gain.
  const bool enough = gains(by.judge(Effect::motion, all));
  if (out_.film && (out_.film->moves() || !brief_))  // the thresholds are those of whole fits
    return by.judge_film(all, out_.film->moves());
  if (whole && !enough) by.judge_where_needed(all);
  return gains(out_.verdicts.back());
}

bool Trials::of_film() const { return is_film(out_.view_told_by_time.value_or(0)); }

bool Trials::changes_alone(Effect effect) {
  if (!changing_.empty()) return sure(whole_.judge_where_changing(effect, beside(), changing_));
  const bool on = sure(whole_.judge(effect, beside()));
  if (!on || !of_film()) return on;
  out_.verdicts.back().decision = EffectDecision::confounded;
  return false;
}

bool Trials::comes_and_goes() {
  if (of_film() && thin_)
    leave_out(out_, Effect::presence, "a film of thin matter: no presence, for which it takes more cameras");
  if ((brief_ && !thin_) || of_film()) return false;
  const int points = points_for_moments(config_, train_, 0);  // a fit halves nothing
  const bool on = thin_ ? thin_comes_and_goes(points) : solid_comes_and_goes(points);
  if (on) use_presence();
  EffectVerdict& v = out_.verdicts.back();
  if (!on && v.decision == EffectDecision::on) v.decision = EffectDecision::confounded;
  if (on && v.decision == EffectDecision::off) v.decision = EffectDecision::proved;
  return on;
}

bool Trials::thin_comes_and_goes(int points) {
  const EffectVerdict v = whole_.judge(Effect::presence, beside(), points);
  return v.decision != EffectDecision::off || (!changing_.empty() && v.gain.hi >= -kThinLoss);
}

void Trials::use_presence() {
  out_.points = std::max(out_.points, points_for_moments(config_, train_, halvings_to_come(config_)));
  // View dependence fits the cameras instead (docs/experiments/matter.md).
  if (thin_) leave_out(out_, Effect::view, "thin matter that comes and goes: no view dependence");
}

bool Trials::solid_comes_and_goes(int points) {
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

}  // namespace splinevox
