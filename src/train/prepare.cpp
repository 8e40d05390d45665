// SPDX-License-Identifier: Apache-2.0
#include "splinevox/train/prepare.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/process.hpp"
#include "splinevox/core/error.hpp"
#include "train/bounds/ground.hpp"
#include "train/check_cameras.hpp"
#include "train/effects/effect_table.hpp"
#include "train/effects/film.hpp"
#include "train/film/still_world.hpp"
#include "train/learn_cameras.hpp"
#include "train/start.hpp"

namespace splinevox {
namespace {

/// Data sets can be opened without their pictures' pixels (LoadOptions::pixels).
void check_pixels(const Split& train, const std::string& where) {
  for (const Frame& f : train.frames)
    if (!f.image.has_values())
      fail({where, "pictures have been opened without their pixels", "LoadOptions::pixels", f.name, ""});
}

const Split& train_split(const Dataset& data) {
  const Split* train = data.find("train");
  if (!train || train->frames.empty())
    fail({data.path, "there is nothing to train on", "a split named train, if it was read", "", ""});
  check_pixels(*train, data.path);
  return *train;
}

/// Whether the data's own box is what bounds the scene: nothing else does.
bool takes_box(const Config& config, const Dataset& data) {
  return !data.has_alpha && data.box && config.grid.box.empty();
}

/// Whether the subject may be as dark as what passes for the ground's colour.
bool too_dark_to_tell(const Config& config, const Split& train, const Vec3& ground) {
  constexpr float kDark = 0.1f;           // a value
  constexpr float kMostTolerance = 0.1f;  // of the unit of brightness
  if (std::max({ground.x, ground.y, ground.z}) > kDark) return false;
  return kGroundTolerance > kMostTolerance * brightness(config, picture_stats(train));
}

/// The ground behind opaque pictures: looked for, or of the colour that the configuration names, and cut out
/// of them if what is left makes silhouettes that meet.
/// @return explained_by_hull of what was cut out now
std::optional<double> settle_ground(Config& config, Dataset& data,
                                    const std::function<void(std::string)>& note) {
  const bool named = config.sampling.background == BackgroundKind::ground;
  const auto stand_on = [&](const Vec3& colour) {
    config.run.background = {colour.x, colour.y, colour.z};
    config.run.background_order = -1;
    config.sampling.background = BackgroundKind::ground;
  };
  if (data.ground) {  // cut out before
    if (named || config.run.find_ground) stand_on(*data.ground);
    return {};
  }
  if (data.has_alpha) {  // silhouettes are known: what is opaque is so before any background
    if (named) config.sampling.background = BackgroundKind::random;
    return {};
  }
  Split& train = *data.find("train");
  const std::vector<float>& c = config.run.background;
  const std::optional<Vec3> colour = named                    ? std::optional(Vec3{c[0], c[1], c[2]})
                                     : config.run.find_ground ? find_ground(train)
                                                              : std::nullopt;
  if (!colour || (!named && too_dark_to_tell(config, train, *colour))) return {};
  constexpr double kLeastCut = 0.02, kAgrees = 0.9;
  const double cut = cut_ground(train, *colour);
  const double explained = cut < kLeastCut || cut == 1 ? 0 : explained_by_hull(train, cameras_of(train));
  if (explained < kAgrees) {
    undo_cut(train);
    return {};
  }
  data.ground = colour;
  data.has_alpha = true;
  stand_on(*colour);
  note(fmt::format(
      "the pictures stand on a plain ground of ({:.2f}, {:.2f}, {:.2f}): it is cut out, {:.0f}% of "
      "all pixels (--set run.find_ground=0 otherwise)",
      colour->x, colour->y, colour->z, 100 * cut));
  return explained;
}

/// Step of raw density, at most, where matter is thin and comes and goes: there density is nearly the
/// exponential of its raw value, and follows every step's noise. Trials of effects are too short for it
/// (docs/experiments/matter.md).
constexpr float kThinRate = 0.05f;

EffectChoice kept(const Config& config) {
  EffectChoice out;
  out.chosen = effects_of(config);
  out.points = config.motion.points;
  return out;
}

/// Whether Frame::moving is what masks say, and not what was found out when the data was prepared before.
bool masks_say_what_moves(const Dataset& data) { return data.masks && data.masks->use.starts_with("moving"); }

/// Gives the frames of a film what moves in them. Of a film that nobody has looked at yet it is found out,
/// unless masks say it.
void know_film(Prepared& prepared, Dataset& data, const PrepareOptions& options) {
  Split& train = *data.find("train");
  EffectChoice& choice = prepared.effects;
  if (!choice.view_told_by_time)
    choice.view_told_by_time =
        view_told_by_time(prepared.config, train, starting_middle(prepared.config, train));
  const double told = *choice.view_told_by_time;
  if (!choice.film)
    choice.film = motion_told(prepared.config, train, data.time_map, told, choice.moving, options.on_film);
  if (!choice.film) return;
  if (!choice.film->unexplained()) {
    // What no fit could judge goes by the still world. Motion that was asked for may be anywhere.
    if (options.effects == EffectPolicy::choose && prepared.config.effects.steps > 0) {
      choice.chosen = unchanging(choice.chosen);
      choice.note += "; but a still world shows all of the film, so nothing moves";
      apply(choice.chosen, prepared.config);
    }
    return;
  }
  if (!choice.film->given)
    for (std::size_t f = 0; f < train.frames.size(); ++f) train.frames[f].moving = choice.moving[f];
  else if (!is_film(told))
    return;
  // Most of a film is static, and its first third shows too little of it. One camera cannot place what moves:
  // the more rays are drawn there, the more fog fits them (docs/experiments/effects.md).
  prepared.config.sampling.window = 1;
  prepared.config.sampling.changing = 0;
}

}  // namespace

void cut_ground(const Config& prepared, Dataset& data) {
  Config same = prepared;
  settle_ground(same, data, [](const std::string&) {});
}

Prepared prepare(const Config& config, Dataset& data, const PrepareOptions& options) {
  const Split& train = train_split(data);
  if (!masks_say_what_moves(data))
    for (Frame& f : data.find("train")->frames) f.moving = {};
  Prepared out;
  out.config = config;
  out.policy = options.effects;
  const auto tell = [&](const std::string& text) {
    if (options.on_note) options.on_note(text);
  };
  const auto note = [&](std::string text) {
    tell(text);
    out.notes.push_back(std::move(text));
  };
  const std::optional<double> explained = settle_ground(out.config, data, note);
  if (takes_box(config, data)) {
    const Box& b = *data.box;
    out.config.grid.box = {b.lo.x, b.lo.y, b.lo.z, b.hi.x, b.hi.y, b.hi.z};
    note(
        fmt::format("opaque pictures: the box is the data's own, {:.4g} x {:.4g} x {:.4g} (--set "
                    "grid.box=... for another)",
                    b.extent().x, b.extent().y, b.extent().z));
  }
  if (data.has_alpha && out.config.grid.box.empty()) check_silhouettes(train, note, explained);
  out.parallax = check_parallax(out.config, train, note);
  const PictureStats stats = picture_stats(train);
  out.brightness = brightness(out.config, stats);
  if (out.brightness < 1)
    note(fmt::format("dark pictures: colours are trained in units of {:.3g}", out.brightness));
  if (options.effects == EffectPolicy::keep) {
    out.effects = kept(out.config);
  } else {
    if (config.effects.steps > 0) tell("trying out which effects the scene calls for");
    out.effects = choose_effects(out.config, train, data.time_map, options.on_trial, options.on_film,
                                 options.by_clock, options.used);
    release_freed_memory();  // of the fits
    if (out.effects.on_trust)
      out.effects.note += options.effects == EffectPolicy::choose
                              ? ": every effect of the preset but presence and drift stays"
                              : ": what was asked for is used";
    if (!data.has_alpha) note_bad_fits(train, out.effects, note);
  }
  if (options.effects == EffectPolicy::choose) {
    apply(out.effects.chosen, out.config);
    out.config.motion.points = out.effects.points;
  }
  if (out.config.motion.presence && stats.thin())
    out.config.optimiser.lr_density = std::min(out.config.optimiser.lr_density, kThinRate);
  if (out.config.motion.enabled && freezes(out.config)) know_film(out, data, options);
  const EffectSet wanted = effects_of(out.config);
  out.used = learnable_in(wanted, !data.has_alpha, taken_by(train));
  EffectSet lost;
  for (const Effect e : kAllEffects)
    if (wanted.has(e) && !out.used.has(e)) lost = lost.with(e);
  if (options.effects == EffectPolicy::measure && lost != EffectSet())
    note("asked for, and nothing that these pictures can teach: " + to_string(lost));
  return out;
}

}  // namespace splinevox
