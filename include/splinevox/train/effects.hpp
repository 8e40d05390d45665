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
#include "splinevox/math/metrics.hpp"
#include "splinevox/train/cameras.hpp"
#include "splinevox/train/config.hpp"

namespace splinevox {

/// What a model can do beyond a static and matte scene.
enum class Effect {
  motion,
  rigidity,      ///< needs motion
  view,          ///< the view rescale: has harmonics
  light,         ///< a gain per place and time
  background,    ///< a colour learned behind opaque pictures: has harmonics
  surroundings,  ///< static matter around the box of opaque pictures; needs a learned background
  exposure,      ///< a gain per camera of a rig and channel
  clock,         ///< a time offset per camera of a rig; needs motion
  presence,      ///< matter that comes and goes
  drift          ///< gains of cameras that change over time, also of the one of a film
};
inline constexpr Effect kAllEffects[] = {
    Effect::motion,       Effect::rigidity, Effect::view,  Effect::light,    Effect::background,
    Effect::surroundings, Effect::exposure, Effect::clock, Effect::presence, Effect::drift};

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

/// "motion", "rigidity", "view", "light", "background", "surroundings", "exposure", "clock", "presence",
/// "drift".
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
  CameraFits cameras;        ///< what it learned of them
  double mean() const;
};

enum class EffectDecision { on, off, undecided, confounded, proved };  ///< see choose_effects

/// What the pixels of cameras that stand still say about change, before any fit.
enum class StillVerdict {
  changed,    ///< something changes
  unchanged,  ///< every camera stands still, and nothing does
  unsure      ///< the fits alone decide
};
struct StillEvidence {
  StillVerdict verdict = StillVerdict::unsure;
  int cameras = 0;   ///< that stand still and have three moments or more
  int changing = 0;  ///< of them with a larger share than the threshold
  double share = 0;  ///< of a camera's pixels that change at some moment, mean over the cameras
  double threshold = 0;
};

/// What a still world, fitted to a film, cannot show of it (train/film/still_world.hpp); or what masks say of
/// pictures of any kind.
struct FilmEvidence {
  bool given = false;    ///< by masks: no still world was fitted
  double psnr = 0;       ///< of the still world in the pictures, dB; 0 where given
  double share = 0;      ///< of the pixels that it cannot show, or that masks say to move
  double coloured = 0;   ///< of the pixels whose hue it cannot show: no highlight changes that; given: share
  double threshold = 0;  ///< of both shares, from which they count
  int pictures = 0;      ///< that have pixels which it cannot show
  double seconds = 0;    ///< of the fit

  /// Whether there is anything that a still world cannot show: motion, or highlights.
  bool unexplained() const { return share >= threshold; }
  /// Whether that can only be motion. A bright highlight ends some channels before others: hue in one of
  /// twenty such pixels or fewer says nothing.
  bool moves() const { return coloured >= threshold && coloured >= 0.05 * share; }
};

/// How much later than their times say the pictures of a camera are, by a model that took their times as they
/// are; intervals between its pictures.
struct ClockDoubt {
  int camera = 0;     ///< of CameraFits
  PairedGain offset;  ///< over the median of all cameras; its pictures are what differs
};

/// What an effect gained over the same fit without it.
struct EffectVerdict {
  Effect effect;
  EffectSet with;  ///< the larger of the two fits
  EffectDecision decision;
  PairedGain gain;   ///< dB per held-out picture
  double where = 1;  ///< share of the pictures that the gain is of. Motion that gains nothing on the whole is
                     ///< compared where only it explains the training pictures
  std::optional<double> spread = {};  ///< of exposure: how far the gains of the cameras are apart; of drift:
                                      ///< those of each camera. The standard deviation of their logarithms
  std::optional<double> apart = {};   ///< of exposure, or drift of a rig, where motion hides what it gains:
                                      ///< how far the brightness of the pictures is apart, as spread
  std::optional<double> whole = {};   ///< of drift in a film: how far pictures are brighter or darker as a
                                      ///< whole, not in parts, in [0, 1]
  std::vector<ClockDoubt> clocks = {};      ///< of clock: of each camera
  std::optional<double> far = {};           ///< of motion in a film: share of the visible cells whose mean
                                            ///< displacement is large
  std::optional<double> least_matter = {};  ///< of presence of solid matter that gains: how much of what
                                            ///< changes is there when there is least, as a share of the most
  double time_ratio = 1;                    ///< seconds of the fit with it over without
  double bytes_ratio = 1;                   ///< size of the model with it over without
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
  std::vector<PointsVerdict> points_verdicts;    ///< of a long sequence that moves: fewer points against more
  std::optional<double> view_told_by_time = {};  ///< 0..1: how well the time of a picture tells its viewing
                                                 ///< direction; beyond 0.8 a film. None: not asked
  std::optional<StillEvidence> still = {};       ///< none: no camera stands still
  std::optional<FilmEvidence> film = {};         ///< none: no film, or motion was not wanted
  std::vector<CoarseMask> moving = {};           ///< of a film that moves: what does, in each training frame
  int held_out = 0;       ///< pictures held out, each with its own time where times differ
  double seconds = 0;     ///< all of it
  std::string note;       ///< why nothing was tried, or what was settled without a trial; may be empty
  bool on_trust = false;  ///< nothing was tried: what is chosen is the preset's but for presence and drift
};

