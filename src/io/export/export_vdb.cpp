// SPDX-License-Identifier: Apache-2.0
#include "splinevox/io/export_vdb.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <filesystem>
#include <mutex>
#include <optional>
#include <set>

#include "core/hash.hpp"
#include "core/in_order.hpp"
#include "core/parallel.hpp"
#include "core/process.hpp"
#include "core/stopwatch.hpp"
#include "io/export/export_carried.hpp"
#include "io/export/export_controls.hpp"
#include "io/export/export_folder.hpp"
#include "io/export/export_frame.hpp"
#include "io/export/export_mesh.hpp"
#include "io/export/export_sidecar.hpp"
#include "io/export/frame_file.hpp"
#include "io/model/exact_text.hpp"
#include "io/splat/voxel_splats.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox {
namespace {

namespace fs = std::filesystem;

constexpr int kExportVersion = 3;  ///< raise it when the same model and options give other bytes
constexpr const char* kControlsName = "motion.vdb";
constexpr double kCopies =
    5;  ///< of a frame's values, at most at once: while it is baked; its grids, OpenVDB's trees, the file
constexpr double kMemoryShare = 0.5;  ///< of the free memory that frames in the making may take

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
ExportInfo describe(const VoxelModel& model, const ExportOptions& o, double spacing, int clusters) {
  const auto text = [](double v) { return exact_text<double>({v}); };
  ExportInfo info{{"export_version", std::to_string(kExportVersion)},
                  {"model", model_hash(model)},
                  {"profile", o.profile},
                  {"at", std::to_string(o.start())},
                  {"fps", text(o.fps)},
                  {"seconds", text(o.length())},
                  {"voxel_size", text(spacing)},
                  {"precision", o.half && find_profile(o.profile).stores_half() ? "half" : "float"},
                  {"bake_view", o.bake_view},
                  {"colorspace", o.colorspace},
                  {"shutter", text(o.shutter)},
                  {"min_alpha", text(o.min_alpha)}};
  if (o.mesh) {
    info["mesh_alpha"] = text(o.mesh_alpha);
    info["mesh_format"] = o.mesh_kind();
  }
  if (o.sh) {
    info["sh_order"] = std::to_string(model.radiance.sh_order);
    info["bake_view"] = "none";
    if (o.mesh) info["mesh_bake_view"] = o.bake_view;
  }
  if (o.flame) info["flame"] = "luminance of the colour times density";
  if (clusters > 0) info["clusters"] = std::to_string(clusters);
  if (!o.run.empty()) info[kExportRun] = o.run;
  return info;
}

/// How many frames may be in the making, if one takes `bytes`: more than threads would be of no use.
int frames_that_fit(double bytes) {
  const double room = kMemoryShare * free_memory();
  return int(std::clamp(room / std::max(bytes, 1.0), 1.0, double(thread_count())));
}

Manifest with_files(Manifest list, const std::vector<ManifestFile>& more) {
  list.files.insert(list.files.end(), more.begin(), more.end());
  return list;
}

/// What one export is about, and how each of its frames comes about.
class Sequence {
 public:
  Sequence(const VoxelModel& model, const std::string& folder, const ExportOptions& options,
           const Lattice& lattice)
      : options_(options),
        profile_(find_profile(options.profile)),
        folder_(folder),
        lattice_(lattice),
        parts_(options.clusters ? std::optional(find_clusters(model, *options.clusters)) : std::nullopt),
        baker_(model, options, parts_ ? &*parts_ : nullptr),
        sh_order_(options.sh ? model.radiance.sh_order : -1),
        info_(describe(model, options, lattice_.spacing, clusters())),
        before_(claim_export_folder(folder, info_, names(), partial_name(options.share), !options.resume)) {}

