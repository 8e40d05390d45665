// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cstdio>
#include <memory>

#include "cli/command.hpp"
#include "cli/options.hpp"
#include "core/printable.hpp"
#include "run/capture/capture.hpp"
#include "run/events.hpp"
#include "run/signals.hpp"

namespace splinevox::cli {
namespace {

int capture_verb(const CaptureOptions& options, bool quiet, bool json) {
  const Talk kind = choose_talk(quiet, json);
  catch_stop_signals();
  CaptureTalk talk(kind, stop_asked);
  const auto stopped = [&] {
    if (json) write_event("interrupted", {{"interrupted", true}});
    if (!quiet) fmt::print(stderr, "\nstopped; the same command goes on from here\n");
    return kInterrupted;
  };
  try {
    const Json figures = capture(options, talk);
    if (json) {
      write_event("result", {{"result", figures}});
    } else if (!quiet) {
      const std::string out = all_printable(options.out);
      fmt::print("{}: {} of {} {} placed, {:.2f} pixels off on the mean; splinevox train {} --out RUN\n", out,
                 figures["placed"].get<int>(), figures["asked"].get<int>(),
                 figures["things"].get<std::string>(), figures["reprojection_error"].get<double>(), out);
    }
    return 0;
  } catch (const CaptureStopped&) {
    return stopped();
  } catch (const Error&) {  // of ffmpeg, which hears the terminal's Ctrl-C too, and ends
    if (!stop_asked()) throw;
    return stopped();
  }
}

}  // namespace

Action capture_command(CLI::App& verb) {
  struct Options : CaptureOptions, TalkWords {};
  auto o = std::make_shared<Options>();
  verb.add_option("SOURCE", o->sources,
                  "a film or a folder of pictures of one camera that moves; or a film or folder per camera "
                  "that stands still")
      ->required();
  heading(verb, "Output");
  verb.add_option("--out", o->out, "folder of the data set: transforms.json, images, masks, capture.json")
      ->required();
  verb.add_flag("--fresh", o->fresh,
                "begin anew in a folder that an earlier call began; what that made lies in earlier_capture "
                "until the new data set is there");
  heading(verb, "Which pictures");
  verb.add_option("--frames", o->frames,
                  fmt::format("so many frames of each camera, of equal parts the sharpest, of several "
                              "cameras the first; {} of a film and "
                              "all pictures of a folder, if not given",
                              kUsualFrames))
      ->check(CLI::Range(2, 1000000));
  verb.add_option("--every", o->every, "the sharpest of every so many frames, of several cameras the first")
      ->check(CLI::Range(1, 1000000));
  verb.add_option("--from", o->from, "seconds of a film, from its first frame")->capture_default_str();
  verb.add_option("--to", o->to, "seconds of a film; if not given, to its end");
  verb.add_option("--max-size", o->max_size, "longer side of a film's frames, pixels; 0: as they are")
      ->capture_default_str();
  verb.add_option("--fps", o->fps, "pictures of a folder a second, in the order in which people count names")
      ->capture_default_str();
  heading(verb, "Cameras");
  verb.add_option("--lens", o->lens,
                  "how lenses bend the picture; if not given, opencv of a camera that moves and radial of "
                  "others")
      ->type_name(fmt::format("{{{}}}", fmt::join(capture_lenses(), ",")));
  verb.add_option("--moments", o->moments, "at which cameras that stand still are placed")
      ->capture_default_str();
  verb.add_option("--walk", o->walk,
                  "a film or folder of one camera that walks past those that stand still: their places are "
                  "found by it, and it is no part of the data set");
  add_masks(verb, o->masks);
  add_talk(verb, *o);
  add_threads(verb, o->threads);
  verb.footer(
      "It needs ffmpeg for films and colmap for cameras: apt-get install --no-install-recommends ffmpeg "
      "colmap.\nThe same command goes on where it was stopped.");
  return [o] { return capture_verb(*o, o->quiet, o->json); };
}

}  // namespace splinevox::cli