/// Decides whether a scene moves, and if it does not, whether its light changes.
///
/// Nested models are fitted for a few hundred steps on small pictures. They are compared on held-out
/// pictures, and so at held-out times. The unit of evidence is the picture, because rays of one picture err
/// together. A test over rays would find effects that are not there.
///
/// | the gain is | decision |
/// | --- | --- |
/// | above effects.min_gain with its lower bound | on |
/// | below effects.min_gain with its upper bound | off |
/// | in between | undecided |
///
/// Undecided light stays off: the simpler model. Undecided motion goes by the mean. A static scene with
/// motion only costs more, and a moving one without is ruined. Motion that gains nothing on the whole is
/// compared again where it alone explains the pictures: that finds what moves in a mostly static scene. Each
/// effect is judged beside all others, so that none is taken for what another explains.
///
/// Video: one camera that hardly moves within a piece of the curves and is elsewhere in the next. There the
/// view changes with time, and motion and light can explain what the view changes. A static scene gains by
/// them too, and looks wrong from anywhere else. So motion needs a gain that no static scene has, or must
/// displace something far. Otherwise an effect that gains is called confounded and stays off. Light in a
/// video always is.
///
/// Cameras that stand still need no fit to tell change: their pixels over time are compared with the noise of
/// their pictures first. Where two cameras prove change (or the only one), something moves or its light does.
/// Fits are then compared on those pixels of held-out pictures that differ from their camera's still picture.
/// Motion stays, as proved where its gain is not clear, unless it gains nothing there and light alone does.
/// If every camera stands still and nothing changes, what changes over time is left out without a fit.
///
/// A background can be learned behind opaque pictures only. It is tried first, or motion would be taken for
/// the fog that stands in for it. It goes by its mean. With too few views or steps for trials it stays on.
///
/// Of a rig of cameras exposures are tried before all else, because gains blur every other comparison. They
/// stay if they are sure to gain and the gains differ by 3%: what a gain gives to other pictures of its own
/// camera may be what the model lacks there. So are gains that drift, next, also of the one camera of a film.
/// They are used only if that was shown. Clocks are tried after motion, by the colour errors along what
/// the model changes in time (ClockDoubt). A camera must be sure to be off by a fifth of its interval.
///
/// View dependence, rigidity, and light beside motion pay late in training, so fits this short cannot judge
/// them (docs/experiments/effects.md, "Which effects can a fit of 200 steps judge?"). They stay as the
/// configuration has them.
///
/// A long sequence has more than 240 moments. It may repeat itself faster than the configuration's control
/// points can follow. So its middle 80 moments are fitted as a sequence of their own:
///   1. with the configuration's points,
///   2. with half as many pieces each time, until fewer pieces lose more than effects.min_gain on the mean,
///   3. twice the fewest that do not are laid out over the whole, as many a unit of time, less halvings to
///      come; the configuration's own pieces where all of them are needed. A model file limits their number
///      (kMostGrids).
/// Such a stretch also has a say in whether the scene moves. It is asked for bases alone whose pieces join
/// smoothly by construction (Basis::smooth).
///
/// A fit takes effects.steps, so what it shows does not depend on the machine. There are three fits of
/// pictures with alpha that no rig took, and about ten of a rig: 5 to 90 seconds on two slow cores. A shorter
/// run makes shorter fits, and those leave out only what surely gains nothing. Below 100 steps a fit (800 of
/// the run, or 12.5 seconds) nothing is tried and every effect stays but presence and drift, which can stand
/// in for others. Where a machine is so slow that trials would take more than effects.most_time of what is
/// left of run.max_time, the last ones are left out. What they would judge stays but for drift, and presence
/// of solid matter. The note says each.
///
/// In a film of one camera on its way, motion stands in for what a coarse lattice cannot show of a static
/// scene. So there a still world is fitted first, and the scene moves if there is something that it cannot
/// show (FilmEvidence). Where masks say what moves (Frame::moving), they say it instead, of any pictures.
/// @param on_trial  called after each fit; may be empty. @param on_film  once a film was looked at; may be
/// empty. @param by_clock  whether effects.most_time counts
/// @param used  seconds of run.max_time that are gone: trials may take their share of what is left
EffectChoice choose_effects(const Config& config, const Split& train, const TimeMap& time_map,
                            const std::function<void(const EffectTrial&)>& on_trial = {},
                            const std::function<void(const FilmEvidence&)>& on_film = {},
                            bool by_clock = true, double used = 0);

}  // namespace splinevox
