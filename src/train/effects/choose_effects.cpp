// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <utility>

#include "core/parallel.hpp"
#include "splinevox/math/metrics.hpp"
#include "splinevox/render/render_image.hpp"
#include "splinevox/train/effects.hpp"
#include "splinevox/train/trainer.hpp"
#include "train/by_time.hpp"
#include "train/effects/effect_table.hpp"
#include "train/effects/film.hpp"
#include "train/effects/fit_config.hpp"
#include "train/effects/halves.hpp"
#include "train/effects/moving_cells.hpp"
#include "train/effects/rig.hpp"
#include "train/learn_cameras.hpp"
#include "train/start.hpp"

namespace splinevox {
namespace {

constexpr int kFewestViews = 8;      // to hold some out
constexpr float kExplained = 0.02f;  // of brightness, that motion explains at a place where it is needed
constexpr int kFewestPixels = 8;     // of a picture, to compare it there
constexpr double kClearGain = 0.5;  // dB there: static scenes come to 0.1 at most, those of which a twentieth
                                    // moves to 0.9 and more (docs/experiments.md)
constexpr double kFilm = 0.8;       // view_told_by_time from which pictures are a video
constexpr double kFilmGain = 1.4;   // dB, of motion in a video: a static scene gains about 1 at most by
                                    // bending a little with the camera (docs/experiments/effects.md)
constexpr double kFarGain = 0.3;    // dB, if it displaces something far, which bending does not:
constexpr float kFar = 3;           // voxels of a fit's lattice, of 40 to the box
constexpr double kFarShare = 0.0015;   // of the visible cells
constexpr double kLeastSpread = 0.03;  // of gains: less is not seen, and a fit this short errs as much
constexpr double kShortest = 8;  // steps of training for one of a fit, on coarser lattices and with fewer
                                 // rays: all fits cost under a tenth
constexpr double kShortestTime = 25;  // seconds of training, for the same reason

/// The pixels that a mask has, in a row.
Image picked(const Image& picture, const Image& mask) {
  Image out(int(std::count(mask.data.begin(), mask.data.end(), 1.0f)), 1, picture.channels);
  float* to = out.data.data();
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x)
      if (*mask.pixel(x, y) != 0) to = std::copy_n(picture.pixel(x, y), picture.channels, to);
  return out;
}

/// Fits by set of effects, each made once, and the comparisons between them.
class Ladder {
 public:
  /// @param level  of one comparison
  Ladder(const Config& config, float level, const Halves& halves, const TimeMap& time_map, EffectChoice& out,
         const std::function<void(const EffectTrial&)>& on_trial)
      : config_(config),
        level_(level),
        halves_(halves),
        time_map_(time_map),
        out_(out),
        first_(out.trials.size()),
        on_trial_(on_trial) {}

