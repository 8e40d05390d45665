// SPDX-License-Identifier: Apache-2.0
#include "splinevox/io/export_vdb.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>

#include "core/hash.hpp"
#include "io/exact_text.hpp"
#include "io/export_controls.hpp"
#include "io/export_frame.hpp"
#include "io/export_mesh.hpp"
#include "io/nvdb_write.hpp"
#include "io/usd_stage.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/io/blender_script.hpp"

namespace splinevox {
namespace {

namespace fs = std::filesystem;

constexpr int kExportVersion = 1;  ///< raise it when the same model and options give other bytes
constexpr const char* kScriptName = "load_in_blender.py";
constexpr const char* kStageName = "sequence.usda";
constexpr const char* kControlsName = "motion.vdb";

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

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
  return std::to_string(hash.value());
}

/// Everything that decides the bytes of a frame, and what a reader wants to know about the sequence.
std::map<std::string, std::string> describe(const VoxelModel& model, const ExportOptions& o, double seconds,
                                            double spacing) {
  const auto text = [](double v) { return exact_text<double>({v}); };
  std::map<std::string, std::string> info{{"export_version", std::to_string(kExportVersion)},
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
  return info;
}

std::string numbered(const char* stem, int frame, const char* suffix) {
  std::string digits = std::to_string(frame);
  if (digits.size() < 4) digits.insert(0, 4 - digits.size(), '0');
  return stem + digits + suffix;
}

std::string frame_name(int frame, const ExportProfile& profile) {
  return numbered("frame_", frame, profile.nanovdb ? ".nvdb" : ".vdb");
}
std::string mesh_name(int frame) { return numbered("mesh_", frame, ".ply"); }

/// Frames that an export with the same description listed, whether it ended or was interrupted.
std::vector<ManifestFile> finished_frames(const std::string& folder, const std::map<std::string, std::string>& info) {
  for (const char* name : {kPartialManifestName, kManifestName}) {
    try {
      const Manifest manifest = read_manifest(folder, name);
      if (manifest.kind == "export" && manifest.info == info) return manifest.files;
    } catch (const Error&) {  // none, or not one of ours: nothing is kept
    }
  }
  return {};
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
}

/// Writes what the profile wants beside the frames; nothing if that is nothing.
void write_sidecar(const std::string& folder, const VoxelModel& model, const ExportOptions& o, const Lattice& lattice,
                   Manifest& manifest) {
  const ExportProfile& profile = find_profile(o.profile);
  std::string name, text;
  if (profile.sidecar == ExportSidecar::none) return;
  if (profile.sidecar == ExportSidecar::blender_script) {
    name = kScriptName;
    text = blender_script({o.first, o.last, o.fps, o.colorspace == "linear", model.motion.moves(), model.background});
  } else {
    name = kStageName;
    UsdSequence sequence{.first = o.first, .fps = o.fps, .files = {}, .fields = {}, .lo = {}, .hi = {}};
    for (int f = o.first; f <= o.last; ++f) sequence.files.push_back(frame_name(f, profile));
    sequence.fields = {{profile.density, "float", "None"}, {profile.color, "float3", "Color"}};
    if (model.motion.moves()) sequence.fields.push_back({profile.velocity, "float3", "Vector"});
    for (int a = 0; a < 3; ++a) {  // colour reaches a voxel beyond the lattice
      sequence.lo[a] = lattice.origin[a] - lattice.spacing;
      sequence.hi[a] = lattice.origin[a] + lattice.spacing * float(lattice.size[a]);
    }
    text = usd_stage(sequence);
  }
  manifest.files.push_back({name, write_file((fs::path(folder) / name).string(), {text}), {}});
}

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
  check(o.first >= 0 && o.first <= o.last && o.last < 1'000'000, "--frames", "FIRST-LAST, 0 <= FIRST <= LAST < 1000000",
        std::to_string(o.first) + "-" + std::to_string(o.last));
  check(o.fps > 0 && o.fps <= 1000, "--fps", "a number in (0, 1000]", text(o.fps));
  check(o.seconds >= 0 && std::isfinite(o.seconds), "--seconds", "a number > 0, or 0 for the length of the sequence",
        text(o.seconds));
  check(o.voxel_size >= 0 && std::isfinite(o.voxel_size), "--voxel-size", "a number > 0, or 0 for the model's own",
        text(o.voxel_size));
  check(o.shutter >= 0 && o.shutter <= 2, "--shutter", "a number in [0, 2]", text(o.shutter));
  check(o.min_alpha > 0 && o.min_alpha < 1, "--min-alpha", "a number in (0, 1)", text(o.min_alpha));
  check(!o.mesh || (o.mesh_alpha > o.min_alpha && o.mesh_alpha < 1), "--mesh-alpha",
        "a number between --min-alpha and 1", text(o.mesh_alpha));
  check(o.colorspace == "display" || o.colorspace == "linear", "--colorspace", "display or linear",
        "'" + o.colorspace + "'");
  ViewBake(o.bake_view, 0);
}

ExportResult export_vdb(const VoxelModel& model, const std::string& folder, const ExportOptions& options,
                        const ExportProgress& progress) {
  validate(options);
  const Lattice lattice = export_lattice(model, options.voxel_size);
  const double voxels = double(lattice.size.x) * lattice.size.y * lattice.size.z;
  if (!(voxels <= double(std::int64_t(1) << 33)))
    fail(
        {.where = "--voxel-size",
         .what = "is too small for the model's box",
         .expected = "at most 2^33 voxels in the box",
         .got = exact_text<double>({voxels}),
         .hint = "the model's own voxel size is " + exact_text<float>({model.radiance.raw.topology->lattice.spacing})});
  if (options.controls) check_controls(model);  // before hours of frames
  make_folder(folder);

  const int total = options.last - options.first + 1;
  double seconds = options.seconds > 0 ? options.seconds : (total - 1) / options.fps;
  if (total == 1 && options.seconds <= 0) seconds = 1;
  const auto info = describe(model, options, seconds, lattice.spacing);
  const std::vector<ManifestFile> finished =
      options.resume ? finished_frames(folder, info) : std::vector<ManifestFile>{};
  const auto previous = [&](const std::string& name) {
    const auto at =
        std::find_if(finished.begin(), finished.end(), [&](const ManifestFile& f) { return f.name == name; });
    return at != finished.end() && intact(folder, *at) ? &*at : nullptr;
  };
  const auto path = [&](const std::string& name) { return (fs::path(folder) / name).string(); };

  const ExportProfile& profile = find_profile(options.profile);
  const auto write_frame = profile.nanovdb ? write_nvdb : write_vdb;
  const FrameBaker baker(model, options);
  Manifest manifest{"export", info, {}};
  ExportResult result;
  bool changed = false;
  for (int i = 0; i < total; ++i) {
    ExportedFrame frame;
    frame.frame = options.first + i;
    const double at = i / options.fps / seconds;
    frame.time = std::min(1.0, at);
    const std::string name = frame_name(frame.frame, profile);
    const ManifestFile* old = previous(name);
    const ManifestFile* old_mesh = options.mesh ? previous(mesh_name(frame.frame)) : nullptr;
    if (old && (old_mesh || !options.mesh)) {
      frame.file = *old;
      if (old_mesh) frame.beside = {*old_mesh};
      frame.kept = true;
    } else {
      // From here on the old list is no longer true.
      if (!changed) remove_quietly(fs::path(folder) / kManifestName);
      changed = true;
      const Clock::time_point start = Clock::now();
      BakedFrame baked = baker.bake(frame.time, at <= 1 + 1e-9 ? 1 / seconds : 0);
      baked.file.meta = {{"creator", std::string("splinevox")}, {"fps", options.fps},
                         {"frame", std::int64_t(frame.frame)},  {"time", frame.time},
                         {"seconds", i / options.fps},          {"model", info.at("model")}};
      baked.figures["frame"] = frame.frame;
      baked.figures["time"] = frame.time;
      const Clock::time_point writing = Clock::now();
      frame.file = {name, write_frame(path(name), baked.file), std::move(baked.figures)};
      if (options.mesh) {
        const std::string mesh = mesh_name(frame.frame);
        frame.beside = {{mesh,
                         write_file(path(mesh), {ply_bytes(baked.mesh)}),
                         {{"frame", frame.frame},
                          {"time", frame.time},
                          {"vertices", double(baked.mesh.points.size())},
                          {"triangles", double(baked.mesh.triangles.size())}}}};
      }
      frame.seconds_writing = seconds_since(writing);
      frame.seconds = seconds_since(start);
    }
    manifest.files.push_back(frame.file);
    manifest.files.insert(manifest.files.end(), frame.beside.begin(), frame.beside.end());
    if (!frame.kept) write_manifest(folder, manifest, kPartialManifestName);
    result.frames.push_back(frame);
    if (progress && !progress(frame, i + 1, total) && i + 1 < total) return result;
  }
  if (options.controls) manifest.files.push_back({kControlsName, write_controls(path(kControlsName), model), {}});
  write_sidecar(folder, model, options, lattice, manifest);
  write_manifest(folder, manifest);
  remove_quietly(fs::path(folder) / kPartialManifestName);
  result.finished = true;
  return result;
}

}  // namespace splinevox