  int clusters() const { return parts_ ? int(parts_->clusters.size()) : 0; }
  const std::optional<MotionClusters>& parts() const { return parts_; }
  const ExportInfo& info() const { return info_; }
  const Lattice& lattice() const { return lattice_; }
  /// What earlier exports of the same shot left as it should be, and this one does not write: other frames,
  /// and what lies beside them. Throws Error (Fault::input) for points that more frames would leave behind.
  std::vector<ManifestFile> other_files() const {
    std::vector<ManifestFile> files;
    std::set<int> there;
    for (const ManifestFile& file : before_.files) there.insert(frame_of(file));
    bool more = false;
    for (int f = options_.first; f <= options_.last; ++f) more |= !there.contains(f);
    for (const ManifestFile& file : before_.files) {
      const bool points = file.name == kPointsFile;
      if (!is_other(file) || !intact(folder_, file, true)) continue;
      if (points && more && !options_.resume) continue;
      if (points && more)
        fail({.where = (fs::path(folder_) / file.name).string(),
              .what = "has points of the frames that are there, and none of those that would come",
              .expected = "--points as before",
              .got = "none",
              .hint = "--points beside it, another --out, or remove this file"});
      files.push_back(file);
    }
    return files;
  }
  /// What those left as it should be and this one takes over or writes again. Its lists name it until then:
  /// an export that is stopped would forget it. Not points, which more frames leave behind, nor frames of
  /// other shares, which list them.
  std::vector<ManifestFile> files_ahead() const {
    std::vector<ManifestFile> files;
    for (const ManifestFile& file : before_.files) {
      const int f = frame_of(file);
      const bool own = f < 0 || options_.share.holds(f - options_.first);
      if (own && !is_other(file) && file.name != kPointsFile && intact(folder_, file, true))
        files.push_back(file);
    }
    return files;
  }
  const FrameBaker& baker() const { return baker_; }
  double frame_bytes() const { return frame_bytes_; }  ///< memory that the largest frame so far took

  ExportedFrame frame(int i) {
    ExportedFrame out;
    out.frame = options_.first + i;
    out.time = options_.time_at(out.frame);
    if (keep(out)) return out;
    std::call_once(changed_, [&] {  // the list of all is no longer true; one of what is there takes its place
      write_manifest(folder_, {"export", info_, before_.files}, partial_name(options_.share));
      remove_replaced(folder_, before_);
      remove_quietly(folder_, kManifestName);
    });
    const Timer making;
    std::vector<BakedPart> parts =
        baker_.bake(out.time, options_.rate_at(out.frame), options_.mesh_per_frame());
    const Timer writing;
    const double cpu = thread_seconds();
    const std::vector<std::string> prefixes = part_prefixes(clusters());
    std::vector<ManifestFile> files;
    double bytes = 0;
    for (std::size_t c = 0; c < parts.size(); ++c) {
      BakedPart& part = parts[c];
      for (const VdbGrid& grid : part.file.grids)
        bytes += kCopies * double(sizeof(float) * grid.values.size());
      part.file.meta = {{"creator", std::string("splinevox")},       {"fps", options_.fps},
                        {"frame", std::int64_t(out.frame)},          {"time", out.time},
                        {"seconds", options_.seconds_at(out.frame)}, {"model", info_.at("model")}};
      const std::map<std::string, double> which =
          parts_ ? std::map<std::string, double>{{"cluster", double(c)}} : std::map<std::string, double>{};
      part.figures.insert(which.begin(), which.end());
      part.figures["frame"] = out.frame;
      part.figures["time"] = out.time;
      const std::string name = prefixes[c] + frame_name(out.frame, profile_);
      const FileDigest digest =
          write_frame(profile_, path(name), std::move(part.file), sh_order_, part.figures);
      files.push_back({name, digest, std::move(part.figures)});
      if (!options_.mesh_per_frame()) continue;
      const std::string mesh = prefixes[c] + mesh_name(out.frame, options_.mesh_kind());
      files.push_back({mesh,
                       write_file(path(mesh), {options_.mesh_kind() == "obj" ? obj_text(part.mesh)
                                                                             : ply_bytes(part.mesh)}),
                       which});
      auto& figures = files.back().figures;
      figures["frame"] = out.frame;
      figures["time"] = out.time;
      add_size(figures, part.mesh);
    }
    out.file = std::move(files[0]);
    out.beside.assign(std::make_move_iterator(files.begin() + 1), std::make_move_iterator(files.end()));
    out.cpu_writing = thread_seconds() - cpu;
    out.seconds_writing = writing.seconds();
    out.seconds = making.seconds();
    double most = frame_bytes_;
    while (most < bytes && !frame_bytes_.compare_exchange_weak(most, bytes)) {
    }
    return out;
  }

