// SPDX-License-Identifier: Apache-2.0
#include "splinevox/io/export_vdb.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <mutex>
#include <optional>
#include <set>

#include "core/hash.hpp"
#include "core/in_order.hpp"
#include "core/own_folder.hpp"
#include "core/parallel.hpp"
#include "core/process.hpp"
#include "io/export/export_controls.hpp"
#include "io/export/export_frame.hpp"
#include "io/export/export_mesh.hpp"
#include "io/export/export_sidecar.hpp"
#include "io/model/exact_text.hpp"
#include "io/vdb/nvdb_write.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox {
namespace {

namespace fs = std::filesystem;

constexpr int kExportVersion = 1;  ///< raise it when the same model and options give other bytes
constexpr const char* kControlsName = "motion.vdb";
constexpr double kCopies =
    5;  ///< of a frame's values, at most at once: while it is baked; its grids, OpenVDB's trees, the file
constexpr double kMemoryShare = 0.5;  ///< of the free memory that frames in the making may take

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

void add(Hash64& hash, const Channels& channels) {
  const Topology& t = *channels.topology;
  hash.add(&t.lattice, sizeof t.lattice);
  hash.add(t.bricks.data(), t.bricks.size() * sizeof t.bricks[0]);
  hash.add(channels.values.data(), channels.values.size() * sizeof(float));
}

std::string model_hash(const VoxelModel& m) {
  Hash64 hash;
  hash.add(&m.box, sizeof m.box);
  hash.add(&m.radiance.activation, sizeof m.radiance.activation);
  add(hash, m.radiance.raw);
  const int shape[] = {m.radiance.sh_order,       int(m.motion.basis),    m.motion.points,
                       int(m.motion.first_point), int(m.motion.rigidity), int(m.motion.light)};
  hash.add(shape, sizeof shape);
  hash.add(&m.motion.rigidity_offset, sizeof m.motion.rigidity_offset);
  for (const TimeCurve::Knot& k : m.motion.time_curve.knots) hash.add(&k, sizeof k);
  for (const Channels& level : m.motion.levels) add(hash, level);
  if (m.motion.presence) hash.add(&m.motion.presence, sizeof m.motion.presence);
  return std::to_string(hash.value());
}

/// Everything that decides the bytes of a frame, and what a reader wants to know about the sequence.
std::map<std::string, std::string> describe(const VoxelModel& model, const ExportOptions& o, double seconds,
                                            double spacing, int clusters) {
  const auto text = [](double v) { return exact_text<double>({v}); };
  std::map<std::string, std::string> info{
      {"export_version", std::to_string(kExportVersion)},
      {"model", model_hash(model)},
      {"profile", o.profile},
      {"first", std::to_string(o.first)},
      {"fps", text(o.fps)},
      {"seconds", text(seconds)},
      {"voxel_size", text(spacing)},
      {"precision", o.half && !find_profile(o.profile).nanovdb ? "half" : "float"},
      {"bake_view", o.bake_view},
      {"colorspace", o.colorspace},
      {"shutter", text(o.shutter)},
      {"min_alpha", text(o.min_alpha)}};
  if (o.mesh) info["mesh_alpha"] = text(o.mesh_alpha);
  if (o.sh) {
    info["sh_order"] = std::to_string(model.radiance.sh_order);
    info["bake_view"] = "none";
  }
  if (o.flame) info["flame"] = "luminance of the colour times density";
  if (clusters > 0) info["clusters"] = std::to_string(clusters);
  return info;
}

/// Frames that exports with the same description listed, whether they ended or were interrupted, of the whole
/// or of shares.
std::vector<ManifestFile> finished_frames(const std::string& folder,
                                          const std::map<std::string, std::string>& info) {
  std::vector<std::string> names = partial_manifests(folder);
  names.push_back(kManifestName);
  std::vector<ManifestFile> files;
  for (const std::string& name : names) {
    try {
      const Manifest manifest = read_manifest(folder, name);
      if (manifest.kind == "export" && manifest.info == info)
        files.insert(files.end(), manifest.files.begin(), manifest.files.end());
    } catch (const Error&) {  // none, or not one of ours: nothing is kept
    }
  }
  return files;
}

std::string partial_name(const Share& share) {
  if (share.whole()) return kPartialManifestName;
  return "manifest.partial." + std::to_string(share.index + 1) + "of" + std::to_string(share.count) + ".json";
}

bool intact(const std::string& folder, const ManifestFile& file) {
  try {
    return manifest_entry(folder, file.name).digest == file.digest;
  } catch (const Error&) {
    return false;
  }
}

void remove_quietly(const fs::path& path) {
  std::error_code ignored;
  fs::remove(path, ignored);
}

void make_folder(const std::string& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error || !fs::is_directory(folder))
    fail_output({.where = folder,
                 .what = "is not a folder and cannot be made one",
                 .expected = "a folder to write to",
                 .got = error ? error.message() : "a file",
                 .hint = "choose another --out"});
  check_own_folder(folder, Depth::entries);
}

