// SPDX-License-Identifier: Apache-2.0
#include "io/export/export_sidecar.hpp"

#include <filesystem>

#include "core/atomic_file.hpp"
#include "io/export/blender_script.hpp"
#include "io/export/usd_stage.hpp"

namespace splinevox {
namespace {

constexpr const char* kScriptName = "load_in_blender.py";
constexpr const char* kStageName = "sequence.usda";

std::string numbered(const char* stem, int frame, const std::string& suffix) {
  std::string digits = std::to_string(frame);
  if (digits.size() < 4) digits.insert(0, 4 - digits.size(), '0');
  return stem + digits + suffix;
}

std::string script(const VoxelModel& model, const ExportOptions& o, const SequenceFiles& files) {
  return blender_script({.first = files.frames.front(),
                         .last = files.frames.back(),
                         .fps = o.fps,
                         .linear = o.colorspace == "linear",
                         .velocity = model.motion.moves(),
                         .background = model.background.color,
                         .prefixes = part_prefixes(files.clusters),
                         .sh_order = o.sh ? model.radiance.sh_order : -1});
}

std::string stage(const VoxelModel& model, const ExportOptions& o, const SequenceFiles& files,
                  const Lattice& lattice, int padding) {
  const ExportProfile& profile = find_profile(o.profile);
  UsdSequence sequence{.frames = files.frames, .fps = o.fps, .volumes = {}, .fields = {}, .lo = {}, .hi = {}};
  for (const std::string& prefix : part_prefixes(files.clusters)) {
    UsdVolume volume{prefix.substr(0, prefix.size() - (prefix.empty() ? 0 : 1)), {}};
    for (const int f : files.frames) volume.files.push_back(prefix + frame_name(f, profile));
    sequence.volumes.push_back(std::move(volume));
  }
  sequence.fields = {{profile.density, "float", "None"}, {profile.color, "float3", "Color"}};
  if (o.sh)
    for (int k = 0; 3 * k < model.radiance.sh_count(); ++k)
      sequence.fields.push_back({"sh" + std::to_string(k), "float3", "None"});
  if (o.flame) sequence.fields.push_back({profile.flame, "float", "None"});
  if (model.motion.moves()) sequence.fields.push_back({profile.velocity, "float3", "Vector"});
  const float beyond = lattice.spacing * float(padding);
  for (int a = 0; a < 3; ++a) {
    sequence.lo[a] = lattice.origin[a] - beyond;
    sequence.hi[a] = lattice.origin[a] + lattice.spacing * float(lattice.size[a] - 1) + beyond;
  }
  return usd_stage(sequence);
}

}  // namespace

std::vector<std::string> part_prefixes(int clusters) {
  if (clusters == 0) return {""};
  std::vector<std::string> prefixes;
  for (int c = 0; c < clusters; ++c) prefixes.push_back("cluster_" + std::to_string(c) + "_");
  return prefixes;
}

std::string frame_name(int frame, const ExportProfile& profile) {
  return numbered("frame_", frame, profile.nanovdb ? ".nvdb" : ".vdb");
}
std::string mesh_name(int frame, const std::string& format) { return numbered("mesh_", frame, "." + format); }

std::vector<ManifestFile> write_sidecar(const std::string& folder, const VoxelModel& model,
                                        const ExportOptions& options, const SequenceFiles& files,
                                        const Lattice& lattice, int padding) {
  const ExportSidecar kind = find_profile(options.profile).sidecar;
  if (kind == ExportSidecar::none) return {};
  const bool blender = kind == ExportSidecar::blender_script;
  const std::string name = blender ? kScriptName : kStageName;
  const std::string text =
      blender ? script(model, options, files) : stage(model, options, files, lattice, padding);
  return {{name, write_file((std::filesystem::path(folder) / name).string(), {text}), {}}};
}

}  // namespace splinevox
