// SPDX-License-Identifier: Apache-2.0
#include "cli/export_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <optional>

#include "cli/export_info.hpp"
#include "cli/options.hpp"
#include "core/printable.hpp"
#include "core/process.hpp"
#include "io/export/export_profiles.hpp"
#include "io/export/export_sidecar.hpp"
#include "io/export/what_changes.hpp"
#include "run/support.hpp"

namespace splinevox::cli {
namespace {

/// Figures are all of one kind; the number of a frame is whole.
void add_figures(Json& to, const ManifestFile& file) {
  for (const auto& [key, value] : file.figures)
    if (key == "frame")
      to[key] = std::int64_t(value);
    else
      to[key] = value;
}

std::string untracked_text(const ManifestFile& file) {
  const double share = file.figures.at("untracked_share");
  const char* then =
      file.figures.contains("points") ? ", which primvars:folded says" : " and go with their neighbours";
  return share > 0 ? fmt::format("; {:.1f}% of their ways are lost{}", 100 * share, then) : "";
}

}  // namespace

double figure_of(const ManifestFile& file, const char* name) {
  const auto found = file.figures.find(name);
  return found == file.figures.end() ? 0 : found->second;
}

Json file_json(const ManifestFile& file) {
  Json out{{"file", file.name}, {"bytes", file.digest.size}};
  add_figures(out, file);
  return out;
}

std::string left_over(const std::string& of, const std::vector<std::string>& files) {
  return fmt::format(
      "left by an earlier {} and not of this sequence: {}{}; delete what a program would load with the "
      "folder",
      of, printable(files.front()),
      files.size() > 1 ? fmt::format(" to {} ({} files)", printable(files.back()), files.size()) : "");
}

ExportReport::ExportReport(Talk talk, const ExportOptions& options)
    : teller_(talk, "frames"), options_(options), cpu_(processor_seconds()) {}

void ExportReport::add(const ExportedFrame& f, int done, int total) {
  double voxels = 0;  // of matter
  const auto count = [&](const ManifestFile& file) {
    bytes_ += double(file.digest.size);
    speed_ = std::max(speed_, figure_of(file, "max_speed"));
    short_ = std::max(short_, figure_of(file, "velocity_padding_short"));
    voxels += figure_of(file, "density_voxels");
    wide_ |= file.figures.contains("wider_than_half");
  };
  count(f.file);
  std::for_each(f.beside.begin(), f.beside.end(), count);
  empty_ += f.file.figures.contains("density_voxels") && voxels == 0;
  kept_ += f.kept ? 1 : 0;
  writing_ += f.cpu_writing;
  if (teller_.talk() == Talk::json)
    print_line(f);
  else
    teller_.progress(done, total);
}

void ExportReport::print_line(const ExportedFrame& f) const {
  Json line{{"frame", f.frame},
            {"time", f.time},
            {"file", f.file.name},
            {"bytes", f.file.digest.size},
            {"kept", f.kept}};
  line["seconds"] = f.seconds;
  line["seconds_writing"] = f.seconds_writing;
  line["cpu_writing"] = f.cpu_writing;
  if (options_.clusters) {
    line["files"] = Json::array({file_json(f.file)});
    for (const ManifestFile& file : f.beside) line["files"].push_back(file_json(file));
  } else {
    add_figures(line, f.file);
    for (const ManifestFile& file : f.beside) add_figures(line, file);
  }
  write_event("frame", line);
}

void ExportReport::summarise(const ExportResult& result, const std::string& folder, int processes,
                             const VoxelModel& model) const {
  std::string line = fmt::format("{}: {} frames, {:.1f} MB, profile {}", folder, result.frames.size(),
                                 bytes_ / 1e6, options_.profile);
  if (!options_.share.whole())
    line += fmt::format(", share {} of {}", options_.share.index + 1, options_.share.count);
  if (processes > 1)
    line += fmt::format(", made by {} processes", processes);
  else if (kept_ > 0)
    line += fmt::format(", {} of them were there already", kept_);
  if (speed_ > 0) line += fmt::format(", fastest {:.3g} scene units a second", speed_);
  if (teller_.text()) fmt::print("{}\n", line);
  teller_.note(moments_text(options_));
  if (options_.share.whole())
    explain(result, folder, model);
  else
    teller_.note("when every share is there, the same command without --share finishes the sequence");
  Json carried = Json::array();
  for (const ManifestFile& file : result.carried) carried.push_back(file_json(file));
  teller_.result({{"out", folder},
                  {"frames", result.frames.size()},
                  {"kept", kept_},
                  {"bytes", std::int64_t(bytes_)},
                  {"profile", options_.profile},
                  {"share", {options_.share.index + 1, options_.share.count}},
                  {"others", result.others},
                  {"carried", carried}},
                 "");
}

void ExportReport::explain(const ExportResult& result, const std::string& folder,
                           const VoxelModel& model) const {
  if (result.in_folder.size() > result.frames.size())
    teller_.note(fmt::format("the folder holds {} frames of this shot now: {}", result.in_folder.size(),
                             frames_text(result.in_folder)));
  for (std::size_t c = 0; c < result.clusters.size(); ++c)
    teller_.note(fmt::format(
        "cluster_{}_*: {:.1f}% of the matter, {}", c, 100 * result.clusters[c].share,
        c == 0 ? "stands still" : fmt::format("moves by {:.2f} voxels", result.clusters[c].motion)));
  for (const ManifestFile& file : result.carried) {
    const char* what = file.figures.contains("points") ? "points" : "vertices";
    const double count = file.figures.at(what);
    teller_.note(fmt::format("{}: {:.0f} {} through {:.0f} frames, {:.1f} MB{}", file.name, count, what,
                             file.figures.at("frames"), double(file.digest.size) / 1e6,
                             untracked_text(file)));
  }
  if (empty_ > 0)
    teller_.note(
        fmt::format("{} of {} frames hold no matter{}", empty_, result.frames.size(),
                    empty_ == int(result.frames.size()) ? ": --voxel-size or --min-alpha is too large" : ""));
  if (!result.others.empty()) teller_.note(left_over("export", result.others));
  if (const auto fresh = double(result.frames.size()) - kept_; fresh > 0) {
    const double seconds = timer_.seconds(), used = processor_seconds() - cpu_;
    teller_.note(
        fmt::format("{:.2f} frames a second; {:.2f} s of processor time a frame, {:.0f}% of it writing",
                    fresh / seconds, used / fresh, 100 * writing_ / used));
  }
  if (wide_)
    teller_.note(
        "some grids hold values beyond 65504, the largest of 16-bit floats, or densities too small for them, "
        "and are of 32 bits: in another unit of length (convert --scale) they would be half as large");
  if (short_ > 0)
    teller_.note(fmt::format(
        "motion blur of the fastest matter would need velocities {:.0f} voxels further out than they are "
        "written: a larger --voxel-size or a smaller --shutter gives it whole",
        short_));
  advise(folder, model);
}

void ExportReport::advise(const std::string& folder, const VoxelModel& model) const {
  const bool mean = options_.bake_view == "mean" && options_.colorspace == "display";
  if (model.radiance.sh_order > 0 && mean && !options_.sh && options_.profile != "unreal")
    teller_.note("colours are means over all directions; --sh keeps how they change with the view");
  const std::string changes = what_changes(model.motion);
  if (!changes.empty() && find_profile(options_.profile).velocity)
    teller_.note(fmt::format("nothing moves in this run, {}: the frames have no velocity grid", changes));
  if (const std::optional<double> rate = cameras_rate(folder);
      options_.profile == "usd" && rate && *rate != options_.fps)
    teller_.note(
        fmt::format("cameras.usda in this folder has {} frames a second, and the stage does not show it; "
                    "`render --format "
                    "cameras --fps {}` writes one that it shows",
                    *rate, options_.fps));
  if (options_.profile != "blender") return;
  teller_.note(fmt::format("in Blender: blender -P {}/load_in_blender.py", folder));
  if (model.motion.presence)
    teller_.note(
        "matter comes and goes: add -- --material smoke to light it in your scene, or -- --material fire to "
        "let it give light");
}

}  // namespace splinevox::cli
