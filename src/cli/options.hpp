// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>

#include "cli/command.hpp"
#include "splinevox/io/frame_range.hpp"
#include "splinevox/run/run.hpp"
#include "splinevox/run/train.hpp"

/// Options that several verbs have, declared once.
namespace splinevox::cli {

/// Headings in the help that several verbs have.
constexpr const char *kData = "Data set", *kShot = "Shot", *kMachine = "Machine", *kTalk = "What it says";
/// Options that `verb` declares from here on stand below this heading; those below have their own.
void heading(CLI::App& verb, const char* text);

/// A number from `lo` to `hi`. CLI::Range lets NaN pass.
CLI::Validator decimals_in(double lo, double hi);

/// --quiet and --json.
struct TalkWords {
  bool quiet = false, json = false;
};
void add_talk(CLI::App& verb, TalkWords& words);
/// --json alone, of verbs whose text is their result.
void add_json(CLI::App& verb, bool& json);
/// --threads N: 0 = every core.
void add_threads(CLI::App& verb, int& threads);
/// --device auto, cpu or cuda; see choose_device.
void add_device(CLI::App& verb, std::string& device);
/// `--antialias`: how many rays a pixel has along each of its edges.
CLI::Option* add_antialias(CLI::App& verb, std::string& antialias);
/// RenderOptions::across that it asks for; 0: auto. Throws Error (input).
int across_of(const std::string& antialias);
/// --share K/N: of the frames or pictures only every N-th, from the K-th on.
void add_share(CLI::App& verb, std::string& share);
/// --frames, --at, --seconds and --fps of verbs that write the frames of a shot.
struct FrameWords {
  std::string frames = "1-120", at;
  double fps = 24, seconds = 0;
};
void add_frames(CLI::App& verb, FrameWords& words);
/// What they say. Throws Error (input).
FrameRange frame_range(const FrameWords& words);
/// Which moments the first and the last frame show, and where the whole motion would be: a line for the user.
std::string moments_text(const FrameRange& range);
/// --downscale and --background of verbs that read a run.
void add_otherwise(CLI::App& verb, Otherwise& otherwise);
/// --times, --missing and --masks of verbs that read a data set.
void add_rules(CLI::App& verb, DatasetRules& rules);
/// --masks alone.
void add_masks(CLI::App& verb, std::string& masks);
/// --memory and --cache of verbs that read pictures.
void add_picture_room(CLI::App& verb, std::string& memory, std::string& cache);
/// The command line of `train` as typed.
struct TrainVerb : TrainOptions, TalkWords {
  int threads = 0;
  bool list_settings = false;
  std::optional<std::string> live;  ///< port of the page; "": a free one
  bool named = true;                ///< `out` was given, not found
};
void add_train_options(CLI::App& verb, TrainVerb& options);

}  // namespace splinevox::cli