  /// Fits that are made already are not made again.
  EffectTrial fit(const EffectSet& effects, int points) {
    if (const int made = find(effects, points); made >= 0) return out_.trials[first_ + std::size_t(made)];
    Config c = fit_config(config_, effects);
    c.motion.points = points;
    Trainer trainer(c, halves_.fitted, time_map_);
    EffectTrial trial;
    trial.effects = effects;
    trial.points = points;
    while (!trainer.done()) trial.steps = int(trainer.step().step);
    trial.seconds = trainer.seconds();
    trial.cameras = trainer.cameras();
    fits_.push_back({trainer.model(), {}});
    const VoxelModel& model = fits_.back().model;
    trial.bytes = std::int64_t(model.radiance.raw.values.size() * sizeof(float));
    for (const Channels& level : model.motion.levels)
      trial.bytes += std::int64_t(level.values.size() * sizeof(float));
    Renderer renderer(model);
    for (const Frame& f : halves_.held_out.frames) {
      fits_.back().pictures.push_back(shown_by(trial.cameras, f, renderer));
      trial.psnr.push_back(capped_psnr(
          psnr(fits_.back().pictures.back(), composite(f.image, model.background.color), f.ignored)));
    }
    out_.trials.push_back(std::move(trial));
    if (on_trial_) on_trial_(out_.trials.back());
    return out_.trials.back();
  }
  /// Compares `with` to the same without the effect.
  EffectVerdict judge(Effect effect, const EffectSet& with) {
    const EffectTrial more = fit(with, config_.motion.points),
                      less = fit(with.without(effect), config_.motion.points);
    EffectVerdict v{effect, with, EffectDecision::undecided, gain(more, less)};
    decide(v);
    v.time_ratio = more.seconds / less.seconds;
    v.bytes_ratio = double(more.bytes) / double(less.bytes);
    out_.verdicts.push_back(v);
    return v;
  }
  /// Compares the fit with motion that judge(Effect::motion, all) made to the static one. The comparison is
  /// on held-out pictures, where only motion explains the training pictures. In so short a fit motion costs
  /// the static part more than it gives to a small moving one. A clear gain becomes the verdict on motion.
  void judge_where_needed(const EffectSet& all) {
    const int points = config_.motion.points;
    const Fit &moving = fits_[std::size_t(find(all, points))],
              &still = fits_[std::size_t(find(all.without(Effect::motion), points))];
    const BitGrid near = dilate(moving_cells(moving.model, still.model, halves_.fitted, kExplained,
                                             out_.trials[first_ + std::size_t(find(all, points))].cameras));
    const std::vector<Frame>& held_out = halves_.held_out.frames;
    std::vector<Image> where(held_out.size());
    parallel_for(int(held_out.size()),
                 [&](int f) { where[f] = shows_cells(moving.model, near, held_out[f]); });
    std::vector<double> gains;
    double compared = 0, pixels = 0;
    for (std::size_t f = 0; f < held_out.size(); ++f) {
      const Image truth = picked(composite(held_out[f].image, moving.model.background.color), where[f]);
      compared += truth.width;
      pixels += double(where[f].data.size());
      if (truth.width < kFewestPixels) continue;
      const auto quality = [&](const Fit& fit) {
        return capped_psnr(psnr(picked(fit.pictures[f], where[f]), truth));
      };
      gains.push_back(quality(moving) - quality(still));
    }
    if (int(gains.size()) < kFewestViews / 2) return;
    const PairedGain there = paired_gain(gains, level_);
    if (there.mean < kClearGain) return;
    EffectVerdict& v = out_.verdicts.back();
    v.gain = there;
    v.where = compared / pixels;
    decide(v);
  }
  /// Whether the training pictures of the fits are a video: a camera that hardly moves within a piece of the
  /// curves and is elsewhere in the next. @pre a fit was made
  bool film() {
    const double share =
        view_told_by_time(halves_.fitted, fits_.front().model.box.center(),
                          1.0 / basis_of(config_.motion.basis).pieces(config_.motion.points));
    out_.view_told_by_time = std::max(out_.view_told_by_time, share);
    return share > kFilm;
  }
  /// Judges anew, as of a video, what judge(Effect::motion, all) found. Returns whether the scene moves.
  bool judge_film(const EffectSet& all) {
    const VoxelModel& moving = fits_[std::size_t(find(all, config_.motion.points))].model;
    EffectVerdict& v = out_.verdicts.back();
    v.far = share_far(moving, halves_.fitted, kFar * moving.radiance.raw.topology->lattice.spacing);
    const double least = config_.effects.min_gain;
    const bool moves = v.gain.mean > std::max(least, *v.far > kFarShare ? kFarGain : kFilmGain);
    if (!moves && v.gain.mean > least) v.decision = EffectDecision::confounded;
    return moves;
  }
  /// Judges whether cameras have gains of their own. What a gain gives to held-out pictures of its own camera
  /// may be what the model lacks there, so gains must differ as well.
  EffectVerdict judge_exposure(const EffectSet& all) {
    judge(Effect::exposure, all);
    EffectVerdict& v = out_.verdicts.back();
    v.spread = spread_of(fit(all, config_.motion.points).cameras);
    if (v.decision == EffectDecision::on && *v.spread < kLeastSpread) v.decision = EffectDecision::off;
    return v;
  }
  /// Judges whether cameras have clocks of their own, by the fit without them. @param train  the whole split
  EffectVerdict judge_clock(const EffectSet& all, const Split& train) {
    const EffectTrial less = fit(all.without(Effect::clock), config_.motion.points);
    out_.verdicts.push_back(
        splinevox::judge_clock(all, fits_[std::size_t(find(less.effects, less.points))].model, less.cameras,
                               fit_config(config_, less.effects), train, time_map_, double(level_)));
    return out_.verdicts.back();
  }
  /// Compares two numbers of control points.
  PointsVerdict judge(const EffectSet& effects, int more, int fewer) {
    out_.points_verdicts.push_back({more, fewer, gain(fit(effects, more), fit(effects, fewer))});
    return out_.points_verdicts.back();
  }

