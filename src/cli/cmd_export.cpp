// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>

#include "cli/command.hpp"
#include "cli/export_report.hpp"
#include "cli/join_ranks.hpp"
#include "cli/options.hpp"
#include "core/number_text.hpp"
#include "run/points_csv.hpp"
#include "run/run_folder.hpp"
#include "run/shares.hpp"
#include "run/signals.hpp"
#include "run/support.hpp"
#include "splinevox/backend/device.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/field/edit.hpp"
#include "splinevox/io/export_vdb.hpp"
#include "splinevox/run/run.hpp"

namespace splinevox::cli {
namespace {

struct ExportVerb {
  std::string run, out, device = "auto", clusters, points, share;
  FrameWords frames;
  ExportOptions options;
  bool full = false, afresh = false;
  TalkWords talk;
  int threads = 0;
};

/// "auto" or how many.
std::optional<int> parse_clusters(const std::string& text) {
  if (text.empty()) return {};
  if (text == "auto") return 0;
  const std::string expected = fmt::format("auto or a number from 2 to {}", kMostClusters);
  const std::vector<double> v = numbers(text, ',', "--clusters", expected);
  if (v.size() != 1 || v[0] != std::floor(v[0]) || v[0] < 2 || v[0] > kMostClusters)
    fail({"--clusters", "this is not a number of parts", expected, text, "--clusters auto"});
  return int(v[0]);
}

/// How many points, or a table of them.
ExportPoints parse_points(const std::string& text) {
  ExportPoints points;
  if (text.empty()) return points;
  const char* end = text.data() + text.size();
  if (const auto [at, error] = std::from_chars(text.data(), end, points.chosen); at == end) {
    if (error == std::errc() && points.chosen > 0) return points;
    fail({"--points", "this is no number of points", "1 to 2147483647, or a table of points", text, ""});
  }
  PointTable table = read_points(text);
  points.position = std::move(table.position);
  points.time = std::move(table.time);
  for (const std::string& id : table.id) {
    const auto number = parse_number<std::int64_t>(id);
    if (!number)
      fail({text, "USD takes whole numbers for the column id", "numbers, or no such column", id, ""});
    points.id.push_back(*number);
  }
  return points;
}

/// Makes the frames of options.share. @return 0, or the exit code of an interruption
int export_share(const ExportVerb& o, const Run& run, Talk talk, int processes) {
  const FolderLock lock(o.out, kWriting, o.options.share.whole());
  ExportReport report(talk, o.options);
  const ExportResult result =
      export_vdb(run.model, o.out, o.options, [&](const ExportedFrame& frame, int done, int total) {
        report.add(frame, done, total);
        return !stop_asked();
      });
  if (!result.finished && stop_asked()) {
    Teller(talk).interrupted(
        fmt::format("interrupted after {} frames; the same command goes on from there", result.frames.size()),
        {{"frames", result.frames.size()}});
    return kInterrupted;
  }
  report.summarise(result, o.out, processes, run.model);
  return 0;
}

/// Each process its own share of the frames, and then the first what makes them a sequence.
int export_together(ExportVerb& o, const Run& run, Talk talk, Ranks& ranks) {
  o.options.share = {ranks.rank(), ranks.count()};
  const bool bar = ranks.first() && talk == Talk::bar;
  const double mine = export_share(o, run, bar ? talk : Talk::quiet, 1);
  const std::vector<double> codes = ranks.gather({&mine, 1});  // returns when all have ended
  const double code = *std::max_element(codes.begin(), codes.end());
  if (code != 0 || !ranks.first()) return int(code);
  o.options.share = {};
  o.options.resume = true;
  return export_share(o, run, bar ? Talk::lines : talk, ranks.count());
}

int export_run(ExportVerb& o) {
  if (o.device == "cuda") fail({"--device", "frames are baked on the CPU only", "auto or cpu", o.device, ""});
  choose_device(o.device);
  static_cast<FrameRange&>(o.options) = frame_range(o.frames);
  o.options.clusters = parse_clusters(o.clusters);
  o.options.points = parse_points(o.points);
  o.options.half = !o.full;
  o.options.resume = !o.afresh;
  if (!o.share.empty()) o.options.share = chosen_share(o.share);
  validate(o.options);
  const std::unique_ptr<Ranks> ranks = o.share.empty() ? join_ranks("export") : nullptr;
  const Run run = open_run(o.run);
  refuse_run_folder(o.out, "an export");
  o.options.run = whole_path(o.run).string();
  probe_output_folder(o.out);
  catch_stop_signals();
  const Talk talk = choose_talk(o.talk.quiet, o.talk.json);
  if (ranks) return export_together(o, run, talk, *ranks);
  return export_share(o, run, talk, 1);
}

}  // namespace

Action export_command(CLI::App& verb) {
  auto o = std::make_shared<ExportVerb>();
  ExportOptions& e = o->options;
  verb.add_option("RUN", o->run, "the run to export")->required();
  heading(verb, "Output");
  verb.add_option("--out", o->out, "folder of the sequence")->required();
  verb.add_option("--profile", e.profile, "whose conventions")
      ->type_name(fmt::format("{{{}}}", fmt::join(export_profiles(), ",")))
      ->capture_default_str();
  add_frames(verb, o->frames);
  heading(verb, "Voxels");
  verb.add_option("--voxel-size", e.voxel_size, "scene units, 0 = the model's own")->capture_default_str();
  verb.add_option("--bake-view", e.bake_view,
                  "colour of a voxel: mean (over all directions), none or dir=x,y,z (as seen in this "
                  "direction: 0,0,-1 looks down)")
      ->capture_default_str();
  verb.add_flag("--sh", e.sh,
                "also sh0, sh1, ...: harmonics, with which load_in_blender.py shows the colours change with "
                "the view; color is then positional");
  verb.add_option("--colorspace", e.colorspace, "display (values as in the pictures) or linear")
      ->capture_default_str();
  verb.add_flag("--flame", e.flame,
                "also flame: luminance of the colour times density, what a voxel of fire gives off");
  verb.add_option("--shutter", e.shutter, "share of a frame it is open: how far velocity is continued")
      ->capture_default_str();
  verb.add_option("--min-alpha", e.min_alpha, "voxels less opaque than this are dropped")
      ->capture_default_str();
  verb.add_flag("--full", o->full, "32-bit floats instead of 16");
  heading(verb, "More files");
  verb.add_option(
      "--clusters", o->clusters,
      "K or auto: files of their own for each part that moves alike; together they are the whole");
  verb.add_flag(
      "--mesh", e.mesh,
      "also mesh_0001.ply and so on: the surface of every frame, with its colours; in the profile usd "
      "one that moves");
  verb.add_option(
          "--mesh-format", e.mesh_format,
          "ply (binary), obj (text, colours behind each vertex), or one surface that the motion carries "
          "through all frames: glb (mesh.glb) or usd (mesh.usda); auto: usd with the profile usd, whose "
          "stage shows it, else ply")
      ->capture_default_str();
  verb.add_option("--points", o->points,
                  "also points.usda: points that the motion carries, N of the first frame's surface or those "
                  "of a table as in `track`; the profile usd shows them in its stage");
  verb.add_flag("--controls", e.controls,
                "also motion.vdb: control points and rigidity as grids, to build a rig on");
  verb.add_option("--mesh-alpha", e.mesh_alpha, "opacity of a voxel where that surface runs")
      ->capture_default_str();
  heading(verb, "How it is made");
  verb.add_flag(
      "--afresh", o->afresh,
      "write frames again that an earlier export finished, and in place of one with other settings");
  verb.add_option("--frames-at-once", e.frames_at_once,
                  "frames in the making at a time, 0 = what threads and free memory allow")
      ->capture_default_str();
  add_share(verb, o->share);
  add_talk(verb, o->talk);
  add_threads(verb, o->threads);
  verb.add_option("--device", o->device, "auto or cpu: frames are baked on the CPU")
      ->group(kMachine)
      ->capture_default_str();
  return [o] { return with_threads(o->threads, [&] { return export_run(*o); }); };
}

}  // namespace splinevox::cli
