// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <filesystem>
#include <memory>

#include "cli/command.hpp"
#include "cli/export_report.hpp"
#include "cli/options.hpp"
#include "core/printable.hpp"
#include "run/run_folder.hpp"
#include "run/signals.hpp"
#include "run/teller.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/io/import_splats.hpp"

namespace splinevox::cli {
namespace {

struct ImportVerb {
  std::string splats, out, box;
  ImportOptions options;
  bool full = false;
  TalkWords talk;
  int threads = 0;
};

/// "x,y,z,X,Y,Z".
std::optional<ImportOptions::Box> parse_box(const std::string& text) {
  if (text.empty()) return {};
  const char* expected = "six numbers, the smaller corner first: x,y,z,X,Y,Z";
  const std::vector<double> v = numbers(text, ',', "--box", expected);
  if (v.size() != 6) fail({"--box", "this is not a box", expected, text, "--box -1,-1,-1,1,1,1"});
  return ImportOptions::Box{{v[0], v[1], v[2]}, {v[3], v[4], v[5]}};
}

void print_line(const ExportedFrame& frame) {
  Json line{{"frame", frame.frame}, {"seconds", frame.seconds}};
  line.update(file_json(frame.file));
  write_event("frame", line);
}

int import_sequence(ImportVerb& o) {
  o.options.box = parse_box(o.box);
  o.options.half = !o.full;
  validate(o.options);
  const std::vector<SplatFrame> frames = splat_frames(o.splats);
  refuse_run_folder(o.out, "an import");
  std::error_code ignored;
  if (std::filesystem::equivalent(o.out, o.splats, ignored))
    fail({o.out, "the splats are in this folder", "a folder of its own", "", "--out " + o.out + "/vdb"});
  o.options.source = whole_path(o.splats).string();
  probe_output_folder(o.out);
  const FolderLock lock(o.out, kWriting);
  catch_stop_signals();
  double bytes = 0, splats = 0, skipped = 0, voxels = 0;
  Teller teller(choose_talk(o.talk.quiet, o.talk.json), "frames");
  const ImportResult result =
      import_splats(frames, o.out, o.options, [&](const ExportedFrame& frame, int done, int total) {
        bytes += double(frame.file.digest.size);
        splats += figure_of(frame.file, "splats");
        skipped += figure_of(frame.file, "splats_skipped");
        voxels += figure_of(frame.file, "density_voxels");
        if (o.talk.json)
          print_line(frame);
        else
          teller.progress(done, total);
        return !stop_asked();
      });
  if (!result.finished) {
    teller.interrupted(
        fmt::format("interrupted after {} frames; the same command begins anew", result.frames.size()),
        {{"frames", result.frames.size()}});
    return kInterrupted;
  }
  const auto count = double(result.frames.size());
  if (teller.text())
    fmt::print("{}: {} frames, {:.1f} MB, profile {}, voxels of {:.4g}\n", o.out, result.frames.size(),
               bytes / 1e6, o.options.profile, result.voxel_size);
  teller.note(fmt::format("{:.0f} splats a frame became {:.0f} voxels", splats / count, voxels / count));
  if (skipped > 0)
    teller.note(fmt::format("{:.0f} splats have numbers that are none and were left out", skipped));
  if (!result.others.empty())
    teller.note(fmt::format(
        "not of this sequence: {} files, {} and so on; delete what a program would load with the folder",
        result.others.size(), printable(result.others.front())));
  if (o.options.profile == "blender")
    teller.note(fmt::format("in Blender: blender -P {}/load_in_blender.py", o.out));
  teller.result({{"out", o.out},
                 {"frames", result.frames.size()},
                 {"bytes", std::int64_t(bytes)},
                 {"profile", o.options.profile},
                 {"voxel_size", result.voxel_size}},
                "");
  return 0;
}

}  // namespace

Action import_command(CLI::App& verb) {
  auto o = std::make_shared<ImportVerb>();
  ImportOptions& i = o->options;
  verb.add_option("SPLATS", o->splats, "a .ply of Gaussian splats, or a folder of them, one a frame")
      ->required();
  heading(verb, "Output");
  verb.add_option("--out", o->out, "folder of the sequence")->required();
  verb.add_option("--profile", i.profile, "whose conventions: blender, houdini, unreal, usd or nanovdb")
      ->capture_default_str();
  verb.add_option("--fps", i.fps, "frames a second")->capture_default_str();
  verb.add_option("--voxel-size", i.voxel_size,
                  "scene units, 0 = the median size of splats, in the first frame that has any")
      ->capture_default_str();
  verb.add_option("--box", o->box, "x,y,z,X,Y,Z: what is outside is left out");
  verb.add_option("--min-alpha", i.min_alpha, "voxels less opaque than this are dropped")
      ->capture_default_str();
  verb.add_option("--colorspace", i.colorspace, "display (values as splats have them) or linear")
      ->capture_default_str();
  verb.add_flag("--full", o->full, "32-bit floats instead of 16");
  verb.add_flag("--afresh", i.afresh, "in place of an export with other settings");
  add_talk(verb, o->talk);
  add_threads(verb, o->threads);
  return [o] { return with_threads(o->threads, [&] { return import_sequence(*o); }); };
}

}  // namespace splinevox::cli