 private:
  /// What a trial leaves for comparisons.
  struct Fit {
    VoxelModel model;
    std::vector<Image> pictures;  ///< of the held-out frames
  };
  void decide(EffectVerdict& v) const {
    v.decision = v.gain.lo > config_.effects.min_gain   ? EffectDecision::on
                 : v.gain.hi < config_.effects.min_gain ? EffectDecision::off
                                                        : EffectDecision::undecided;
  }
  /// Index among its own trials, -1: not made yet.
  int find(const EffectSet& effects, int points) const {
    for (std::size_t i = first_; i < out_.trials.size(); ++i)
      if (out_.trials[i].effects == effects && out_.trials[i].points == points) return int(i - first_);
    return -1;
  }
  PairedGain gain(const EffectTrial& more, const EffectTrial& less) const {
    std::vector<double> gains;
    for (std::size_t i = 0; i < more.psnr.size(); ++i) gains.push_back(more.psnr[i] - less.psnr[i]);
    return paired_gain(gains, level_);
  }

  const Config& config_;
  const float level_;
  const Halves& halves_;
  const TimeMap& time_map_;
  EffectChoice& out_;
  std::vector<Fit> fits_;  ///< of its own trials
  std::size_t first_;      ///< of this ladder's own trials among out_'s
  const std::function<void(const EffectTrial&)>& on_trial_;
};

/// Control points over the whole time that a stretch asks for: half the pieces, as long as the mean picture
/// does not lose by it, and then twice as many, because fits this short do not come to what the last pieces
/// are for. Halvings still to come are left out.
int points_for(Ladder& ladder, const EffectSet& effects, const Config& config, double stretch) {
  const Basis& basis = basis_of(config.motion.basis);
  int pieces = basis.pieces(config.motion.points), twice = pieces;
  while (pieces > 1 &&
         !(ladder.judge(effects, basis.points_of(pieces), basis.points_of(pieces / 2)).gain.mean >
           config.effects.min_gain))
    twice = std::exchange(pieces, pieces / 2);
  const int halvings = basis.halves() ? int(config.motion.halve_start.size()) : 0;
  return std::clamp(basis.points_of(int(std::ceil(std::ldexp(twice / stretch, -halvings)))),
                    config.motion.points, basis.most_points(halvings));
}

/// Whether effects stay, each judged beside all that do so far.
class Trials {
 public:
  Trials(const Config& config, const Split& train, const TimeMap& time_map, EffectChoice& out,
         const std::function<void(const EffectTrial&)>& on_trial)
      : config_(config),
        train_(train),
        time_map_(time_map),
        out_(out),
        on_trial_(on_trial),
        level_(config.effects.level / float(most_comparisons(out.chosen))),
        halves_(divide(train, {frames_by_time(train)})),
        whole_(config, level_, halves_, time_map, out, on_trial) {
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
      case Trial::exposure:
        return whole_.judge_exposure(beside()).decision == EffectDecision::on;
      case Trial::clock:
        clocks_ = true;
        return !out_.chosen.has(Effect::motion) ||
               whole_.judge_clock(out_.chosen, train_).decision == EffectDecision::on;
      case Trial::motion:
        return moves();
      case Trial::alone:
        return out_.chosen.has(Effect::motion) || changes_alone(effect);
    }
    return true;
  }

