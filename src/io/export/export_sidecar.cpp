// SPDX-License-Identifier: Apache-2.0
#include "io/export/export_sidecar.hpp"

#include <filesystem>

#include "core/atomic_file.hpp"
#include "io/export/blender_script.hpp"
#include "io/export/export_folder.hpp"
#include "io/export/usd_text.hpp"

namespace splinevox {
namespace {

namespace fs = std::filesystem;

constexpr const char* kScriptName = "load_in_blender.py";
constexpr const char* kStageName = "sequence.usda";

std::string numbered(const char* stem, int frame, const std::string& suffix) {
  std::string digits = std::to_string(frame);
  if (digits.size() < 4) digits.insert(0, 4 - digits.size(), '0');
  return stem + digits + suffix;
}

std::string script(const SequenceFacts& facts) {
  return blender_script({.first = facts.frames.front(),
                         .last = facts.frames.back(),
                         .fps = facts.fps,
                         .linear = facts.linear,
                         .velocity = facts.velocity,
                         .background = facts.background,
                         .prefixes = part_prefixes(facts.clusters),
                         .sh_order = facts.sh_order});
}

std::string stage(const ExportProfile& profile, const SequenceFacts& facts) {
  UsdSequence sequence{.frames = facts.frames,
                       .fps = facts.fps,
                       .volumes = {},
                       .fields = {},
                       .layers = facts.layers,
                       .lo = facts.lo,
                       .hi = facts.hi};
  for (const std::string& prefix : part_prefixes(facts.clusters)) {
    UsdVolume volume{prefix.substr(0, prefix.size() - (prefix.empty() ? 0 : 1)), {}};
    for (const int f : facts.frames) volume.files.push_back(prefix + frame_name(f, profile));
    sequence.volumes.push_back(std::move(volume));
  }
  sequence.fields = {{profile.density, "float", "None"}, {profile.color, "float3", "Color"}};
  for (int k = 0; 3 * k < (facts.sh_order + 1) * (facts.sh_order + 1); ++k)
    sequence.fields.push_back({"sh" + std::to_string(k), "float3", "None"});
  if (facts.flame) sequence.fields.push_back({profile.flame, "float", "None"});
  if (facts.velocity) sequence.fields.push_back({profile.velocity, "float3", "Vector"});
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
  switch (profile.format) {
    case FrameFormat::vdb:
      return numbered("frame_", frame, ".vdb");
    case FrameFormat::nvdb:
      return numbered("frame_", frame, ".nvdb");
    case FrameFormat::splat_ply:
      return numbered("frame_", frame, ".ply");
    case FrameFormat::splat_spz:
      return numbered("frame_", frame, ".spz");
  }
  return "";
}
std::string mesh_name(int frame, const std::string& format) { return numbered("mesh_", frame, "." + format); }

std::string sidecar_name(const ExportProfile& profile) {
  switch (profile.sidecar) {
    case ExportSidecar::none:
      return "";
    case ExportSidecar::blender_script:
      return kScriptName;
    case ExportSidecar::usd_stage:
      return kStageName;
  }
  return "";
}

std::vector<ManifestFile> write_sidecar(const std::string& folder, const ExportProfile& profile,
                                        const SequenceFacts& facts) {
  if (profile.sidecar == ExportSidecar::none) return {};
  const bool blender = profile.sidecar == ExportSidecar::blender_script;
  const std::string name = sidecar_name(profile);
  const std::string text =
      blender ? script(facts) : with_cameras(stage(profile, facts), cameras_rate(folder) == facts.fps);
  return {{name, write_file((fs::path(folder) / name).string(), {text}), {}}};
}

std::optional<double> cameras_rate(const std::string& folder) {
  const fs::path path = fs::path(folder) / kCamerasUsd;
  std::error_code ignored;
  if (!fs::is_regular_file(path, ignored)) return {};
  return usd_rate(read_file(path.string()));
}

CamerasShown show_cameras(const std::string& folder) {
  std::optional<Manifest> list = export_list(folder, kManifestName);
  if (!list) return CamerasShown::no_stage;
  for (ManifestFile& file : list->files) {
    if (file.name != kStageName || !intact(folder, file)) continue;
    const std::string path = (fs::path(folder) / kStageName).string(), text = read_file(path);
    const std::optional<double> rate = usd_rate(text);
    const bool same = rate && rate == cameras_rate(folder);
    file.digest = write_file(path, {with_cameras(text, same)});
    write_manifest(folder, *list);
    return same ? CamerasShown::yes : CamerasShown::other_rate;
  }
  return CamerasShown::no_stage;
}

}  // namespace splinevox