/// Names in the folder that are frames' by their beginning and not in the list: who loads the folder as a
/// sequence would load them too.
std::vector<std::string> other_frames(const std::string& folder, const Manifest& manifest) {
  std::set<std::string> listed;
  for (const ManifestFile& file : manifest.files) listed.insert(file.name);
  std::vector<std::string> others;
  for (const std::string& name : names_in_folder(folder)) {
    const bool frame =
        name.starts_with("frame_") || name.starts_with("mesh_") || name.starts_with("cluster_");
    if (frame && listed.count(name) == 0) others.push_back(name);
  }
  std::sort(others.begin(), others.end());
  return others;
}

/// How many frames may be in the making, if one takes `bytes`: more than threads would be of no use.
int frames_that_fit(double bytes) {
  const double room = kMemoryShare * free_memory();
  return int(std::clamp(room / std::max(bytes, 1.0), 1.0, double(thread_count())));
}

/// What one export is about, and how each of its frames comes about.
class Sequence {
 public:
  Sequence(const VoxelModel& model, const std::string& folder, const ExportOptions& options)
      : options_(options),
        profile_(find_profile(options.profile)),
        folder_(folder),
        lattice_(export_lattice(model, options.voxel_size)),
        parts_(options.clusters ? std::optional(find_clusters(model, *options.clusters)) : std::nullopt),
        baker_(model, options, parts_ ? &*parts_ : nullptr),
        seconds_(options.seconds > 0 ? options.seconds
                 : total() > 1       ? (total() - 1) / options.fps
                                     : 1),
        info_(describe(model, options, seconds_, lattice_.spacing, clusters())),
        finished_(options.resume ? finished_frames(folder, info_) : std::vector<ManifestFile>{}) {}

  int total() const { return options_.last - options_.first + 1; }
  int clusters() const { return parts_ ? int(parts_->clusters.size()) : 0; }
  const std::optional<MotionClusters>& parts() const { return parts_; }
  const std::map<std::string, std::string>& info() const { return info_; }
  const Lattice& lattice() const { return lattice_; }
  double frame_bytes() const { return frame_bytes_; }  ///< memory that the last written frame took

  ExportedFrame frame(int i) {
    ExportedFrame out;
    out.frame = options_.first + i;
    const double shown = i / options_.fps, at = shown / seconds_;
    out.time = std::min(1.0, at);
    if (keep(out)) return out;
    std::call_once(changed_, [&] {
      remove_quietly(fs::path(folder_) / kManifestName);
    });  // the old list is no longer true
    const Clock::time_point start = Clock::now();
    std::vector<BakedPart> parts = baker_.bake(out.time, at <= 1 + 1e-9 ? 1 / seconds_ : 0);
    const Clock::time_point writing = Clock::now();
    const double cpu = thread_seconds();
    const std::vector<std::string> prefixes = part_prefixes(clusters());
    std::vector<ManifestFile> files;
    double bytes = 0;
    for (std::size_t c = 0; c < parts.size(); ++c) {
      BakedPart& part = parts[c];
      for (const VdbGrid& grid : part.file.grids)
        bytes += kCopies * double(sizeof(float) * grid.values.size());
      part.file.meta = {{"creator", std::string("splinevox")},
                        {"fps", options_.fps},
                        {"frame", std::int64_t(out.frame)},
                        {"time", out.time},
                        {"seconds", shown},
                        {"model", info_.at("model")}};
      const std::map<std::string, double> which =
          parts_ ? std::map<std::string, double>{{"cluster", double(c)}} : std::map<std::string, double>{};
      part.figures.insert(which.begin(), which.end());
      part.figures["frame"] = out.frame;
      part.figures["time"] = out.time;
      const std::string name = prefixes[c] + frame_name(out.frame, profile_);
      files.push_back({name, (profile_.nanovdb ? write_nvdb : write_vdb)(path(name), std::move(part.file)),
                       std::move(part.figures)});
      if (!options_.mesh) continue;
      const std::string mesh = prefixes[c] + mesh_name(out.frame, options_.mesh_format);
      files.push_back({mesh,
                       write_file(path(mesh), {options_.mesh_format == "obj" ? obj_text(part.mesh)
                                                                             : ply_bytes(part.mesh)}),
                       which});
      auto& figures = files.back().figures;
      figures["frame"] = out.frame;
      figures["time"] = out.time;
      figures["vertices"] = double(part.mesh.points.size());
      figures["triangles"] = double(part.mesh.triangles.size());
    }
    out.file = std::move(files[0]);
    out.beside.assign(std::make_move_iterator(files.begin() + 1), std::make_move_iterator(files.end()));
    out.cpu_writing = thread_seconds() - cpu;
    out.seconds_writing = seconds_since(writing);
    out.seconds = seconds_since(start);
    frame_bytes_ = bytes;
    return out;
  }

