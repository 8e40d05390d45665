// SPDX-License-Identifier: Apache-2.0
#include "io/export/export_carried.hpp"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <numeric>

#include "core/atomic_file.hpp"
#include "core/process.hpp"
#include "io/export/carried_mesh.hpp"
#include "io/export/carried_points.hpp"
#include "io/export/export_sidecar.hpp"
#include "io/export/usd_geometry.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox {
namespace {

namespace fs = std::filesystem;

constexpr float kStill = 1e-3f;  ///< voxels by which what is carried may be off
constexpr const char *kUsd = ".usda", *kPoints = "points";
/// Bytes for a vertex and frame at once: places and velocities, and their text twice; places and their
/// differences twice, in glTF without velocities, where every frame has a weight at each. Tracks come before
/// either and take less.
constexpr double kUsdBytes = 2 * 12 + 2 * 80, kGlbBytes = 12 + 2 * 16;
constexpr double kCarriedShare = 0.8;  ///< of the free memory

std::string mesh_file(CarriedMesh carried, const ExportOptions& options, const FrameTimes& at,
                      const UsdPlay& play) {
  if (options.mesh_kind() == "usd") return usd_mesh(std::move(carried), play);
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

std::string carried_mesh_file(const ExportOptions& options) {
  return options.mesh_kind() == "usd" ? "mesh.usda" : "mesh.glb";
}

void check_carried_room(const ExportOptions& options, const FrameBaker& baker, std::size_t frames) {
  const double room = kCarriedShare * free_memory();
  const auto mebibytes = [](double b) { return std::to_string(std::uint64_t(b) >> 20) + " MiB"; };
  double vertices = 0, all = 0;  // of the largest part, of all
  if (options.mesh_carried() || options.points.chosen > 0)
    for (const BakedPart& part : baker.bake(options.time_at(options.first), 0, true)) {
      vertices = std::max(vertices, double(part.mesh.points.size()));
      all += double(part.mesh.points.size());
    }
  const double points = options.points.chosen > 0 ? std::min(double(options.points.chosen), all)
                                                  : double(options.points.position.size());
  if (const double bytes = kUsdBytes * points * double(frames); room > 0 && bytes > room)
    fail_memory({.where = "--points",
                 .what = "there is not enough memory for so many points through so many frames",
                 .expected = mebibytes(bytes) + " for " + std::to_string(std::size_t(points)) +
                             " points at " + std::to_string(frames) + " frames",
                 .got = mebibytes(room),
                 .hint = "fewer points or fewer frames"});
  if (!options.mesh_carried()) return;
  const double each = vertices * double(frames), weights = double(frames) * double(frames),
               bytes = options.mesh_kind() == "usd" ? kUsdBytes * each
                                                    : kGlbBytes * each + 3 * sizeof(float) * weights;
  if (room == 0 || bytes <= room) return;
  fail_memory(
      {.where = "--mesh-format",
       .what = "there is not enough memory for a surface that moves through so many frames",
       .expected = mebibytes(bytes) + " for " + std::to_string(std::size_t(vertices)) + " vertices at " +
                   std::to_string(frames) + " frames",
       .got = mebibytes(room),
       .hint = "a larger --voxel-size, fewer frames, or --mesh-format ply, which holds one at a time"});
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
    add(kPointsFile, usd_points(carried, play, voxel), carried.untracked)["points"] =
        double(carried.ids.size());
  }
  if (!options.mesh_carried()) return files;
  const bool usd = options.mesh_kind() == "usd";
  if (!usd) at.rates.clear();  // glTF has no velocities
  const std::vector<std::string> prefixes = part_prefixes(clusters);
  for (std::size_t c = 0; c < parts.size(); ++c) {
    play.name = prefixes[c] + "mesh";
    CarriedMesh carried = carry_mesh(model, std::move(parts[c].mesh), from, at);
    std::map<std::string, double> size;
    add_size(size, carried.mesh);
    const double untracked = carried.untracked;
    auto& figures = add(prefixes[c] + carried_mesh_file(options),
                        mesh_file(std::move(carried), options, at, play), untracked);
    if (clusters > 0) figures["cluster"] = double(c);
    figures.merge(size);
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
