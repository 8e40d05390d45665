// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <utility>

#include "core/parallel.hpp"
#include "splinevox/data/image_read.hpp"
#include "splinevox/math/metrics.hpp"
#include "splinevox/render/render_image.hpp"
#include "splinevox/train/effects.hpp"
#include "splinevox/train/trainer.hpp"
#include "train/by_time.hpp"
#include "train/config/loss_terms.hpp"
#include "train/effects/film.hpp"
#include "train/effects/moving_cells.hpp"
#include "train/learn_background.hpp"

namespace splinevox {
namespace {

constexpr int kPictureSize = 128;    // pixels, at most: what is asked is coarse
constexpr int kMostHeld = 20;        // pictures
constexpr int kMostSeen = 60;        // by the fits
constexpr int kFewestViews = 8;      // to hold some back
constexpr int kComparisons = 3;      // at most, and one more where a background is tried
constexpr float kExplained = 0.02f;  // of brightness, that motion explains at a place where it is needed
constexpr int kFewestPixels = 8;     // of a picture, to compare it there
constexpr double kClearGain = 0.5;   // dB there: still scenes come to 0.1 at most, those of which a twentieth
                                     // moves to 0.9 and more (docs/experiments.md)
constexpr double kFilm = 0.8;        // of where pictures see the scene from is told by their time
constexpr double kFilmGain = 1.4;  // dB, of motion in a film: a still scene gains about 1 at most by bending
                                   // a little with the camera (docs/experiments.md, "Films")
constexpr double kFarGain = 0.3;   // dB, if it takes something far, which bending does not:
constexpr float kFar = 3;          // voxels of a fit's lattice, of 40 to the box
constexpr double kFarShare = 0.0015;  // of what pictures show
constexpr double kShortest = 8;  // steps of training for one of a fit, on coarser lattices and with fewer
                                 // rays: all fits cost under a tenth
constexpr double kShortestTime = 25;  // seconds of training, for the same reason

constexpr std::size_t kStretch = 80;  // moments of a long sequence that tell how many control points it needs
constexpr std::size_t kLong = 3 * kStretch;  // moments

/// Training frames divided in two: what the fits see, and what they are compared on.
struct Halves {
  Split seen, held;
};

/// Frames of a split in order of time, as a sequence of its own: (time - start) / length.
struct Stretch {
  std::vector<int> frames;
  double start = 0, length = 1;
};

/// The middle kStretch moments of a long sequence with every picture of them; none of a short one.
std::optional<Stretch> middle_stretch(const Split& train) {
  Stretch out{frames_by_time(train)};
  std::vector<double> moments;
  for (const int f : out.frames) moments.push_back(train.frames[f].time);
  moments.erase(std::unique(moments.begin(), moments.end()), moments.end());
  if (moments.size() <= kLong) return {};
  const std::size_t first = (moments.size() - kStretch) / 2;
  const double start = moments[first], end = moments[first + kStretch - 1];
  std::erase_if(out.frames,
                [&](int f) { return train.frames[f].time < start || train.frames[f].time > end; });
  out.start = start, out.length = end - start;
  return out;
}

/// Every fifth frame is held back, or fewer of a long sequence, and the frames in between are seen, or a
/// share of them that is even in time: what is asked is coarse, and every frame costs its hull and its
/// occupancy.
Halves divide(const Split& train, const Stretch& stretch) {
  const int n = int(stretch.frames.size()), held = std::min(kMostHeld, n / 5),
            seen = std::min(kMostSeen, n - held);
  std::vector<char> hold(n, 0);
  for (int i = 0; i < held; ++i) hold[(2 * i + 1) * n / (2 * held)] = 1;
  std::vector<int> kept, others, chosen;
  for (int i = 0; i < n; ++i) (hold[i] ? kept : others).push_back(stretch.frames[i]);
  for (int i = 0; i < seen; ++i) chosen.push_back(others[std::size_t(i) * others.size() / seen]);
  const auto take = [&](const std::vector<int>& frames, Split& out) {
    out.name = train.name;
    out.frames.resize(frames.size());
    parallel_for(int(frames.size()), [&](int i) {
      const Frame& f = train.frames[frames[i]];
      const int factor =
          std::max(1, (std::max(f.camera.width, f.camera.height) + kPictureSize - 1) / kPictureSize);
      out.frames[i] = {f.name, area_downscale(f.camera, factor), (f.time - stretch.start) / stretch.length,
                       area_downscale(f.image.unpacked(), factor)};
    });
  };
  Halves out;
  take(chosen, out.seen);
  take(kept, out.held);
  return out;
}

/// The configuration of a fit: coarse lattices, few rays, the weights as they are.
Config fit_config(const Config& config, const EffectSet& effects) {
  Config c = config;
  apply(effects, c);
  c.grid.radiance = {20, 40}, c.grid.radiance_start = {0, 0.25f};
  c.grid.motion = {4, 8, 16}, c.grid.motion_start = {0, 0.25f, 0.25f};
  c.radiance.sh_order = order_at(c.radiance, 0), c.radiance.sh_start.clear();
  c.motion.rest = 0;
  c.motion.elevate_points.clear(), c.motion.elevate_start.clear(), c.motion.halve_start.clear();
  c.grid.empty_start.clear();
  c.loss = for_trials(c.loss);
  c.sampling.rays = std::min(c.sampling.rays, 2048), c.sampling.growth = 1;
  c.sampling.window = 1;  // every fit learns from the same pictures
  c.sampling.occupancy_cells = 32, c.sampling.occupancy_every = 100;
  return c;
}

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
         const std::function<void(const EffectTrial&)>& told)
      : config_(config),
        level_(level),
        halves_(halves),
        time_map_(time_map),
        out_(out),
        first_(out.trials.size()),
        told_(told) {}