 private:
  std::string path(const std::string& name) const { return (fs::path(folder_) / name).string(); }

  /// Takes over the frame's files if an earlier export left all of them as they should be.
  bool keep(ExportedFrame& out) const {
    std::vector<ManifestFile> files;
    for (const std::string& prefix : part_prefixes(clusters()))
      for (const std::string& name :
           {frame_name(out.frame, profile_), mesh_name(out.frame, options_.mesh_format)}) {
        if (!options_.mesh && name != frame_name(out.frame, profile_)) continue;
        const auto found = std::find_if(finished_.begin(), finished_.end(), [&](const ManifestFile& f) {
          return f.name == prefix + name && intact(folder_, f);
        });
        if (found == finished_.end()) return false;
        files.push_back(*found);
      }
    out.file = files[0];
    out.beside.assign(files.begin() + 1, files.end());
    return out.kept = true;
  }

  const ExportOptions& options_;
  const ExportProfile& profile_;
  std::string folder_;
  Lattice lattice_;
  std::optional<MotionClusters> parts_;
  FrameBaker baker_;
  double seconds_;  ///< how long model time 0..1 lasts
  std::map<std::string, std::string> info_;
  std::vector<ManifestFile> finished_;
  std::once_flag changed_;
  std::atomic<double> frame_bytes_ = 0;
};

}  // namespace

void validate(const ExportOptions& o) {
  const auto check = [](bool ok, const char* option, const char* expected, const std::string& got) {
    if (!ok) fail({.where = option, .what = "is out of range", .expected = expected, .got = got, .hint = ""});
  };
  const auto text = [](double v) { return std::isfinite(v) ? exact_text<double>({v}) : std::to_string(v); };
  if (find_profile(o.profile).nanovdb && !has_nanovdb())
    fail({.where = "--profile",
          .what = "nanovdb is not in this build",
          .expected = "a build made where NanoVDB's headers are",
          .got = "a build without them",
          .hint = "install libnanovdb-dev, configure and build again, or choose another profile"});
  check(o.first >= 0 && o.first <= o.last && o.last < 1'000'000, "--frames",
        "FIRST-LAST, 0 <= FIRST <= LAST < 1000000", std::to_string(o.first) + "-" + std::to_string(o.last));
  check(o.share.count >= 1 && o.share.index >= 0 && o.share.index < o.share.count, "--share",
        "K/N, 1 <= K <= N", std::to_string(o.share.index + 1) + "/" + std::to_string(o.share.count));
  check(o.fps > 0 && o.fps <= 1000, "--fps", "a number in (0, 1000]", text(o.fps));
  check(o.seconds >= 0 && std::isfinite(o.seconds), "--seconds",
        "a number > 0, or 0 for the length of the sequence", text(o.seconds));
  check(o.voxel_size >= 0 && std::isfinite(o.voxel_size), "--voxel-size",
        "a number > 0, or 0 for the model's own", text(o.voxel_size));
  check(o.shutter >= 0 && o.shutter <= 2, "--shutter", "a number in [0, 2]", text(o.shutter));
  check(o.min_alpha > 0 && o.min_alpha < 1, "--min-alpha", "a number in (0, 1)", text(o.min_alpha));
  check(!o.mesh || (o.mesh_alpha > o.min_alpha && o.mesh_alpha < 1), "--mesh-alpha",
        "a number between --min-alpha and 1", text(o.mesh_alpha));
  check(o.colorspace == "display" || o.colorspace == "linear", "--colorspace", "display or linear",
        "'" + o.colorspace + "'");
  ViewBake(o.bake_view, 0);
  check(!o.mesh || o.mesh_format == "ply" || o.mesh_format == "obj", "--mesh-format", "ply or obj",
        "'" + o.mesh_format + "'");
  check(!o.sh || o.bake_view == "mean" || o.bake_view == "none", "--bake-view",
        "no direction beside --sh, which leaves the view to the renderer", "'" + o.bake_view + "'");
  check(!o.sh || o.colorspace == "display", "--colorspace",
        "display beside --sh: the harmonics scale display values", "'" + o.colorspace + "'");
  if (o.sh && o.profile == "unreal")
    fail({.where = "--sh",
          .what = "a Sparse Volume Texture has no room for harmonics",
          .expected = "another profile",
          .got = "unreal",
          .hint = "leave --sh away"});
  if (o.flame && !find_profile(o.profile).flame)
    fail({.where = "--flame",
          .what = "a Sparse Volume Texture of density and colour has no room for it",
          .expected = "another profile",
          .got = o.profile,
          .hint = "leave --flame away"});
  const int clusters = o.clusters.value_or(0);
  check(clusters == 0 || (clusters >= 2 && clusters <= 16), "--clusters", "auto or a number from 2 to 16",
        std::to_string(clusters));
  check(o.frames_at_once >= 0 && o.frames_at_once <= 1024, "--frames-at-once",
        "a number from 1 to 1024, or 0 for what suits the machine", std::to_string(o.frames_at_once));
}

