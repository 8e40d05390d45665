// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>

#include "cli/command.hpp"
#include "cli/options.hpp"
#include "run/teller.hpp"
#include "run/truth_volumes.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/data/synth.hpp"

namespace splinevox::cli {

Action synth_command(CLI::App& verb) {
  struct Options {
    std::string scene, out;
    SynthOptions synth;
    int threads = 0;
    TalkWords talk;
  };
  auto o = std::make_shared<Options>();
  verb.add_option("SCENE", o->scene, "which scene")
      ->required()
      ->type_name(fmt::format("{{{}}}", fmt::join(synth_scenes(), ",")));
  heading(verb, "Pictures");
  verb.add_option("--out", o->out, "folder of the data set")->required();
  verb.add_option("--frames", o->synth.frames, "training pictures, each at its own time")
      ->capture_default_str();
  verb.add_option("--size", o->synth.size, "width and height of every picture, pixels")
      ->capture_default_str();
  verb.add_option("--seed", o->synth.seed, "of the training cameras")->capture_default_str();
  heading(verb, "One camera");
  verb.add_option(
          "--orbit", o->synth.orbit,
          "training cameras are one that goes around so often over time, as of a film; 0: each anywhere")
      ->check(decimals_in(-100.0, 100.0));
  verb.add_flag(
          "--film", o->synth.film,
          "with --orbit: val pictures lie on the camera's way, test pictures are from elsewhere on it, a "
          "little higher")
      ->needs("--orbit");
  verb.add_option(
          "--shake", o->synth.shake,
          "with --film: held by hand; share of its distance by which the camera wanders, and radians by "
          "which it turns")
      ->check(decimals_in(0.0, 0.2))
      ->needs("--film");
  verb.add_option("--drift", o->synth.drift,
                  "exposures of training cameras drift, up to so much brighter; of a film or a rig")
      ->check(decimals_in(0.0, 0.5));
  heading(verb, "Look");
  verb.add_option("--gloss", o->synth.look.gloss, "strength of a highlight that follows the eye")
      ->check(decimals_in(0.0, 1.0));
  verb.add_option("--fade", o->synth.look.fade, "share of the light that is gone at the end")
      ->check(decimals_in(0.0, 1.0));
  verb.add_option("--light", o->synth.look.light, "brightness of everything")
      ->check(decimals_in(0.0, 1.0))
      ->capture_default_str();
  verb.add_option("--repeats", o->synth.look.repeats, "how often the motion runs, there and back in turn")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  verb.add_flag("--opaque", o->synth.look.opaque, "pictures without alpha, a grey wall behind the scene");
  verb.add_flag("--room", o->synth.look.room,
                "a room with things in it around the scene and the cameras, no alpha");
  SynthRig& rig = o->synth.rig;
  heading(verb, "A rig of cameras");
  verb.add_option(
          "--cameras", rig.cameras,
          "a rig: so many cameras that stand still and see every one of --frames moments; test pictures are "
          "of two others")
      ->check(CLI::Range(2, 100));
  const auto of_rig = [&](CLI::Option* option) { option->needs("--cameras"); };
  of_rig(verb.add_option("--arc", rig.arc, "how much of the ring its cameras stand along; 1: all around")
             ->check(decimals_in(0.01, 1.0)));
  of_rig(verb.add_flag("--turns", rig.turns, "its cameras take turns, one a moment"));
  of_rig(verb.add_option("--exposures", rig.exposures,
                         "gains of its training cameras' channels, drawn from 1 minus to 1 plus this; their "
                         "geometric mean is 1")
             ->check(decimals_in(0.0, 0.5)));
  of_rig(
      verb.add_option("--offsets", rig.late,
                      "one training camera in eight, the second first, is late by so many intervals between "
                      "moments")
          ->check(decimals_in(-2.0, 2.0)));
  heading(verb, "Beside the pictures");
  verb.add_flag("--masks", rig.masks, "a mask of every picture, white where the subject is (mask_path)");
  verb.add_flag("--movers", rig.movers, "with --masks: they are white where something moves at some time")
      ->needs("--masks");
  verb.add_flag("--tracks", o->synth.tracks,
                "tracks.npy: points of surfaces, followed through the training pictures (tracks_file_path)");
  verb.add_option(
          "--depth", o->synth.depth,
          "a depth map of every training picture (depth_file_path): metric is the true depth; relative and "
          "inverse are that, or one over it, but for a scale and a shift drawn for every picture")
      ->transform(CLI::CheckedTransformer(std::map<std::string, DepthKind>{
          {"metric", DepthKind::metric}, {"relative", DepthKind::relative}, {"inverse", DepthKind::inverse}}))
      ->type_name("{metric,relative,inverse}");
  add_talk(verb, o->talk);
  add_threads(verb, o->threads);
  return [o] {
    const SynthScene scene =
        SynthScene::open(o->scene, o->synth.look);  // a wrong name is found before a folder is made
    probe_output_folder(o->out);
    if (!std::filesystem::is_empty(o->out))  // another data set's transforms files have the same names
      fail({o->out, "this folder is not empty", "an empty folder, or a name that is free", "",
            "another folder for --out"});
    return with_threads(o->threads, [&] {
      Teller teller(choose_talk(o->talk.quiet, o->talk.json));
      write_synth(o->scene, o->out, o->synth, [&](int done, int total) { teller.progress(done, total); });
      if (scene.has_gas()) {
        std::vector<double> moments;
        for (int i = 0; i < o->synth.frames; ++i) moments.push_back(double(i) / (o->synth.frames - 1));
        write_truth_volumes(o->out + "/truth_volume", scene, moments);
      }
      const int pictures = o->synth.frames * (o->synth.rig.turns ? 1 : std::max(1, o->synth.rig.cameras));
      teller.result(
          {{"out", o->out}, {"scene", o->scene}, {"training_pictures", pictures}, {"size", o->synth.size}},
          fmt::format("{}: scene {}, {} training pictures of {}x{}", o->out, o->scene, pictures,
                      o->synth.size, o->synth.size));
      return 0;
    });
  };
}

}  // namespace splinevox::cli
