// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <thread>

#include "cli/camera_files.hpp"
#include "cli/command.hpp"
#include "cli/export_report.hpp"
#include "cli/options.hpp"
#include "cli/render_layers.hpp"
#include "core/nearest.hpp"
#include "core/own_folder.hpp"
#include "io/export/export_sidecar.hpp"
#include "run/compositing.hpp"
#include "run/film_write.hpp"
#include "run/folder_lock.hpp"
#include "run/folder_mark.hpp"
#include "run/shares.hpp"
#include "run/signals.hpp"
#include "run/teller.hpp"
#include "splinevox/backend/device.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/data/image_io.hpp"
#include "splinevox/run/cameras.hpp"
#include "splinevox/run/evaluate.hpp"
#include "splinevox/run/run.hpp"

namespace splinevox::cli {
namespace {

std::string picture_name(const std::string& layer, int number) {
  return fmt::format("{}_{:04}.png", layer, number);
}
std::string exr_name(int number) { return fmt::format("frame_{:04}.exr", number); }

struct RenderVerb {
  std::string run, out, layers = "rgb", format = "png", device = "auto", share, antialias = "auto";
  CameraRequest cameras;
  Otherwise otherwise;
  FrameWords frames{.frames = "", .at = "", .fps = 24, .seconds = 0};
  int threads = 0;
  TalkWords talk;
};

constexpr FolderMark kRenderMark{"render.json", "splinevox render"};  ///< in a folder of pictures

std::vector<std::string> names_of(const RenderVerb& o, const std::vector<std::string>& layers,
                                  const RenderFrames& frames) {
  if (o.format == "cameras") return {kCamerasJson, kCamerasUsd};
  std::vector<std::string> out;
  for (const std::string& layer : layers) {
    if (o.format == "mp4") out.push_back(layer + ".mp4");
    for (const int number : frames.numbers)
      if (o.format == "png") out.push_back(picture_name(layer, number));
  }
  for (const int number : frames.numbers)
    if (o.format == "exr") out.push_back(exr_name(number));
  return out;
}

/// Makes a folder for pictures ours. One with files of their names that no render wrote is refused.
/// @return whether it was ours before
bool claim_folder(const std::string& folder, const Run& run, const std::vector<std::string>& names) {
  probe_output_folder(folder);
  const bool ours = has_mark(folder, kRenderMark);
  std::vector<std::string> written = names;
  written.emplace_back(kRenderMark.name);
  if (const std::string taken = ours ? "" : first_taken(names_in_folder(folder), written); !taken.empty())
    fail({folder + "/" + taken, "`render` did not write this file and would replace it",
          "a folder of its own, or that of an earlier render", "",
          "another folder for --out, or remove the file: what older versions rendered has no render.json "
          "beside it"});
  write_mark(folder, kRenderMark, {{"run", run.path}});  // the one that was rendered last
  return ours;
}

/// Numbered pictures in the folder of kinds that this call writes, and not its own, which a program would
/// take for a part of the shot.
std::vector<std::string> left_pictures(const std::string& folder, const std::vector<std::string>& names) {
  const auto kind_of = [](const std::string& name) {
    const std::size_t dot = name.rfind('.'), last = name.find_last_not_of("0123456789", dot - 1);
    return dot == name.npos || last == name.npos || last + 1 == dot
               ? std::string()
               : name.substr(0, last + 1) + name.substr(dot);
  };
  std::set<std::string> kinds;
  for (const std::string& name : names) kinds.insert(kind_of(name));
  kinds.erase("");
  const std::set<std::string> own(names.begin(), names.end());
  std::vector<std::string> out;
  for (const std::string& name : names_in_folder(folder))
    if (kinds.contains(kind_of(name)) && !own.contains(name)) out.push_back(name);
  std::sort(out.begin(), out.end());
  return out;
}

/// Removes what renders that were killed left half written, unless another process of this machine writes
/// there.
void remove_drafts(const std::string& folder) {
  try {
    const FolderLock alone(folder, kWriting);  // removes those of pictures
    if (alone.held()) remove_film_drafts(folder);
  } catch (const Error&) {
  }
}

/// The right to write beside others, since parts of a shot may be rendered at once. Who removes drafts has
/// the folder alone for a moment.
FolderLock join_folder(const std::string& folder) {
  constexpr int kTries = 100;
  constexpr auto kPause = std::chrono::milliseconds(10);
  for (int i = 1; i < kTries; ++i) try {
      return FolderLock(folder, kWriting, false);
    } catch (const Error&) {
      std::this_thread::sleep_for(kPause);
    }
  return FolderLock(folder, kWriting, false);
}

/// Where the pictures would be taken from, and no pictures.
int write_cameras_only(const RenderVerb& o, const Run& run, const RenderFrames& frames,
                       const Teller& teller) {
  write_cameras(o.out, frames, o.frames.fps, run.model.time_map);
  const bool bent = std::any_of(frames.shots.begin(), frames.shots.end(),
                                [](const Shot& s) { return s.camera.lens.kind != Distortion::Kind::none; });
  const CamerasShown shown = show_cameras(o.out);
  if (shown == CamerasShown::yes) teller.note("the stage of the export in this folder shows them too");
  if (shown == CamerasShown::other_rate)
    teller.note(
        fmt::format("the stage of the export in this folder has other frames a second than these cameras, "
                    "{}, and does not "
                    "show them; its own with --fps does",
                    o.frames.fps));
  if (bent) teller.note("these lenses bend the picture; the files have pinhole cameras, without that");
  teller.result(
      {{"out", o.out}, {"cameras", frames.shown.size()}, {"files", {kCamerasJson, kCamerasUsd}}},
      fmt::format("{}: {} cameras, {} and {}", o.out, frames.shown.size(), kCamerasJson, kCamerasUsd));
  return 0;
}

/// The pictures of a call: files of their own, or films.
class Pictures {
 public:
  Pictures(const RenderVerb& o, const Run& run, const RenderFrames& frames,
           const std::vector<std::string>& layers, Device device, const RenderOptions& options)
      : o_(o),
        run_(run),
        frames_(frames),
        layers_(layers),
        options_(options),
        clear_(wants_nothing_behind(layers) ? std::make_unique<const VoxelModel>(nothing_behind(run.model))
                                            : nullptr),
        renderer_(make_renderer(clear_ ? *clear_ : run.model, device)),
        parts_(run.model, layers, device) {}