ExportResult export_vdb(const VoxelModel& model, const std::string& folder, const ExportOptions& options,
                        const ExportProgress& progress) {
  validate(options);
  const Lattice lattice = export_lattice(model, options.voxel_size);
  const double voxels = double(lattice.size.x) * lattice.size.y * lattice.size.z;
  if (!(voxels <= double(std::int64_t(1) << 33)))
    fail({.where = "--voxel-size",
          .what = "is too small for the model's box",
          .expected = "at most 2^33 voxels in the box",
          .got = exact_text<double>({voxels}),
          .hint = "the model's own voxel size is " +
                  exact_text<float>({model.radiance.raw.topology->lattice.spacing})});
  if (options.controls) check_controls(model);  // before hours of frames
  if (options.sh && model.radiance.sh_order < 0)
    fail({.where = "--sh",
          .what = "this model has no view dependence to write",
          .expected = "a model with harmonics",
          .got = "one without",
          .hint = "export without --sh"});
  make_folder(folder);

  Sequence sequence(model, folder, options);
  std::vector<int> own;
  for (int i = 0; i < sequence.total(); ++i)
    if (options.share.holds(i)) own.push_back(i);
  const int total = int(own.size());
  Manifest manifest{"export", sequence.info(), {}};
  ExportResult result;
  if (sequence.parts()) result.clusters = sequence.parts()->clusters;
  std::vector<ExportedFrame> frames(std::size_t(total), ExportedFrame{});
  const auto work = [&](int i) { frames[std::size_t(i)] = sequence.frame(own[std::size_t(i)]); };
  const auto finish = [&](int i) {
    const ExportedFrame& frame = frames[std::size_t(i)];
    manifest.files.push_back(frame.file);
    manifest.files.insert(manifest.files.end(), frame.beside.begin(), frame.beside.end());
    if (!frame.kept || !options.share.whole()) write_manifest(folder, manifest, partial_name(options.share));
    result.frames.push_back(frame);
    return !progress || progress(frame, i + 1, total);
  };
  int done = 0, at_once = options.frames_at_once;
  bool going = true;
  for (; at_once == 0 && going && done < total && sequence.frame_bytes() == 0; ++done) {
    work(done);
    going = finish(done);
  }
  if (at_once == 0) at_once = frames_that_fit(sequence.frame_bytes());
  if (going)
    in_order(
        total - done, at_once, [&](int i) { work(done + i); }, [&](int i) { return finish(done + i); });
  result.finished = int(result.frames.size()) == total;
  if (!result.finished || !options.share.whole()) return result;
  if (options.controls)
    manifest.files.push_back(
        {kControlsName, write_controls((fs::path(folder) / kControlsName).string(), model), {}});
  int padding = 1;  // colour reaches a voxel beyond the lattice, velocity further
  for (const ManifestFile& file : manifest.files)
    if (const auto reach = file.figures.find("velocity_padding"); reach != file.figures.end())
      padding = std::max(padding, int(reach->second));
  for (ManifestFile& file :
       write_sidecar(folder, model, options, sequence.lattice(), sequence.clusters(), padding))
    manifest.files.push_back(std::move(file));
  write_manifest(folder, manifest);
  result.others = other_frames(folder, manifest);
  for (const std::string& name : partial_manifests(folder)) remove_quietly(fs::path(folder) / name);
  return result;
}

}  // namespace splinevox
