// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "splinevox/data/scene.hpp"
#include "splinevox/train/config.hpp"
#include "splinevox/train/effects.hpp"

namespace splinevox {

/// What becomes of a configuration's effects before training.
enum class EffectPolicy {
  choose,   ///< they are tried out, and those are used that the scene calls for
  measure,  ///< they are tried out, and the configuration's own are used whatever is found
  keep,     ///< the configuration's own are used, untried
};

struct PrepareOptions {
  EffectPolicy effects = EffectPolicy::choose;
  bool by_clock = true;  ///< whether effects.most_time counts; not where several processes must agree
  double used = 0;       ///< seconds of run.max_time that are gone
  std::function<void(const std::string&)> on_note = {};   ///< called with every note, and with what begins
  std::function<void(const EffectTrial&)> on_trial = {};  ///< called after every trial fit
  std::function<void(const FilmEvidence&)> on_film = {};  ///< called once a film was looked at
};

/// A configuration made ready for a data set.
struct Prepared {
  Config config;                               ///< what to train with
  EffectPolicy policy = EffectPolicy::choose;  ///< as it was asked for
  EffectChoice effects;  ///< what was tried and found; kept effects: no trial, and they are `chosen`
  EffectSet used;        ///< what of them the model will have
  double parallax = 0;   ///< the largest angle between two views of the scene, degrees
  float brightness = 1;  ///< the unit that the trainer takes, in (0, 1]; 1 unless the pictures are dark
  std::vector<std::string> notes;  ///< what was settled and why, a line each, to show
};

/// Settles what the data decides about a training run: the box, the effects, the unit of brightness. Whoever
/// trains calls it once, before the Trainer is made, and so trains the same model as everybody else.
///
/// The box: opaque pictures have no silhouettes to find the scene by. If the data says where the scene lies
/// (Dataset::box) and the configuration names no box, the data's becomes `grid.box`. Trial fits are made in
/// it.
///
/// The ground: opaque pictures of something before one plain colour are cut out. Pixels that show nothing but
/// that colour get alpha 0 in the train split, and `run.background` becomes the colour. It is looked for
/// unless `run.find_ground` is off. With `sampling.background=ground` (what `--background` asks for) the
/// colour is `run.background`. What is cut must leave silhouettes that meet, else nothing is.
///
/// The cameras: silhouettes must meet where cameras look. Where they would with matrices of another kind,
/// that is an error; other doubts are notes.
///
/// A prepared configuration may be prepared again: its box and ground stay.
/// Throws Error (Fault::input) if there is no train split, and what Trainer throws.
/// @param data  its train split may get alpha, once
Prepared prepare(const Config& config, Dataset& data, const PrepareOptions& options = {});

/// Cuts the ground out of data that was loaded again, as prepare did when it made `prepared`: for a run that
/// goes on.
void cut_ground(const Config& prepared, Dataset& data);

}  // namespace splinevox