 private:
  /// What the other effects are judged beside. Clocks, which are told by what moves, come after motion.
  EffectSet beside() const { return clocks_ ? out_.chosen : out_.chosen.without(Effect::clock); }
  bool gains(const EffectVerdict& v) const { return v.gain.mean > config_.effects.min_gain; }

  bool moves() {
    bool found = moves_in(whole_, true);
    const std::optional<Stretch> stretch = middle_stretch(train_);
    const Basis& basis = basis_of(config_.motion.basis);
    if (!stretch || basis.smooth <= 0 || basis.pieces(config_.motion.points) <= 1) return found;
    const Halves parts = divide(train_, *stretch);
    if (!parts.usable()) return found;
    Ladder near(config_, level_, parts, time_map_, out_, on_trial_);
    if (moves_in(near, false)) {
      found = true;
      out_.points = points_for(near, beside(), config_, stretch->length);
    }
    return found;
  }
  bool moves_in(Ladder& by, bool whole) {
    const EffectSet all = beside();
    // Undecided motion goes by its mean, and what is decided has its mean on the same side of min_gain.
    const bool enough = gains(by.judge(Effect::motion, all));
    if (by.film()) return by.judge_film(all);
    if (whole && !enough) by.judge_where_needed(all);
    return gains(out_.verdicts.back());
  }
  bool changes_alone(Effect effect) {
    const bool on = whole_.judge(effect, beside()).decision == EffectDecision::on;
    if (!on || !whole_.film()) return on;
    out_.verdicts.back().decision = EffectDecision::confounded;
    return false;
  }

  const Config& config_;
  const Split& train_;
  const TimeMap& time_map_;
  EffectChoice& out_;
  const std::function<void(const EffectTrial&)>& on_trial_;
  const float level_;
  const Halves halves_;
  Ladder whole_;
  bool clocks_ = false;  ///< their turn has come
};

/// Why nothing can be tried out in this configuration; empty: it can.
std::string untried(const Config& config) {
  if (config.effects.steps == 0) return "effects.steps is 0: nothing was tried";
  const bool timed = config.run.max_time > 0;
  if (timed ? config.run.max_time < kShortestTime : config.run.max_steps < kShortest * config.effects.steps)
    return "too short a run to try effects out: every effect of the preset stays";
  return {};
}

bool one_moment(const Split& train) {
  const auto [first, last] =
      std::minmax_element(train.frames.begin(), train.frames.end(),
                          [](const Frame& a, const Frame& b) { return a.time < b.time; });
  return first->time == last->time;
}

}  // namespace

EffectChoice choose_effects(const Config& config, const Split& train, const TimeMap& time_map,
                            const std::function<void(const EffectTrial&)>& on_trial) {
  const auto start = std::chrono::steady_clock::now();
  EffectChoice out;
  out.chosen =
      learnable_in(effects_of(config), !picture_stats(train).see_through, !rig_of(train).cameras.empty());
  out.points = config.motion.points;
  out.note = untried(config);
  if (!out.note.empty()) return out;
  if (one_moment(train)) {
    for (const Effect e : kAllEffects)
      if (facts_of(e).moving()) out.chosen = out.chosen.without(e);
    out.note = "every view is of one time: nothing can be seen to change";
  }
  if (int(train.frames.size()) < kFewestViews) {
    if (out.note.empty()) out.note = "too few views to hold some out: every effect of the preset stays";
    return out;
  }
  const std::vector<Effect> tried = in_turn(out.chosen);
  if (tried.empty()) return out;
  Trials trials(config, train, time_map, out, on_trial);
  if (!trials.possible()) {
    out.note = "masks leave too little of small pictures: every effect of the preset stays";
    return out;
  }
  for (const Effect e : tried)
    if (!trials.stays(e)) out.chosen = out.chosen.without(e);
  // Of a long sequence the whole and a stretch may differ: what either finds is used.
  for (EffectVerdict& v : out.verdicts)
    if (v.decision == EffectDecision::confounded && out.chosen.has(v.effect))
      v.decision = EffectDecision::undecided;
  out.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return out;
}

}  // namespace splinevox
