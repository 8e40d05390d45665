// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "splinevox/core/image.hpp"
#include "splinevox/train/effects.hpp"
#include "train/effects/effect_table.hpp"
#include "train/effects/halves.hpp"
#include "train/effects/ladder.hpp"
#include "train/effects/still_proof.hpp"
#include "train/start.hpp"

namespace splinevox {

/// Leaves out an effect without a trial of its own. @param why  noted, unless something is noted already
void leave_out(EffectChoice& choice, Effect effect, const char* why);

/// Whether effects stay, each judged beside all that do so far.
class Trials {
 public:
  /// @param brief  the fits are shorter than effects.steps of the run
  Trials(const Config& config, bool brief, const PictureStats& stats, TakenBy by, const Split& train,
         const TimeMap& time_map, const StillProof& proof, EffectChoice& out,
         const std::function<void(const EffectTrial&)>& on_trial);

  /// Whether there is something to fit to and something to compare with.
  bool possible() const { return halves_.usable(); }

  bool stays(Effect effect);
  /// Of an effect that there is no time to try: what can stand in for others is not taken on trust.
  bool stays_untried(Effect effect);

 private:
  /// What the other effects are judged beside. Gains that drift come after those that do not, and of a film,
  /// where light could stand in for them, beside a still world. Clocks, which are told by what moves, come
  /// after motion, and presence, which can stand in for anything, last.
  EffectSet beside() const;
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
  Ladder& elsewhere();
  /// In a film light could stand in for gains, and once they are there, take half of what is theirs
  /// (docs/experiments/effects.md). So they are judged beside a still world, and light goes where they stay.
  bool drifts();
  bool moves();
  /// Something changes: that is motion unless light alone explains it as well.
  bool moves_as_proved();
  bool moves_in(Ladder& by, bool whole);
  bool of_film() const;
  bool changes_alone(Effect effect);
  /// Whether matter comes and goes. In a film presence could stand in for anything, and of solid matter brief
  /// fits tell too little.
  bool comes_and_goes();
  /// Thin matter does, unless presence surely gains nothing. Where still cameras prove that it changes, it
  /// must surely lose more than so short a fit may.
  bool thin_comes_and_goes(int points);
  /// Solid matter does if presence gains and there is not as much of it at all times. Presence can also stand
  /// in for a motion that so short a fit has not found yet; then what changes keeps its amount.
  bool solid_comes_and_goes(int points);
  /// What presence asks for where it stays.
  void use_presence();

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

}  // namespace splinevox
