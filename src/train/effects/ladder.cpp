// SPDX-License-Identifier: Apache-2.0
#include "train/effects/ladder.hpp"

#include <algorithm>
#include <optional>

#include "core/parallel.hpp"
#include "splinevox/math/metrics.hpp"
#include "splinevox/render/render_image.hpp"
#include "splinevox/train/trainer.hpp"
#include "train/effects/film.hpp"
#include "train/effects/fit_config.hpp"
#include "train/effects/least_matter.hpp"
#include "train/effects/moving_cells.hpp"

namespace splinevox {
namespace {

constexpr float kExplained = 0.02f;  // units of brightness, that motion explains where it is needed
constexpr double kClearGain = 0.5;  // dB there: static scenes come to 0.1 at most, those of which a twentieth
                                    // moves to 0.9 and more (docs/experiments.md)
constexpr double kFilmGain = 1.4;   // dB, of motion in a video: a static scene gains about 1 at most by
                                    // bending a little with the camera (docs/experiments/effects.md)
constexpr double kFarGain = 0.3;    // dB, if it displaces something far, which bending does not:
constexpr float kFar = 3;           // voxels of a fit's lattice, of 40 to the box
constexpr double kFarShare = 0.0015;   // of the visible cells
constexpr double kLeastSpread = 0.03;  // of gains: less is not seen, and a fit this short errs as much
constexpr double kClearSpread = 0.06;  // of gains that nothing is known to gain by
// CameraSpread. Exposures that agree come to 0.03 with alpha, those that are steady to 0
// (docs/experiments/effects.md).
constexpr double kLeastApart = 0.035, kLeastDrift = 0.04;

// whole_share of a film's exposures: glossy scenes that are lit steadily come to 0.92, drifts of a quarter to
// 0.94 and more (docs/experiments/effects.md).
constexpr double kLeastWhole = 0.93;

}  // namespace

EffectTrial Ladder::fit(const EffectSet& effects, int points) {
  if (const int made = find(effects, points); made >= 0) return out_.trials[fits_[std::size_t(made)].trial];
  Config c = fit_config(config_, effects);
  c.motion.points = points;
  Trainer trainer(c, halves_.fitted, time_map_);
  EffectTrial trial;
  trial.effects = effects;
  trial.points = points;
  while (!trainer.done()) trial.steps = int(trainer.step().step);
  trial.seconds = trainer.seconds();
  trial.cameras = trainer.cameras();
  fits_.push_back({trainer.model(), {}, out_.trials.size()});
  const VoxelModel& model = fits_.back().model;
  trial.bytes =
      std::int64_t((model.radiance.raw.values.size() + model.surroundings.raw.values.size()) * sizeof(float));
  for (const Channels& level : model.motion.levels)
    trial.bytes += std::int64_t(level.values.size() * sizeof(float));
  Renderer renderer(model);
  for (const Frame& f : halves_.held_out.frames) {
    fits_.back().pictures.push_back(shown_by(trial.cameras, f, model, renderer));
    trial.psnr.push_back(capped_psnr(
        psnr(fits_.back().pictures.back(), composite(f.image, model.background.color), f.ignored)));
  }
  out_.trials.push_back(std::move(trial));
  if (on_trial_) on_trial_(out_.trials.back());
  return out_.trials.back();
}

EffectVerdict Ladder::judge(Effect effect, const EffectSet& with, int points) {
  if (points == 0) points = config_.motion.points;
  const EffectTrial more = fit(with, points), less = fit(with.without(effect), points);
  EffectVerdict v{effect, with, EffectDecision::undecided, gain(more, less)};
  decide(v);
  v.time_ratio = more.seconds / less.seconds;
  v.bytes_ratio = double(more.bytes) / double(less.bytes);
  out_.verdicts.push_back(v);
  return v;
}

void Ladder::judge_where_needed(const EffectSet& all) {
  const int points = config_.motion.points;
  const Fit &moving = fits_[std::size_t(find(all, points))],
            &still = fits_[std::size_t(find(all.without(Effect::motion), points))];
  const BitGrid near = dilate(moving_cells(moving.model, still.model, halves_.fitted, kExplained * unit_,
                                           out_.trials[moving.trial].cameras));
  const std::vector<Frame>& held_out = halves_.held_out.frames;
  std::vector<Image> where(held_out.size());
  parallel_for(int(held_out.size()), [&](int f) { where[f] = shows_cells(moving.model, near, held_out[f]); });
  const auto there = gains_there(where, all, Effect::motion);
  if (!there) return;
  const PairedGain gain = paired_gain(there->gains, level_);
  if (gain.mean < kClearGain) return;
  EffectVerdict& v = out_.verdicts.back();
  v.gain = gain;
  v.where = there->share;
  decide(v);
}

EffectVerdict Ladder::judge_where_changing(Effect effect, const EffectSet& with,
                                           const std::vector<Image>& changing, int points) {
  judge(effect, with, points);
  EffectVerdict& v = out_.verdicts.back();
  if (const auto there = gains_there(changing, with, effect, points)) {
    v.gain = paired_gain(there->gains, level_);
    v.where = there->share;
    decide(v);
  }
  return v;
}

bool Ladder::judge_film(const EffectSet& all, bool proved) {
  EffectVerdict& v = out_.verdicts.back();
  const double least = config_.effects.min_gain;
  if (proved) {
    if (!(v.gain.mean > least)) v.decision = EffectDecision::proved;
    return true;
  }
  const VoxelModel& moving = fits_[std::size_t(find(all, config_.motion.points))].model;
  v.far = share_far(moving, halves_.fitted, kFar * moving.radiance.raw.topology->lattice.spacing);
  const bool moves = v.gain.mean > std::max(least, *v.far > kFarShare ? kFarGain : kFilmGain);
  if (!moves && v.gain.mean > least) v.decision = EffectDecision::confounded;
  return moves;
}

double Ladder::least_matter(const EffectSet& effects, int points) const {
  return splinevox::least_matter(fits_[std::size_t(find(effects, points))].model);
}

EffectVerdict Ladder::judge_gains(Effect effect, const EffectSet& all, double (*spread)(const CameraFits&)) {
  judge(effect, all);
  EffectVerdict& v = out_.verdicts.back();
  const CameraFits learned = fit(all, config_.motion.points).cameras;
  v.spread = spread(learned);
  if (v.decision == EffectDecision::on && *v.spread < kLeastSpread) v.decision = EffectDecision::off;
  if (std::none_of(learned.cameras.begin(), learned.cameras.end(),
                   [](const CameraFit& c) { return c.trained; }))
    v.decision = EffectDecision::undecided;  // masks left no camera three moments: both fits are the same
  return v;
}

Ladder::Neutral Ladder::without_gains(const EffectSet& effects) const {
  const VoxelModel& model = fits_[std::size_t(find(effects, config_.motion.points))].model;
  Renderer renderer(model);
  Neutral out{model.background.color, {}};
  for (const Frame& f : halves_.held_out.frames) out.pictures.push_back(shown_by({}, f, model, renderer));
  return out;
}

void Ladder::ask_brightness(EffectVerdict& v, double least_spread, double CameraSpread::*apart,
                            double least) const {
  // What stands still behind opaque pictures tells by itself.
  if (v.decision != EffectDecision::undecided || *v.spread < least_spread || v.with.has(Effect::background))
    return;
  const Neutral less = without_gains(v.with.without(v.effect));
  v.apart = cameras_spread(halves_.held_out.frames, less.background, less.pictures, unit_).*apart;
  if (*v.apart > least) v.decision = EffectDecision::on;
}

EffectVerdict Ladder::judge_exposure(const EffectSet& all) {
  judge_gains(Effect::exposure, all, spread_of);
  EffectVerdict& v = out_.verdicts.back();
  ask_brightness(v, kClearSpread, &CameraSpread::apart, kLeastApart);
  return v;
}

EffectVerdict Ladder::judge_drift(const EffectSet& all, bool film) {
  judge_gains(Effect::drift, all, drift_of);
  EffectVerdict& v = out_.verdicts.back();
  if (film) {
    const Neutral with = without_gains(all);
    v.whole = whole_share(halves_.held_out.frames, with.background, with.pictures, unit_);
    if (v.decision == EffectDecision::on && *v.whole < kLeastWhole) v.decision = EffectDecision::confounded;
  } else {
    ask_brightness(v, kLeastSpread, &CameraSpread::drift, kLeastDrift);
  }
  return v;
}

EffectVerdict Ladder::judge_clock(const EffectSet& all, const Split& train) {
  const EffectTrial less = fit(all.without(Effect::clock), config_.motion.points);
  out_.verdicts.push_back(
      splinevox::judge_clock(all, fits_[std::size_t(find(less.effects, less.points))].model, less.cameras,
                             fit_config(config_, less.effects), train, time_map_, double(level_)));
  return out_.verdicts.back();
}

PointsVerdict Ladder::judge(const EffectSet& effects, int more, int fewer) {
  out_.points_verdicts.push_back({more, fewer, gain(fit(effects, more), fit(effects, fewer))});
  return out_.points_verdicts.back();
}

void Ladder::decide(EffectVerdict& v) const {
  v.decision = v.gain.lo > config_.effects.min_gain   ? EffectDecision::on
               : v.gain.hi < config_.effects.min_gain ? EffectDecision::off
                                                      : EffectDecision::undecided;
}

int Ladder::find(const EffectSet& effects, int points) const {
  for (std::size_t i = 0; i < fits_.size(); ++i)
    if (const EffectTrial& t = out_.trials[fits_[i].trial]; t.effects == effects && t.points == points)
      return int(i);
  return -1;
}

PairedGain Ladder::gain(const EffectTrial& more, const EffectTrial& less) const {
  std::vector<double> gains;
  for (std::size_t i = 0; i < more.psnr.size(); ++i) gains.push_back(more.psnr[i] - less.psnr[i]);
  return paired_gain(gains, level_);
}

std::optional<GainsWhere> Ladder::gains_there(const std::vector<Image>& where, const EffectSet& with,
                                              Effect effect, int points) const {
  if (points == 0) points = config_.motion.points;
  const Fit &more = fits_[std::size_t(find(with, points))],
            &less = fits_[std::size_t(find(with.without(effect), points))];
  return gains_where(where, halves_.held_out.frames, more.model.background.color, more.pictures,
                     less.pictures);
}

}  // namespace splinevox
