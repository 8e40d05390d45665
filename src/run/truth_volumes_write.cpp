// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <numeric>

#include "core/atomic_file.hpp"
#include "core/json_text.hpp"
#include "core/parallel.hpp"
#include "io/vdb/vdb_file.hpp"
#include "run/truth_volumes.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/field/lattice.hpp"

namespace splinevox::run {
namespace {

/// Leaves of those bricks that have any density.
VdbGrid grid_of(const SynthVolume& volume) {
  VdbGrid grid;
  grid.name = "density";
  grid.origin = volume.origin;
  grid.spacing = volume.spacing;
  grid.grid_class = VdbClass::fog_volume;
  for (int x = 0; x < volume.size.x; x += kBrick)
    for (int y = 0; y < volume.size.y; y += kBrick)
      for (int z = 0; z < volume.size.z; z += kBrick) {
        std::vector<float> values(kBrickRows, 0.0f);
        std::vector<std::uint64_t> active(kBrickRows / 64, 0);
        bool any = false;
        for (int i = 0; i < kBrickRows; ++i) {
          const Int3 v = Int3{x, y, z} + Int3{i >> 6, i >> 3 & 7, i & 7};
          if (v.x >= volume.size.x || v.y >= volume.size.y || v.z >= volume.size.z) continue;
          const float density = volume.density[volume.index(v)];
          if (density == 0) continue;
          values[std::size_t(i)] = density;
          active[std::size_t(i) >> 6] |= std::uint64_t(1) << (i & 63);
          any = true;
        }
        if (!any) continue;
        grid.leaves.push_back({x, y, z});
        grid.values.insert(grid.values.end(), values.begin(), values.end());
        grid.active.insert(grid.active.end(), active.begin(), active.end());
      }
  return grid;
}

}  // namespace

void write_truth_volumes(const std::string& folder, const SynthScene& scene,
                         const std::vector<double>& times) {
  namespace fs = std::filesystem;
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) fail_output({.where = folder, .what = "the folder cannot be created", .got = error.message()});
  const std::string here = fs::path(folder).filename().string();
  const auto name = [](std::size_t i) { return fmt::format("volume_{:04d}.vdb", i + 1); };
  std::vector<double> masses(times.size());
  parallel_for(int(times.size()), [&](int t) {
    const auto i = std::size_t(t);
    const SynthMoment moment = scene.at(times[i]);
    const SynthVolume& volume = *moment.gas();
    masses[i] = std::accumulate(volume.density.begin(), volume.density.end(), 0.0) * volume.spacing *
                volume.spacing * volume.spacing;
    VdbFile file;
    file.grids.push_back(grid_of(volume));
    write_vdb((fs::path(folder) / name(i)).string(), std::move(file));
  });
  nlohmann::ordered_json volumes = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < times.size(); ++i)
    volumes.push_back({{"file", here + "/" + name(i)}, {"time", times[i]}, {"mass", masses[i]}});
  const SynthMoment first = scene.at(times.front());
  const SynthVolume& lattice = *first.gas();
  const auto list = [](const auto& v) { return nlohmann::ordered_json{v.x, v.y, v.z}; };
  const Vec3d lo = lattice.origin - 0.5 * lattice.spacing * Vec3d{1, 1, 1};
  const nlohmann::ordered_json file{
      {"volumes", volumes},
      {"grid", "density"},
      {"unit", "extinction per scene unit"},
      {"voxel", lattice.spacing},
      {"shape", list(lattice.size)},
      {"first_voxel_middle", list(lattice.origin)},
      {"box", {list(lo), list(lo + lattice.spacing * cast<double>(lattice.size))}},
      {"mass", "integral of density over space"}};
  write_file((fs::path(folder) / "truth.json").string(), {dump_json(file, 1) + "\n"});
}

}  // namespace splinevox::run
