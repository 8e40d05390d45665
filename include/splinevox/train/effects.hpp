// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <iterator>
#include <optional>
#include <string>
#include <vector>

#include "splinevox/data/scene.hpp"
#include "splinevox/math/paired_gain.hpp"
#include "splinevox/train/config.hpp"

namespace splinevox {

/// What a model can do beyond a still and matte scene.
enum class Effect {
  motion,
  rigidity,   ///< needs motion
  view,       ///< the view rescale: has harmonics
  light,      ///< a gain per place and time
  background  ///< a colour learned behind opaque pictures: has harmonics
};
inline constexpr Effect kAllEffects[] = {Effect::motion, Effect::rigidity, Effect::view, Effect::light,
                                         Effect::background};

/// Some effects, and how far each goes. What is off has no lattice, no parameters and no line in the file.
class EffectSet {
 public:
  static constexpr int kOff = -1;

  bool has(Effect effect) const { return order(effect) != kOff; }
  /// Of its harmonics; 0 if it has none; kOff.
  int order(Effect effect) const { return order_[int(effect)]; }
  EffectSet with(Effect effect, int order = 0) const;
  EffectSet without(Effect effect) const;  ///< nor what needs it
  friend bool operator==(const EffectSet&, const EffectSet&) = default;

 private:
  static constexpr std::array<int, std::size(kAllEffects)> none() {
    std::array<int, std::size(kAllEffects)> out{};
    out.fill(kOff);
    return out;
  }
  std::array<int, std::size(kAllEffects)> order_ = none();
};

/// "motion", "rigidity", "view", "light", "background".
const char* to_string(Effect effect);
std::vector<std::string> effect_names();
/// None: there is no effect of that name.
std::optional<Effect> effect_named(const std::string& name);

EffectSet effects_of(const Config& config);
void apply(const EffectSet& effects, Config& config);
/// "motion, view", or "none".
std::string to_string(const EffectSet& effects);

/// A short fit with some effects.
struct EffectTrial {
  EffectSet effects;
  int points = 0;  ///< control points
  int steps = 0;
  double seconds = 0;        ///< of training
  std::int64_t bytes = 0;    ///< of the model's values
  std::vector<double> psnr;  ///< per held-out picture, dB
  double mean() const;
};

enum class EffectDecision { on, off, undecided, confounded };  ///< see choose_effects

/// What an effect gained over the same fit without it.
struct EffectVerdict {
  Effect effect;
  EffectSet with;  ///< the larger of the two fits
  EffectDecision decision;
  PairedGain gain;   ///< dB per held-out picture
  double where = 1;  ///< share of the pictures that the gain is of: of motion where only it explains what is
                     ///< seen, if it gains nothing on the whole
  std::optional<double> far = {};  ///< of motion in a film: share of what pictures show that is on the mean
                                   ///< far from where the canonical volume has it
  double time_ratio = 1;           ///< seconds of the fit with it over without
  double bytes_ratio = 1;          ///< size of the model with it over without
};

/// What the more control points of two fits of a stretch of time gained over the fewer.
struct PointsVerdict {
  int more = 0, fewer = 0;  ///< over the stretch
  PairedGain gain;          ///< dB per held-out picture
};

struct EffectChoice {
  EffectSet chosen;
  std::vector<EffectTrial> trials;
  std::vector<EffectVerdict> verdicts;  ///< on each effect that was judged
  int points = 0;  ///< control points over the whole time, before the configuration's halvings
  std::vector<PointsVerdict> points_verdicts;  ///< of a long sequence that moves: fewer points against more
  double view_told_by_time = 0;  ///< 0..1: how much of where pictures see the scene from their time tells, on
                                 ///< the whole or in a stretch; beyond 0.8 a film. 0 where it was not asked
  int held = 0;                  ///< pictures held out, each with its own time where times differ
  double seconds = 0;            ///< all of it
  std::string note;              ///< why nothing was tried, or what was settled without a trial; may be empty
};

/// Decides whether a scene moves, and if it does not whether its light changes, by fitting nested models for
/// a few hundred steps on small pictures and comparing them on pictures, and so on times, that no fit has
/// seen. The unit of evidence is the picture: rays of one picture err together, and a test over rays would
/// see effects that are not there. An effect is on if the lower bound of its gain exceeds effects.min_gain,
/// off if the upper bound falls short of it; in between it is undecided: light then stays off, the simpler
/// model, and motion goes by the mean, because a still scene with motion is only dearer and a moving one
/// without is ruined. Motion that gains nothing on the whole is looked at again where it alone explains what
/// the fits have seen: of a scene that mostly stands still. Each is judged beside all others, so that nothing
/// is taken for it that they explain.
///
/// Pictures may be a film: one camera that moves little while a piece of the curves lasts, and is elsewhere
/// in the next. What the view changes then changes with time as well, and motion and light explain it as a
/// camera passes by: a still scene gains by either, and looks wrong from anywhere else. So motion needs a
/// gain that no still scene has, or to take something far; without either, and light in any case, an effect
/// that gains is called confounded and stays off, the simpler model.
///
/// A background is there to be learned only behind opaque pictures. It is tried first, so that motion is not
/// taken for the fog that would stand in for it, and goes by its mean; too few views or steps to try anything
/// leave it on.
///
/// View dependence, rigidity, and light beside motion pay only late in training: fits this short see nothing
/// of the 2 dB that view dependence is worth on bouncingballs (docs/experiments.md). They stay as the
/// configuration has them.
///
/// A long sequence, of more than 240 moments, may repeat itself faster than the configuration's control
/// points can follow. Its middle 80 are fitted as a sequence of their own, with the configuration's points
/// and then with half as many pieces each time, until fewer pieces lose more than effects.min_gain on the
/// mean; twice the pieces that a unit of time then has are laid out over the whole, counting the halvings to
/// come. Such a stretch also has a say in whether the scene moves, which pictures far apart in time may not
/// show. Only for a basis whose pieces join smoothly by construction (Basis::smooth).
///
/// A fit takes effects.steps, so the choice does not depend on the machine: two or three fits (one more of
/// opaque pictures), 2 to 3 seconds on two cores. A run of too few steps for that to be a small part of it
/// tries nothing: every effect stays.
/// @param told  called after each fit; may be empty.
EffectChoice choose_effects(const Config& config, const Split& train, const TimeMap& time_map,
                            const std::function<void(const EffectTrial&)>& told = {});

}  // namespace splinevox
