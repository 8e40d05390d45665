// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include "splinevox/field/model.hpp"
#include "splinevox/train/effects.hpp"
#include "train/effects/gains_where.hpp"
#include "train/effects/halves.hpp"
#include "train/effects/rig.hpp"

namespace splinevox {

/// Fits by set of effects, each made once, and the comparisons between them.
class Ladder {
 public:
  /// @param level  of one comparison. @param unit  of brightness (train/start.hpp)
  Ladder(const Config& config, float level, float unit, const Halves& halves, const TimeMap& time_map,
         EffectChoice& out, const std::function<void(const EffectTrial&)>& on_trial)
      : config_(config),
        level_(level),
        unit_(unit),
        halves_(halves),
        time_map_(time_map),
        out_(out),
        on_trial_(on_trial) {}

  /// Fits that are made already are not made again.
  EffectTrial fit(const EffectSet& effects, int points);
  /// Compares `with` to the same without the effect. @param points  of both; 0: as configured
  EffectVerdict judge(Effect effect, const EffectSet& with, int points = 0);
  /// Compares the fit with motion that judge(Effect::motion, all) made to the static one. The comparison is
  /// on held-out pictures, where only motion explains the training pictures. In so short a fit motion costs
  /// the static part more than it gives to a small moving one. A clear gain becomes the verdict on motion.
  void judge_where_needed(const EffectSet& all);
  /// Compares `with` to the same without the effect, where pixels are known to change.
  /// @param changing  of each held-out picture, one channel: 1 there, else 0
  EffectVerdict judge_where_changing(Effect effect, const EffectSet& with, const std::vector<Image>& changing,
                                     int points = 0);
  /// Judges anew, as of a film, what judge(Effect::motion, all) found. Returns whether the scene moves.
  /// @param proved  what a still world cannot show is no highlight
  bool judge_film(const EffectSet& all, bool proved);
  /// Judges whether cameras have gains of their own. What a gain gives to held-out pictures of its own camera
  /// may be what the model lacks there, so gains must differ as well. Where all that is seen moves, its
  /// errors hide what gains give. There the pictures' own brightness decides.
  EffectVerdict judge_exposure(const EffectSet& all);
  /// The same of gains that change over time. @param film  of one camera that moves: a highlight changes as
  /// it goes by, so pictures must be brighter or darker as a whole. Otherwise of a rig.
  EffectVerdict judge_drift(const EffectSet& all, bool film);
  /// Judges whether cameras have clocks of their own, by the fit without them. @param train  the whole split
  EffectVerdict judge_clock(const EffectSet& all, const Split& train);
  /// Of a fit that judge made: how much matter of what changes is left when there is least.
  double least_matter(const EffectSet& effects, int points) const;
  /// Compares two numbers of control points.
  PointsVerdict judge(const EffectSet& effects, int more, int fewer);

 private:
  /// What a trial leaves for comparisons.
  struct Fit {
    VoxelModel model;
    std::vector<Image> pictures;  ///< of the held-out frames
    std::size_t trial;            ///< which of out_'s it is
  };
  void decide(EffectVerdict& v) const;
  /// What a fit that was made shows of the held-out frames without its gains.
  struct Neutral {
    Vec3 background;
    std::vector<Image> pictures;
  };
  Neutral without_gains(const EffectSet& effects) const;
  EffectVerdict judge_gains(Effect effect, const EffectSet& all, double (*spread)(const CameraFits&));
  /// Of gains that judge_gains left undecided, and that are apart by least_spread: what the brightness of a
  /// rig's pictures says. They are on if `apart` of it is above `least`.
  void ask_brightness(EffectVerdict& v, double least_spread, double CameraSpread::*apart, double least) const;
  /// Index among its own fits, -1: not made yet.
  int find(const EffectSet& effects, int points) const;
  PairedGain gain(const EffectTrial& more, const EffectTrial& less) const;
  /// Of the fits with an effect and without, on a part of each held-out picture.
  std::optional<GainsWhere> gains_there(const std::vector<Image>& where, const EffectSet& with, Effect effect,
                                        int points = 0) const;

  const Config& config_;
  const float level_, unit_;
  const Halves& halves_;
  const TimeMap& time_map_;
  EffectChoice& out_;
  std::vector<Fit> fits_;  ///< of its own trials
  const std::function<void(const EffectTrial&)>& on_trial_;
};

}  // namespace splinevox
