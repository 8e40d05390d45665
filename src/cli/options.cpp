// SPDX-License-Identifier: Apache-2.0
#include "cli/options.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/number_text.hpp"
#include "math/sh.hpp"
#include "run/support.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/render/render_image.hpp"
#include "splinevox/train/effects.hpp"

namespace splinevox::cli {
namespace {

/// Means over the six D-NeRF scenes at 400x400 that docs/benchmarks.md lists, on two cores.
struct Measured {
  const char* preset;
  double psnr, memory;  ///< dB on the test split; peak, GB
};
constexpr Measured kMeasured[] = {
#include "cli/preset_figures.inc"  // written by bench/quality.sh
};

std::string preset_help() {
  std::string text = "where the numbers start from:";
  for (const Preset& p : presets()) {
    text += fmt::format("\n  {}: {}", p.name, p.summary);
    for (const Measured& m : kMeasured)
      if (m.preset == std::string(p.name))
        text += fmt::format("; measured {:.2f} dB, {:.2f} GB", m.psnr, m.memory);
  }
  return text;
}

std::string preset_names() {
  std::vector<std::string> names;
  for (const Preset& p : presets()) names.push_back(p.name);
  return fmt::format("{{{}}}", fmt::join(names, ","));
}

/// "1-120" or "7".
std::vector<int> frame_numbers(const char* option, const std::string& text, const char* hint) {
  const char* expected = "FIRST-LAST or one number, whole and not negative";
  const std::vector<double> v = numbers(text, '-', option, expected);
  const bool whole =
      std::all_of(v.begin(), v.end(), [](double n) { return n == std::floor(n) && n >= 0 && n < 1e7; });
  if (v.empty() || v.size() > 2 || !whole || v.front() > v.back() || text[0] == '-')
    fail({option, "this is not a range of frames", expected, text, hint});
  return {v.begin(), v.end()};
}

}  // namespace

void heading(CLI::App& verb, const char* text) { verb.option_defaults()->group(text); }

void add_json(CLI::App& verb, bool& json) {
  verb.add_flag("--json", json,
                "for programs: notes, progress, errors and the result as JSON objects on stdout, one a line "
                "(docs/formats.md has the table)")
      ->disable_flag_override()  // events begin before words are read (program.cpp)
      ->group(kTalk);
}

CLI::Validator decimals_in(double lo, double hi) {
  const std::string range = fmt::format("{:g} to {:g}", lo, hi);
  return CLI::Validator(
      [=](std::string& text) {
        double value = 0;
        const bool good = CLI::detail::lexical_cast(text, value) && value >= lo && value <= hi;
        return good ? std::string() : fmt::format("Value {} not in range {}", text, range);
      },
      fmt::format("FLOAT in [{:g} - {:g}]", lo, hi));
}

void add_talk(CLI::App& verb, TalkWords& words) {
  verb.add_flag("--quiet", words.quiet, "say nothing but errors")->group(kTalk);
  add_json(verb, words.json);
}

void add_threads(CLI::App& verb, int& threads) {
  verb.add_option("--threads", threads, "threads to use, 0 = one per core")
      ->check(CLI::Range(0, 4096))
      ->group(kMachine)
      ->capture_default_str();
}

void add_device(CLI::App& verb, std::string& device) {
  verb.add_option("--device", device,
                  "cpu, cuda, or auto: cuda where this build has it and a device is there")
      ->type_name("{auto,cpu,cuda}")
      ->group(kMachine)
      ->capture_default_str();
}

CLI::Option* add_antialias(CLI::App& verb, std::string& antialias) {
  return verb
      .add_option(
          "--antialias", antialias,
          "N: a pixel is the mean of N x N rays, which takes as many times as long; auto: 2 where voxels "
          "are narrower than 2.4 pixels, else 1")
      ->type_name("{auto,1,2,...}")
      ->capture_default_str();
}

int across_of(const std::string& antialias) {
  if (antialias == "auto") return 0;
  const int across = parse_number<int>(antialias).value_or(0);
  if (across < 1 || across > kMostAcross)
    fail({"--antialias", "there is no such number of rays", fmt::format("auto, or 1 to {}", kMostAcross),
          antialias, ""});
  return across;
}

void add_share(CLI::App& verb, std::string& share) {
  verb.add_option("--share", share,
                  "K/N: only every N-th, from the K-th on, for N processes side by side; under mpirun each "
                  "takes its own")
      ->group(kMachine);
}

void add_frames(CLI::App& verb, FrameWords& words) {
  heading(verb, kShot);
  verb.add_option("--frames", words.frames, "FIRST-LAST, the frames to write")->capture_default_str();
  verb.add_option("--at", words.at,
                  "the frame at which the motion begins, or FIRST-LAST, over which all of it runs: --frames "
                  "is then a part of that shot [the first of --frames]");
  verb.add_option("--fps", words.fps, "frames a second")->capture_default_str();
  verb.add_option("--seconds", words.seconds,
                  "how long the whole motion lasts from --at on, 0 = to the last frame")
      ->capture_default_str();
}

FrameRange frame_range(const FrameWords& words) {
  FrameRange range;
  range.fps = words.fps;
  range.seconds = words.seconds;
  const std::vector<int> frames = frame_numbers("--frames", words.frames, "--frames 1-120");
  range.first = frames.front();
  range.last = frames.back();
  validate(range);
  if (words.at.empty()) return range;
  const std::vector<int> motion = frame_numbers("--at", words.at, "--at 1, or --at 1-120");
  range.at = motion.front();
  if (motion.size() == 2) {
    if (words.seconds > 0)
      fail({"--at", "the length of the motion is given twice", "FIRST-LAST, or FIRST and --seconds", words.at,
            fmt::format("--at {}", motion.front())});
    if (motion.front() == motion.back())
      fail({"--at", "a motion takes more than one frame", "FIRST-LAST, FIRST < LAST", words.at, ""});
    range.seconds = (motion.back() - motion.front()) / words.fps;
  }
  validate(range);
  return range;
}

std::string moments_text(const FrameRange& r) {
  const double first = r.time_at(r.first), last = r.time_at(r.last);
  std::string text = fmt::format("frame {} shows time {:.4g}", r.first, first);
  if (r.count() > 1) text += fmt::format(", frame {} time {:.4g}", r.last, last);
  text += fmt::format("; the whole motion, time 0 to 1, takes {:.4g} s, frames {} to {:.7g}", r.length(),
                      r.start(), r.start() + r.length() * r.fps);
  if (r.rate_at(r.first) == 0 && r.rate_at(r.last) == 0 && (first == last))
    text += ": these lie outside and stand still";
  return text;
}

void add_otherwise(CLI::App& verb, Otherwise& o) {
  heading(verb, kData);
  verb.add_option("--downscale", o.downscale,
                  "average KxK pixel blocks of the pictures, if not as in training")
      ->check(CLI::Range(1, 64));
  verb.add_option("--background", o.background,
                  "white, black or R,G,B in 0..1, if not what it was in training");
}

void add_rules(CLI::App& verb, DatasetRules& rules) {
  heading(verb, kData);
  verb.add_option(
          "--times", rules.times,
          "when pictures were taken, where the data does not say: none (all of one moment), order (evenly, "
          "in the order of names), name:GROUP (a group of digits in the names, 1 the first, -1 the last) "
          "or FILE (a name and a number per line)")
      ->type_name("WHEN");
  verb.add_option(
          "--between", rules.between,
          "only pictures taken from FROM to TO, in times as the data has them: a long sequence in parts")
      ->type_name("FROM:TO");
  verb.add_option("--hold-out", rules.hold_out,
                  "what is not trained on, where the data names no test split: none, or names of cameras, "
                  "divided by commas; not given: one camera of eight, or every eighth picture")
      ->type_name("none|CAMERA,...");
  verb.add_option(
          "--missing", rules.missing,
          "frames without a picture or a usable camera: skip them, or refuse the data set; not given: "
          "skipped up to a tenth of all")
      ->type_name("{skip,refuse}");
  verb.add_option(
          "--transfer", rules.transfer,
          "what the numbers in pictures stand for: srgb (values as a screen shows them) or linear (light); "
          "not given: linear for OpenEXR and other floats, else srgb")
      ->type_name("{srgb,linear}");
  verb.add_option("--layer", rules.layer, "layer of OpenEXR pictures, where several hold colours")
      ->type_name("NAME");
  verb.add_option(
          "--depth", rules.depth,
          "what depth maps (depth_file_path) say: metric (depth in scene units), relative (but for a scale "
          "and a shift of each picture), inverse (one over depth, but for such), or none (not used); not "
          "given: metric where depth_unit_scale_factor gives a unit, else relative")
      ->type_name("{metric,relative,inverse,none}");
  verb.add_option(
          "--tracks", rules.tracks,
          "points that are followed through the pictures of one camera: a .npy or .npz file, or a folder of "
          "optical flow from each picture to the next; or none (not used); not given: what the data names "
          "(tracks_file_path)")
      ->type_name("FILE|FOLDER|none");
  add_masks(verb, rules.masks);
}

void add_masks(CLI::App& verb, std::string& masks) {
  verb.add_option(
          "--masks", masks,
          "what masks beside the pictures are for: subject (white is the scene, all else is empty), ignore "
          "(black says nothing: neither drawn nor scored; in files dynamic_mask_... white does), "
          "subject-black, ignore-white and ignore-black (this colour, whatever the names), moving (white "
          "moves, all else stands still), moving-black, or none")
      ->group(kData)
      ->type_name("USE");
}

void add_picture_room(CLI::App& verb, std::string& memory, std::string& cache) {
  heading(verb, kMachine);
  verb.add_option(
          "--memory", memory,
          "the most memory the process may take, such as 6G or 500M; pictures that do not fit are kept in "
          "a file, and what fits not at all is refused; not given: four fifths of what the machine or "
          "the container has, and no more than is free")
      ->type_name("SIZE");
  verb.add_option("--cache", cache,
                  "folder for that file, which the next run uses again and which may be deleted; not given: "
                  "splinevox in $XDG_CACHE_HOME, else in ~/.cache")
      ->type_name("DIR");
}

void add_train_options(CLI::App& verb, TrainVerb& o) {
  verb.add_option("DATASET", o.dataset,
                  "folder of a data set: D-NeRF, nerfstudio, COLMAP and others (docs/data.md)");
  heading(verb, "Run");
  verb.add_option(
      "--out", o.out,
      "folder of the run (config.toml, model.vdb, checkpoint, metrics, preview); not given: a new one, "
      "runs/NAME-DATE, which is said");
  verb.add_flag("--resume", o.resume, "go on with the run in --out, or start it if there is no checkpoint");
  verb.add_option("--max-time", o.max_time,
                  "seconds training may take, loading included; schedules are laid out over it");
  verb.add_option("--max-steps", o.max_steps, "optimiser steps; alone, the same seed gives the same bits");
  verb.add_option("--seed", o.seed, "seed of every random draw");
  heading(verb, "Model");
  verb.add_option("--preset", o.preset, preset_help())->type_name(preset_names());
  verb.add_option("--config", o.config_file, "TOML file over the preset");
  verb.add_option("--set", o.sets, "one number over both, group.key=value; may be repeated")
      ->allow_extra_args(false);
  verb.add_option(
          "--effects", o.effects,
          fmt::format("auto (those the scene calls for, tried out first), none, all (each in full: view "
                      "dependence of order {}), or a list of {}",
                      kMaxShOrder, fmt::join(effect_names(), ", ")))
      ->capture_default_str();
  verb.add_flag("--list-settings", o.list_settings, "print every setting of the preset as TOML and stop");
  add_rules(verb, o.rules);
  verb.add_option("--downscale", o.downscale, "average KxK pixel blocks of the pictures");
  verb.add_option("--background", o.background,
                  "white, black or R,G,B in 0..1, behind pictures with alpha, and behind opaque ones instead "
                  "of a learned colour");
  add_threads(verb, o.threads);
  add_device(verb, o.device);
  add_picture_room(verb, o.memory, o.cache);
  verb.add_flag(
      "--deterministic", o.deterministic,
      "on a CUDA device too: the same bits in every run, for some of its speed (the CPU always has them)");
  heading(verb, kTalk);
  verb.add_option_function<std::vector<std::string>>(
          "--live",
          [&o](const std::vector<std::string>& words) { o.live = words.empty() ? "" : words.front(); },
          "a page on this machine that shows the model while it is trained, with buttons to pause, stop and "
          "give more time; its address is printed, also with --quiet; without PORT a free one is taken")
      ->expected(0, 1)
      ->type_name("PORT");
  add_talk(verb, o);
}

}  // namespace splinevox::cli