 private:
  std::string path(const std::string& name) const { return (fs::path(folder_) / name).string(); }

  /// Whether a file of an earlier export is none that this one writes.
  bool is_other(const ManifestFile& file) const {
    const int frame = frame_of(file);
    if (frame >= 0) return frame < options_.first || frame > options_.last;
    return (file.name == kPointsFile && !options_.points.any()) ||
           (file.name == kControlsName && !options_.controls);
  }

  /// Of all files that the whole export may write.
  std::vector<std::string> names() const {
    std::vector<std::string> out{sidecar_name(profile_)};
    if (options_.controls) out.push_back(kControlsName);
    if (options_.points.any()) out.push_back(kPointsFile);
    for (const std::string& prefix : part_prefixes(clusters())) {
      if (options_.mesh_carried()) out.push_back(prefix + carried_mesh_file(options_));
      for (int f = options_.first; f <= options_.last; ++f) {
        out.push_back(prefix + frame_name(f, profile_));
        if (options_.mesh_per_frame()) out.push_back(prefix + mesh_name(f, options_.mesh_kind()));
      }
    }
    return out;
  }

  /// Takes over the frame's files if an earlier export left all of them as they should be.
  bool keep(ExportedFrame& out) const {
    if (!options_.resume) return false;
    std::vector<ManifestFile> files;
    for (const std::string& prefix : part_prefixes(clusters()))
      for (const std::string& name :
           {frame_name(out.frame, profile_), mesh_name(out.frame, options_.mesh_kind())}) {
        if (!options_.mesh_per_frame() && name != frame_name(out.frame, profile_)) continue;
        const auto found = std::find_if(
            before_.files.begin(), before_.files.end(),
            [&](const ManifestFile& f) { return f.name == prefix + name && intact(folder_, f); });
        if (found == before_.files.end()) return false;
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
  int sh_order_;  ///< of the harmonics that frames hold; -1: none
  ExportInfo info_;
  EarlierExports before_;
  std::once_flag changed_;
  std::atomic<double> frame_bytes_ = 0;
};

/// @param padding  voxels beyond the lattice that some frame reaches
SequenceFacts facts_of(const VoxelModel& model, const ExportOptions& options, std::vector<int> frames,
                       const Sequence& sequence, int padding) {
  SequenceFacts facts{.frames = std::move(frames),
                      .clusters = sequence.clusters(),
                      .fps = options.fps,
                      .linear = options.colorspace == "linear",
                      .velocity = model.motion.moves(),
                      .flame = options.flame,
                      .sh_order = options.sh ? model.radiance.sh_order : -1,
                      .background = model.background.color};
  const Lattice& lattice = sequence.lattice();
  const float beyond = lattice.spacing * float(padding);
  for (int a = 0; a < 3; ++a) {
    facts.lo[a] = lattice.origin[a] - beyond;
    facts.hi[a] = lattice.origin[a] + lattice.spacing * float(lattice.size[a] - 1) + beyond;
  }
  return facts;
}

}  // namespace

ExportResult export_vdb(const VoxelModel& model, const std::string& folder, const ExportOptions& options,
                        const ExportProgress& progress) {
  validate(options);
  const Lattice lattice = export_lattice(model, options.voxel_size);
  if (options.controls) check_controls(model);  // before hours of frames
  if (options.sh && model.radiance.sh_order < 0)
    fail({.where = "--sh",
          .what = "this model has no view dependence to write",
          .expected = "a model with harmonics",
          .got = "one without",
          .hint = "export without --sh"});
  if (find_profile(options.profile).format == FrameFormat::splat_spz) check_spz_size(lattice.spacing);
  make_export_folder(folder);

  Sequence sequence(model, folder, options, lattice);
  std::vector<int> own;
  for (int i = 0; i < options.count(); ++i)
    if (options.share.holds(i)) own.push_back(i);
  const int total = int(own.size());
  Manifest manifest{"export", sequence.info(), sequence.other_files()};
  std::vector<ManifestFile> ahead = sequence.files_ahead();
  if ((options.mesh_carried() || options.points.any()) && options.share.whole())
    check_carried_room(options, sequence.baker(), frames_in(manifest).size() + std::size_t(options.count()));
  ExportResult result;
  if (sequence.parts()) result.clusters = sequence.parts()->clusters;
  std::vector<ExportedFrame> frames(std::size_t(total), ExportedFrame{});
  const auto work = [&](int i) { frames[std::size_t(i)] = sequence.frame(own[std::size_t(i)]); };
  const auto finish = [&](int i) {
    const ExportedFrame& frame = frames[std::size_t(i)];
    manifest.files.push_back(frame.file);
    manifest.files.insert(manifest.files.end(), frame.beside.begin(), frame.beside.end());
    std::erase_if(ahead, [&](const ManifestFile& file) { return frame_of(file) == frame.frame; });
    if (!frame.kept || !options.share.whole())
      write_manifest(folder, with_files(manifest, ahead), partial_name(options.share));
    result.frames.push_back(frame);
    return !progress || progress(frame, i + 1, total);
  };
  // How many fit is asked again and again: matter may come late. Of the first frame nothing is known.
  constexpr int kBatches = 4;  ///< frames of a thread between two looks
  bool going = true;
  for (int done = 0; going && done < total;) {
    int at_once = options.frames_at_once, batch = total - done;
    if (at_once == 0) {
      const double bytes = sequence.frame_bytes();
      at_once = bytes > 0 ? frames_that_fit(bytes) : 1;
      batch = std::min(batch, bytes > 0 ? kBatches * at_once : 1);
    }
    in_order(
        batch, at_once, [&](int i) { work(done + i); },
        [&](int i) {
          if (!finish(done + i)) going = false;  // and so it stays: what was begun is finished
          return going;
        });
    done += batch;
  }
  result.finished = int(result.frames.size()) == total;
  if (!result.finished || !options.share.whole()) return result;
  if (options.controls)
    manifest.files.push_back(
        {kControlsName, write_controls((fs::path(folder) / kControlsName).string(), model), {}});
  result.carried =
      write_carried(model, folder, options, sequence.baker(), sequence.clusters(), frames_in(manifest));
  manifest.files.insert(manifest.files.end(), result.carried.begin(), result.carried.end());
  sort_by_frame(manifest.files);
  int padding = 1;  // colour reaches a voxel beyond the lattice, velocity further
  for (const ManifestFile& file : manifest.files)
    if (const auto reach = file.figures.find("velocity_padding"); reach != file.figures.end())
      padding = std::max(padding, int(reach->second));
  SequenceFacts facts = facts_of(model, options, frames_in(manifest), sequence, padding);
  facts.layers = usd_layers(manifest.files);
  for (ManifestFile& file : write_sidecar(folder, find_profile(options.profile), facts))
    manifest.files.push_back(std::move(file));
  write_manifest(folder, manifest);
  result.in_folder = frames_in(manifest);
  result.others = other_frames(folder, manifest);
  for (const std::string& name : partial_manifests(folder)) remove_quietly(folder, name);
  return result;
}

}  // namespace splinevox
