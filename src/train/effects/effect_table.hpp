// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "field/columns.hpp"
#include "splinevox/train/effects.hpp"
#include "train/learn_cameras.hpp"

/// The effects, each in one place: configuration, command line, trials, files and reports loop over this
/// table.
namespace splinevox {

/// How an effect is tried out before training.
enum class Trial {
  none,      ///< it pays too late in training for a short fit to tell
  by_mean,   ///< it stays if it gains enough on the mean
  by_place,  ///< the same on held-out cameras, where a rig has enough
  motion,    ///< the same; it is looked for where it alone explains the pictures and in a stretch of a long
             ///< sequence; in a video it needs more
  alone,     ///< only where nothing moves; it stays if it is sure to gain, and never in a video
  exposure,  ///< it stays if it is sure to gain and its gains differ
  drift,     ///< the same, of the gains of one camera
  clock,     ///< beside motion: it stays if a camera's pictures are sure to show another moment
  presence   ///< last, beside all that stays, and never in a film: of solid matter only if it gains and there
             ///< is less of it at some time
};

struct EffectFacts {
  Effect effect;
  const char* name;
  std::optional<Effect> needs = {};
  const char* why_needs = "";             ///< in words, for who asked for it without
  std::optional<ColumnKind> brings = {};  ///< columns that rows have for it
  bool ordered = false;      ///< it has harmonics, and files tell their order; of another, whether it is on
  int least = 0, full = 0;   ///< order at least where it is asked for, and where every effect is in full
  bool opaque_only = false;  ///< only behind opaque pictures; elsewhere nothing is said of it
  TakenBy taken_by = TakenBy::any;  ///< at least; of other pictures nothing is said of it
  int (*order_in)(const Config&);   ///< EffectSet::order of a configuration
  void (*set)(Config&, int order);  ///< the inverse
  Trial trial = Trial::none;
  int turn = 0;         ///< of those that are tried, the lowest first
  int comparisons = 0;  ///< that its trial takes at most
  int fits = 0;         ///< of effects.steps, whose time its trial takes, about

  /// Whether it asks for the kernels of what changes over time (render/specialise.hpp).
  constexpr bool moving() const { return brings && splinevox::facts_of(*brings).of_motion(); }
};

const EffectFacts& facts_of(Effect effect);

/// The effects of a set that are tried out, in their turn.
std::vector<Effect> in_turn(const EffectSet& effects);

/// Comparisons that trying a set out takes at most. What changes over time counts even where it is off, so
/// that leaving it out makes no other effect easier to find.
int most_comparisons(const EffectSet& effects);

/// Those of a set that can be learned from the pictures. @param opaque  no pixel is transparent
EffectSet learnable_in(const EffectSet& effects, bool opaque, TakenBy by);

/// Those of a set that say nothing about time.
EffectSet unchanging(const EffectSet& effects);

/// Whether a model with these effects changes over time.
bool changes(const EffectSet& effects);

/// Which columns a motion stores for these effects.
void store(const EffectSet& effects, MotionField& motion);

}  // namespace splinevox
