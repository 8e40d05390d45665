// SPDX-License-Identifier: Apache-2.0
#include "splinevox/io/import_splats.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>

#include "core/own_folder.hpp"
#include "core/process.hpp"
#include "core/stopwatch.hpp"
#include "io/check_option.hpp"
#include "io/export/export_folder.hpp"
#include "io/export/export_sidecar.hpp"
#include "io/export/frame_file.hpp"
#include "io/export/leaf_grid.hpp"
#include "io/splat/splat_volume.hpp"
#include "io/vdb/nvdb_write.hpp"
#include "math/srgb.hpp"

namespace splinevox {
namespace {

namespace fs = std::filesystem;

constexpr const char* kImportVersion = "1";  ///< raise it when the same splats and options give other bytes

/// The number that a file's name ends in, or -1.
int number_of(const std::string& path) {
  const std::string stem = fs::path(path).stem().string();
  const std::size_t start = stem.find_last_not_of("0123456789") + 1;
  int number = -1;
  const auto [stop, error] = std::from_chars(stem.data() + start, stem.data() + stem.size(), number);
  return error == std::errc() && number < 1'000'000 ? number : -1;
}

ExportInfo describe(const std::vector<SplatFrame>& frames, const ImportOptions& o, double spacing) {
  const auto text = [](double v) { return exact_text<double>({v}); };
  const int first = frames.front().frame, last = frames.back().frame;
  ExportInfo info{{"import_version", kImportVersion},
                  {"profile", o.profile},
                  {"at", std::to_string(first)},
                  {"fps", text(o.fps)},
                  {"seconds", text(std::max(1, last - first) / o.fps)},
                  {"voxel_size", text(spacing)},
                  {"precision", o.half && find_profile(o.profile).stores_half() ? "half" : "float"},
                  {"colorspace", o.colorspace},
                  {"min_alpha", text(o.min_alpha)},
                  {"splats", o.source}};
  if (o.box)
    info["box"] =
        exact_text<double>({o.box->lo.x, o.box->lo.y, o.box->lo.z, o.box->hi.x, o.box->hi.y, o.box->hi.z});
  return info;
}

/// A frame's grids and what can be counted of them.
VdbFile grids_of(const SplatFile& file, const ImportOptions& o, double spacing,
                 std::map<std::string, double>& figures) {
  const ExportProfile& profile = find_profile(o.profile);
  std::optional<SplatBox> box;
  if (o.box) box = SplatBox{o.box->lo, o.box->hi};
  SplatVolume volume = splat_volume(file, spacing, o.min_alpha, box);
  figures = volume.figures;
  figures["density_voxels"] = double(volume.density.set().count());
  figures["color_voxels"] = double(volume.color.set().count());
  add_box(figures, volume.density.set(), {}, spacing);
  if (o.colorspace == "linear")
    for (float& v : volume.color.values()) v = srgb_to_linear(v);
  VdbFile out;
  out.grids.push_back(to_grid(volume.density, 1, profile.density));
  out.grids.push_back(to_grid(volume.color, 3, profile.color));
  out.grids.back().vector = VdbVector::invariant;
  place_grids(out.grids, {}, spacing, o.half, profile, figures);
  shift_grids(out.grids, profile);
  return out;
}

/// A box around all frames in a list.
void box_of(const Manifest& manifest, double spacing, Vec3& lo, Vec3& hi) {
  bool any = false;
  for (const ManifestFile& file : manifest.files)
    if (file.figures.contains("min_x")) {
      for (int a = 0; a < 3; ++a) {
        const float min = float(file.figures.at(std::string("min_") + "xyz"[a]) - spacing);
        const float max = float(file.figures.at(std::string("max_") + "xyz"[a]) + spacing);
        lo[a] = any ? std::min(lo[a], min) : min;
        hi[a] = any ? std::max(hi[a], max) : max;
      }
      any = true;
    }
}

}  // namespace

std::vector<SplatFrame> splat_frames(const std::string& path) {
  std::error_code ignored;
  std::vector<SplatFrame> frames;
  if (!fs::is_directory(path, ignored)) {
    const int number = number_of(path);
    return {{number < 0 ? 1 : number, path}};
  }
  for (const std::string& name : names_in_folder(path))
    if (name.ends_with(".ply") && !name.starts_with("mesh_"))
      frames.push_back({number_of(name), (fs::path(path) / name).string()});
  if (frames.empty())
    fail({.where = path,
          .what = "holds no splats",
          .expected = "a .ply, or a folder of them, one a frame",
          .got = "no .ply",
          .hint = ""});
  std::sort(frames.begin(), frames.end(), [](const SplatFrame& a, const SplatFrame& b) {
    return a.frame != b.frame ? a.frame < b.frame : a.path < b.path;
  });
  if (frames.front().frame < 0 && frames.back().frame >= 0)
    fail({.where = frames.front().path,
          .what = "has no number, and others have one",
          .expected = "names that end in the number of a frame, or none that do",
          .got = frames.back().path,
          .hint = "move it out of the folder"});
  if (frames.front().frame < 0) {
    std::sort(frames.begin(), frames.end(),
              [](const SplatFrame& a, const SplatFrame& b) { return a.path < b.path; });
    for (std::size_t i = 0; i < frames.size(); ++i) frames[i].frame = int(i) + 1;
  }
  for (std::size_t i = 1; i < frames.size(); ++i)
    if (frames[i].frame == frames[i - 1].frame)
      fail({.where = frames[i].path,
            .what = "has the number of another frame",
            .expected = "names that end in different numbers",
            .got = frames[i - 1].path,
            .hint = "a folder for each sequence"});
  return frames;
}

void validate(const ImportOptions& o) {
  const ExportProfile& profile = find_profile(o.profile);
  if (holds_splats(profile.format))
    fail({.where = "--profile",
          .what = "this profile is splats again",
          .expected = "one that holds grids",
          .got = o.profile,
          .hint = "--profile blender"});
  check_option(profile.format != FrameFormat::nvdb || has_nanovdb(), "--profile",
               "another one: this build is without NanoVDB's headers", o.profile);
  check_option(o.fps > 0 && o.fps <= 1000, "--fps", "a number in (0, 1000]", option_text(o.fps));
  check_option(o.voxel_size >= 0 && std::isfinite(o.voxel_size), "--voxel-size",
               "a number > 0, or 0 for what suits the splats", option_text(o.voxel_size));
  check_option(o.min_alpha > 0 && o.min_alpha < 1, "--min-alpha", "a number in (0, 1)",
               option_text(o.min_alpha));
  check_option(o.colorspace == "display" || o.colorspace == "linear", "--colorspace", "display or linear",
               "'" + o.colorspace + "'");
  for (int a = 0; o.box && a < 3; ++a)
    check_option(o.box->lo[a] < o.box->hi[a], "--box", "corners with the smaller numbers first",
                 option_text(o.box->lo[a]) + " to " + option_text(o.box->hi[a]));
}

ImportResult import_splats(const std::vector<SplatFrame>& frames, const std::string& folder,
                           const ImportOptions& options, const ExportProgress& progress) {
  validate(options);
  if (frames.empty()) fail({.where = "import", .what = "there is no frame", .expected = "files of splats"});
  const ExportProfile& profile = find_profile(options.profile);
  ImportResult result;
  result.voxel_size = options.voxel_size;
  for (std::size_t i = 0; i < frames.size() && !(result.voxel_size > 0); ++i)
    result.voxel_size = splat_spacing(SplatFile(frames[i].path));
  if (!(result.voxel_size > 0)) result.voxel_size = 1;  // there is nothing anywhere
  make_export_folder(folder);
  Manifest manifest{"export", describe(frames, options, result.voxel_size), {}};
  std::vector<std::string> names{sidecar_name(profile)};
  for (const SplatFrame& f : frames) names.push_back(frame_name(f.frame, profile));
  const EarlierExports earlier =
      claim_export_folder(folder, manifest.info, names, kPartialManifestName, options.afresh);
  const int first = frames.front().frame, last = frames.back().frame;
  for (const SplatFrame& f : frames) {
    const Timer making;
    ExportedFrame frame;
    frame.frame = f.frame;
    frame.time = last > first ? double(f.frame - first) / (last - first) : 0;
    VdbFile grids = grids_of(SplatFile(f.path), options, result.voxel_size, frame.file.figures);
    frame.file.figures["frame"] = f.frame;
    frame.file.figures["time"] = frame.time;
    grids.meta = {{"creator", std::string("splinevox")},
                  {"fps", options.fps},
                  {"frame", std::int64_t(f.frame)},
                  {"time", frame.time}};
    frame.file.name = frame_name(f.frame, profile);
    if (result.frames.empty()) {  // a list of all that was there is no longer true
      write_manifest(folder, manifest, kPartialManifestName);
      remove_replaced(folder, earlier);
      remove_quietly(folder, kManifestName);
    }
    const Timer writing;
    const double cpu = thread_seconds();
    frame.file.digest = write_frame(profile, (fs::path(folder) / frame.file.name).string(), std::move(grids),
                                    -1, frame.file.figures);
    frame.cpu_writing = thread_seconds() - cpu;
    frame.seconds_writing = writing.seconds();
    frame.seconds = making.seconds();
    manifest.files.push_back(frame.file);
    write_manifest(folder, manifest, kPartialManifestName);
    result.frames.push_back(std::move(frame));
    if (progress && !progress(result.frames.back(), int(result.frames.size()), int(frames.size())))
      return result;
  }
  result.finished = true;
  SequenceFacts facts{
      .frames = frames_in(manifest), .fps = options.fps, .linear = options.colorspace == "linear"};
  box_of(manifest, result.voxel_size, facts.lo, facts.hi);
  for (ManifestFile& file : write_sidecar(folder, profile, facts)) manifest.files.push_back(std::move(file));
  write_manifest(folder, manifest);
  result.others = other_frames(folder, manifest);
  for (const std::string& name : partial_manifests(folder)) remove_quietly(folder, name);
  return result;
}

}  // namespace splinevox