  /// Fits that are made already are not made again.
  EffectTrial fit(const EffectSet& effects, int points) {
    if (const int made = find(effects, points); made >= 0) return out_.trials[first_ + std::size_t(made)];
    Config c = fit_config(config_, effects);
    c.motion.points = points;
    c.run.max_time = 0, c.run.max_steps = config_.effects.steps;
    Trainer trainer(c, halves_.seen, time_map_);
    EffectTrial trial;
    trial.effects = effects, trial.points = points;
    while (!trainer.done()) trial.steps = int(trainer.step().step);
    trial.seconds = trainer.seconds();
    fits_.push_back({trainer.model(), {}});
    const VoxelModel& model = fits_.back().model;
    trial.bytes = std::int64_t(model.radiance.raw.values.size() * sizeof(float));
    for (const Channels& level : model.motion.levels)
      trial.bytes += std::int64_t(level.values.size() * sizeof(float));
    Renderer renderer(model);
    for (const Frame& f : halves_.held.frames) {
      fits_.back().pictures.push_back(clamped(renderer.render(f.camera, f.time).rgb));
      trial.psnr.push_back(
          capped_psnr(psnr(fits_.back().pictures.back(), composite(f.image, model.background.color))));
    }
    out_.trials.push_back(std::move(trial));
    if (told_) told_(out_.trials.back());
    return out_.trials.back();
  }
  /// Compares `with` to the same without the effect.
  EffectVerdict judge(const std::string& effect, const EffectSet& with) {
    const EffectTrial more = fit(with, config_.motion.points),
                      less = fit(with.without(effect), config_.motion.points);
    EffectVerdict v{effect, with, EffectDecision::undecided, gain(more, less)};
    decide(v);
    v.time_ratio = more.seconds / less.seconds;
    v.bytes_ratio = double(more.bytes) / double(less.bytes);
    out_.verdicts.push_back(v);
    return v;
  }
  /// Compares the moving fit that judge("motion", all) made to the still one where only motion explains what
  /// the fits have seen, on pictures they have not. In so short a fit motion costs what stands still more
  /// than it gives to a small thing that moves. What is found is the verdict on motion if the gain is clear.
  void judge_where_needed(const EffectSet& all) {
    const int points = config_.motion.points;
    const Fit &moving = fits_[std::size_t(find(all, points))],
              &still = fits_[std::size_t(find(all.without("motion"), points))];
    const BitGrid near = dilate(moving_cells(moving.model, still.model, halves_.seen, kExplained));
    const std::vector<Frame>& held = halves_.held.frames;
    std::vector<Image> where(held.size());
    parallel_for(int(held.size()), [&](int f) { where[f] = shows_cells(moving.model, near, held[f]); });
    std::vector<double> gains;
    double shown = 0, pixels = 0;
    for (std::size_t f = 0; f < held.size(); ++f) {
      const Image truth = picked(composite(held[f].image, moving.model.background.color), where[f]);
      shown += truth.width, pixels += double(where[f].data.size());
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
    v.gain = there, v.where = shown / pixels;
    decide(v);
  }
  /// Whether what the fits have seen is a film: a camera that hardly moves within a piece of the curves and
  /// is elsewhere in the next. @pre a fit was made
  bool film() {
    const double told = view_told_by_time(halves_.seen, fits_.front().model.box.center(),
                                          1.0 / basis_of(config_.motion.basis).pieces(config_.motion.points));
    out_.view_told_by_time = std::max(out_.view_told_by_time, told);
    return told > kFilm;
  }
  /// What judge("motion", all) found, once more, of a film. Whether the scene moves.
  bool judge_film(const EffectSet& all) {
    const VoxelModel& moving = fits_[std::size_t(find(all, config_.motion.points))].model;
    EffectVerdict& v = out_.verdicts.back();
    v.far = share_far(moving, halves_.seen, kFar * moving.radiance.raw.topology->lattice.spacing);
    const double least = config_.effects.min_gain;
    const bool moves = v.gain.mean > std::max(least, *v.far > kFarShare ? kFarGain : kFilmGain);
    if (!moves && v.gain.mean > least) v.decision = EffectDecision::confounded;
    return moves;
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
  const std::function<void(const EffectTrial&)>& told_;
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

}  // namespace

EffectChoice choose_effects(const Config& config, const Split& train, const TimeMap& time_map,
                            const std::function<void(const EffectTrial&)>& told) {
  const auto start = std::chrono::steady_clock::now();
  const auto elapsed = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  EffectChoice out;
  out.chosen = effects_of(config), out.points = config.motion.points;
  if (!learns_background(config, look_at(train))) out.chosen.background = -1;
  if (config.effects.steps == 0) return out.note = "effects.steps is 0: nothing was tried", out;
  const bool timed = config.run.max_time > 0;
  if (timed ? config.run.max_time < kShortestTime : config.run.max_steps < kShortest * config.effects.steps)
    return out.note = "too short a run to try effects out: every effect of the preset stays", out;
  EffectSet all = out.chosen;
  const auto [first, last] =
      std::minmax_element(train.frames.begin(), train.frames.end(),
                          [](const Frame& a, const Frame& b) { return a.time < b.time; });
  if (first->time == last->time) {
    out.chosen = all = all.without("motion").without("light");
    out.note = "every view is of one time: nothing can be seen to change";
  }
  if (int(train.frames.size()) < kFewestViews) {
    if (out.note.empty()) out.note = "too few views to hold some back: every effect of the preset stays";
    return out;
  }
  if (!all.motion && !all.light && all.background < 0) return out;
  const Halves halves = divide(train, {frames_by_time(train)});
  out.held = int(halves.held.frames.size());
  const float level = config.effects.level / float(kComparisons + (all.background >= 0));
  Ladder ladder(config, level, halves, time_map, out, told);
  if (all.background >= 0) {
    const bool gains = ladder.judge("background", all).gain.mean > config.effects.min_gain;
    if (!gains) out.chosen = all = all.without("background");
  }
  if (all.motion) {
    const auto moves = [&](Ladder& by, bool whole) {
      // Undecided motion goes by its mean, and what is decided has its mean on the same side of min_gain.
      const double gain = by.judge("motion", all).gain.mean;
      if (by.film()) return by.judge_film(all);
      if (whole && gain <= config.effects.min_gain) by.judge_where_needed(all);
      return out.verdicts.back().gain.mean > config.effects.min_gain;
    };
    bool found = moves(ladder, true);
    const std::optional<Stretch> stretch = middle_stretch(train);
    if (const Basis& basis = basis_of(config.motion.basis);
        stretch && basis.smooth > 0 && basis.pieces(config.motion.points) > 1) {
      const Halves parts = divide(train, *stretch);
      Ladder near(config, level, parts, time_map, out, told);
      if (moves(near, false)) found = true, out.points = points_for(near, all, config, stretch->length);
    }
    if (!found) out.chosen = all.without("motion");
  }
  if (all.light && !out.chosen.motion) {
    EffectDecision light = ladder.judge("light", out.chosen).decision;
    if (light == EffectDecision::on && ladder.film())
      light = out.verdicts.back().decision = EffectDecision::confounded;
    out.chosen.light = light == EffectDecision::on;
  }
  // Of a long sequence the whole and a stretch may differ: what either finds is used.
  for (EffectVerdict& v : out.verdicts)
    if (v.decision == EffectDecision::confounded && out.chosen.has(v.effect))
      v.decision = EffectDecision::undecided;
  out.seconds = elapsed();
  return out;
}

}  // namespace splinevox
