// SPDX-License-Identifier: Apache-2.0
#include "io/export/export_carried.hpp"

#include <filesystem>
#include <numeric>

#include "core/atomic_file.hpp"
#include "io/export/carried_mesh.hpp"
#include "io/export/carried_points.hpp"
#include "io/export/export_sidecar.hpp"
#include "io/export/usd_geometry.hpp"

namespace splinevox {
namespace {

namespace fs = std::filesystem;

constexpr float kStill = 1e-3f;  ///< voxels by which what is carried may be off
constexpr const char *kUsd = ".usda", *kPoints = "points";

std::string mesh_file(const CarriedMesh& carried, const ExportOptions& options, const FrameTimes& at,
                      const UsdPlay& play) {
  if (options.mesh_kind() == "usd") return usd_mesh(carried, play);
  MeshPlay glb{.name = play.name, .still = play.still};
  for (std::size_t i = 0; i < at.times.size(); ++i) {
    glb.frames.push_back("frame_" + std::to_string(play.frames[i]));
    glb.seconds.push_back((play.frames[i] - play.frames.front()) / options.fps);
  }
  return glb_bytes(carried, glb);
}

/// Those that the options name, or as many of the surface; each with a time and a number.
ExportPoints all_points(ExportPoints points, const std::vector<BakedPart>& parts, double from) {
  std::vector<Vec3> surface;
  for (const BakedPart& part : parts)
    surface.insert(surface.end(), part.mesh.points.begin(), part.mesh.points.end());
  const std::size_t wanted = std::min(surface.size(), std::size_t(points.chosen));
  // Vertices are in the order of OpenVDB's leaves, so evenly spaced ones are everywhere.
  for (std::size_t i = 0; i < wanted; ++i) points.position.push_back(surface[i * surface.size() / wanted]);
  if (points.time.empty()) points.time.assign(points.position.size(), from);
  if (points.id.empty()) {
    points.id.resize(points.position.size());
    std::iota(points.id.begin(), points.id.end(), 0);
  }
  return points;
}

}  // namespace

void add_size(std::map<std::string, double>& figures, const ColorMesh& mesh) {
  figures["vertices"] = double(mesh.points.size());
  figures["triangles"] = double(mesh.triangles.size());
}

std::vector<ManifestFile> write_carried(const VoxelModel& model, const std::string& folder,
                                        const ExportOptions& options, const FrameBaker& baker, int clusters,
                                        const std::vector<int>& frames) {
  std::vector<ManifestFile> files;
  if (!options.mesh_carried() && !options.points.any()) return files;
  const double from = options.time_at(frames.front());
  FrameTimes at = frame_times(options, frames);
  const float voxel = baker.lattice().spacing;
  UsdPlay play{.name = "", .frames = frames, .fps = options.fps, .still = kStill * voxel};
  const auto add = [&](const std::string& name, const std::string& bytes, double untracked) -> auto& {
    files.push_back({name, write_file((fs::path(folder) / name).string(), {bytes}), {}});
    files.back().figures = {{"frames", double(frames.size())}, {"untracked_share", untracked}};
    return files.back().figures;
  };
  std::vector<BakedPart> parts;
  if (options.mesh_carried() || options.points.chosen > 0) parts = baker.bake(from, 0, true);
  if (options.points.any()) {
    play.name = kPoints;
    const CarriedPoints carried = carry_points(model, all_points(options.points, parts, from), at,
                                               ViewBake(options.bake_view, model.radiance.sh_order));
    add(play.name + kUsd, usd_points(carried, play, voxel), carried.untracked)["points"] =
        double(carried.ids.size());
  }
  if (!options.mesh_carried()) return files;
  const bool usd = options.mesh_kind() == "usd";
  if (!usd) at.rates.clear();  // glTF has no velocities
  const std::vector<std::string> prefixes = part_prefixes(clusters);
  for (std::size_t c = 0; c < parts.size(); ++c) {
    play.name = prefixes[c] + "mesh";
    const CarriedMesh carried = carry_mesh(model, std::move(parts[c].mesh), from, at);
    auto& figures =
        add(play.name + (usd ? kUsd : ".glb"), mesh_file(carried, options, at, play), carried.untracked);
    if (clusters > 0) figures["cluster"] = double(c);
    add_size(figures, carried.mesh);
  }
  return files;
}

std::vector<UsdLayer> usd_layers(const std::vector<ManifestFile>& carried) {
  std::vector<UsdLayer> layers;
  for (const ManifestFile& file : carried)
    if (file.name.ends_with(kUsd))
      layers.push_back({file.name, file.name.substr(0, file.name.size() - std::string(kUsd).size()),
                        file.figures.contains(kPoints) ? "Points" : "Mesh"});
  return layers;
}

}  // namespace splinevox
