// SPDX-License-Identifier: Apache-2.0
#include "io/export/export_profiles.hpp"

#include "splinevox/core/error.hpp"
#include "splinevox/io/export_vdb.hpp"

namespace splinevox {
namespace {

/// A new profile is a line here.
constexpr ExportProfile kProfiles[] = {
    {"blender", "density", "color", "velocity", "flame", -0.5, ExportSidecar::blender_script},
    {"houdini", "density", "Cd", "v", "flame", 0.0, ExportSidecar::none},
    // A Sparse Volume Texture holds few channels and its material blurs no motion: density and colour fill
    // one RGBA.
    {"unreal", "density", "Cd", nullptr, nullptr, 0.0, ExportSidecar::none},
    {"usd", "density", "color", "velocity", "flame", 0.0, ExportSidecar::usd_stage},
    {"nanovdb", "density", "color", "velocity", "flame", 0.0, ExportSidecar::none, FrameFormat::nvdb},
    // Renderers of splats know neither velocity nor grids.
    {"splats", "density", "color", nullptr, nullptr, 0.0, ExportSidecar::none, FrameFormat::splat_ply},
    {"spz", "density", "color", nullptr, nullptr, 0.0, ExportSidecar::none, FrameFormat::splat_spz},
};

}  // namespace

std::vector<std::string> export_profiles() {
  std::vector<std::string> names;
  for (const ExportProfile& profile : kProfiles) names.emplace_back(profile.name);
  return names;
}

const ExportProfile& find_profile(const std::string& name) {
  std::string all;
  for (const ExportProfile& profile : kProfiles) {
    if (name == profile.name) return profile;
    if (!all.empty()) all += ", ";
    all += profile.name;
  }
  fail({.where = "--profile",
        .what = "there is no such export profile",
        .expected = "one of: " + all,
        .got = "'" + name + "'",
        .hint = ""});
}

}  // namespace splinevox