  /// @param i  of the frames that are shown
  void add(std::size_t i) {
    const Shot& shot = frames_.shots[frames_.shown[i]];
    const int number = frames_.numbers[i];
    const Rendered r = renderer_.render(shot.camera, shot.time, options_);
    if (o_.format == "exr")
      return write_layers(o_.out + "/" + exr_name(number), run_.model, r, parts_, layers_, frames_, i,
                          o_.frames.fps, options_);
    for (const std::string& layer : layers_)
      write(layer, number,
            layer == "cluster" ? parts_.picture(shot, options_)
                               : layer_picture(run_.model, r, layer, shot.camera));
  }
  /// Films have all their pictures.
  void finish() {
    for (auto& [layer, film] : films_) film.finish();
  }

 private:
  void write(const std::string& layer, int number, const Image& picture) {
    if (o_.format == "png") return write_png(o_.out + "/" + picture_name(layer, number), picture);
    const auto film = films_
                          .try_emplace(layer, fmt::format("{}/{}.mp4", o_.out, layer), picture.width,
                                       picture.height, o_.frames.fps)
                          .first;
    film->second.add(picture);
  }

  const RenderVerb& o_;
  const Run& run_;
  const RenderFrames& frames_;
  const std::vector<std::string>& layers_;
  RenderOptions options_;
  std::unique_ptr<const VoxelModel> clear_;  ///< null: the run's model is shown
  Renderer renderer_;
  PartPictures parts_;
  std::map<std::string, Film> films_;
};

/// Pictures that are there are whole; a film has all of its own or is none. @return the exit code
int tell_interrupted(const RenderVerb& o, const Teller& teller, std::int64_t done) {
  const bool film = o.format == "mp4";
  teller.interrupted(fmt::format("interrupted after {} pictures{}; the same command begins anew", done,
                                 film ? ", too few for the film" : ""),
                     {{"pictures", film ? 0 : done}});
  return kInterrupted;
}

int render(const RenderVerb& o) {
  const Device device = choose_device(o.device);
  static const std::vector<std::string> formats = {"png", "exr", "mp4", "cameras"};
  if (std::find(formats.begin(), formats.end(), o.format) == formats.end())
    fail({"--format", "there is no such format", "png, exr, mp4 or cameras", o.format,
          nearest(o.format, formats)});
  const std::vector<std::string> layers = chosen_layers(o.layers, o.format);
  const Share share = chosen_share(o.share);
  const RenderOptions options{.across = across_of(o.antialias)};
  if (o.format == "mp4" && !share.whole())
    fail({"--format", "a film is written by one process", "png or exr for pictures that are shared out",
          o.format, "ffmpeg makes a film of pictures, too"});
  const Run run = open_run(o.run, o.otherwise);
  Teller teller(choose_talk(o.talk.quiet, o.talk.json));
  const RenderFrames frames =
      plan_frames(run, o.cameras, o.frames, [&](const std::string& line) { teller.note(line); });
  catch_stop_signals();
  const std::vector<std::string> names = names_of(o, layers, frames);
  if (claim_folder(o.out, run, names) && share.whole()) remove_drafts(o.out);
  const FolderLock lock = join_folder(o.out);
  if (o.format == "cameras") return write_cameras_only(o, run, frames, teller);
  Pictures pictures(o, run, frames, layers, device, options);
  const std::int64_t own = (std::int64_t(frames.shown.size()) + share.count - 1 - share.index) / share.count;
  std::int64_t done = 0;
  for (std::size_t i = std::size_t(share.index); i < frames.shown.size() && !stop_asked();
       i += std::size_t(share.count)) {
    pictures.add(i);
    ++done;
    if (share.index == 0 || o.talk.json) teller.progress(done, own);
  }
  if (done < own) return tell_interrupted(o, teller, done);
  pictures.finish();
  if (const std::vector<std::string> left = left_pictures(o.out, names); share.whole() && !left.empty())
    teller.note(left_over("render", left));
  const Camera& camera = frames.shots[0].camera;
  teller.result({{"out", o.out},
                 {"pictures", done},
                 {"width", camera.width},
                 {"height", camera.height},
                 {"layers", layers},
                 {"format", o.format},
                 {"device", describe(device)}},
                fmt::format("{}: {} pictures of {}x{}, {} as {}, on {}", o.out, done, camera.width,
                            camera.height, fmt::join(layers, ", "), o.format, describe(device)));
  return 0;
}

}  // namespace

Action render_command(CLI::App& verb) {
  auto o = std::make_shared<RenderVerb>();
  verb.add_option("RUN", o->run, "the run to look at")->required();
  heading(verb, "Output");
  verb.add_option("--out", o->out, "folder for the pictures")->required();
  verb.add_option(
          "--layers", o->layers,
          "list of rgb, alpha, depth, flow (displacement to the canonical volume), rigidity (1 moves, 0 "
          "stays), cluster (parts by how they move), or all of these; with --format exr also RGBA (light "
          "times alpha, no background), Z, forward, backward (pixels to the next and the last frame), "
          "crypto (parts as Cryptomatte)")
      ->capture_default_str();
  verb.add_option(
          "--format", o->format,
          "png, exr (numbers, all layers in one file), mp4 (needs ffmpeg), or cameras: no pictures but "
          "where they would be taken from, cameras.json for Blender and cameras.usda")
      ->type_name("{png,exr,mp4,cameras}")
      ->capture_default_str();
  heading(verb, "Cameras");
  verb.add_option("--camera,--path", o->cameras.camera,
                  "auto, orbit, by the training cameras: stabilised (a film without its shake), interpolate "
                  "(through them), spiral (an ellipse around their mean), held (one of them); data "
                  "(transforms_render.json of the data set), dataset:SPLIT, dataset:SPLIT:INDEX or a "
                  "transforms file; auto: orbit where they surround the scene, else what suits them")
      ->capture_default_str();
  verb.add_option("--times", o->cameras.times,
                  "A:B:N, N model times from A to B in 0..1; default: those of the cameras");
  verb.add_option("--data", o->cameras.data, "the data set, if it is no longer where the run found it");
  verb.add_option("--size", o->cameras.size,
                  "width of pictures: of the orbit, which are square [400], or of other cameras [theirs]")
      ->check(CLI::Range(8, 8192));
  add_antialias(verb, o->antialias);
  verb.add_option("--elevation", o->cameras.elevation, "of the orbit, degrees")
      ->check(decimals_in(-89.0, 89.0))
      ->capture_default_str();
  verb.add_option("--window", o->cameras.window,
                  "of stabilised: share of the film that each camera is fitted to")
      ->check(decimals_in(0.001, 1.0))
      ->capture_default_str();
  heading(verb, kShot);
  verb.add_option(
      "--frames", o->frames.frames,
      "FIRST-LAST: pictures of these frames of a shot, numbered so, with the times of `export --frames`");
  verb.add_option(
      "--at", o->frames.at,
      "of --frames: the frame at which the motion begins, or FIRST-LAST, over which all of it runs");
  verb.add_option("--seconds", o->frames.seconds,
                  "of --frames: how long the whole motion lasts, 0 = to the last")
      ->capture_default_str();
  verb.add_option("--fps", o->frames.fps, "pictures a second of a film or a shot")
      ->check(decimals_in(0.1, 1000.0))
      ->capture_default_str();
  add_otherwise(verb, o->otherwise);
  add_share(verb, o->share);
  add_talk(verb, o->talk);
  add_threads(verb, o->threads);
  add_device(verb, o->device);
  return [o] { return with_threads(o->threads, [&] { return render(*o); }); };
}

}  // namespace splinevox::cli
