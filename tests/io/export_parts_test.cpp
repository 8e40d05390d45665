// SPDX-License-Identifier: Apache-2.0
// What --sh and --clusters write: harmonics as grids, and sequences of parts that are together the whole.
#include <doctest/doctest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <tuple>

#include "io/houdini_options.hpp"
#include "io/scratch.hpp"
#include "io/vdb/vdb_file.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/field/sample.hpp"
#include "splinevox/io/export_vdb.hpp"
#include "splinevox/io/inspect.hpp"
#include "support/blob_model.hpp"

using namespace splinevox;
using test::blob_model, test::Scratch, test::slurp, test::houdini_options;

namespace {

using Key = std::tuple<int, int, int>;

/// Active voxels of a grid of a file.
std::map<Key, Vec3> voxels_of(const std::string& path, const std::string& name) {
  std::map<Key, Vec3> out;
  for (const VdbGrid& grid : read_vdb(path).grids) {
    if (grid.name != name) continue;
    for (std::size_t l = 0; l < grid.leaves.size(); ++l)
      for (int i = 0; i < 512; ++i) {
        if (!(grid.active[l * 8 + std::size_t(i >> 6)] >> (i & 63) & 1)) continue;
        const float* p = &grid.values[(l * 512 + std::size_t(i)) * std::size_t(grid.width)];
        const Int3 v = grid.leaves[l] + Int3{i >> 6, i >> 3 & 7, i & 7};
        out[{v.x, v.y, v.z}] = grid.width == 3 ? Vec3{p[0], p[1], p[2]} : Vec3{p[0], 0, 0};
      }
  }
  return out;
}

/// Half of the blob moves: motion ends at x = 0.1.
VoxelModel half_moving() {
  VoxelModel model = blob_model(32, {.shift = {0.0f, 0.35f, 0.0f}});
  Channels& level = model.motion.levels[0];
  for (int b = 1; b <= level.topology->brick_count(); ++b)
    for (int i = 0; i < kBrickRows; ++i)
      if (level.topology->position(b, i).x < 0.1f)
        std::fill_n(level.row(std::size_t(b) * kBrickRows + std::size_t(i)), level.width, 0.0f);
  return model;
}

}  // namespace

TEST_SUITE("io/export_parts") {
  TEST_CASE("the clusters' densities add up to the whole, voxel by voxel, and each voxel is one cluster's") {
    const Scratch scratch;
    const VoxelModel model = half_moving();
    ExportOptions options = houdini_options(2);
    export_vdb(model, scratch.path("whole"), options);
    options.clusters = 2;
    options.mesh = true;
    const ExportResult result = export_vdb(model, scratch.path("parts"), options);
    REQUIRE(result.clusters.size() == 2);
    CHECK(result.clusters[0].share > 0.2);
    CHECK(result.clusters[1].share > 0.2);
    CHECK(result.clusters[1].motion > 0.5);
    for (const char* frame : {"frame_0001.vdb", "frame_0002.vdb"}) {
      const auto whole = voxels_of(scratch.path("whole/") + frame, "density");
      const auto colors = voxels_of(scratch.path("whole/") + frame, "Cd");
      std::map<Key, Vec3> sum;
      for (const char* part : {"cluster_0_", "cluster_1_"}) {
        const std::string path = scratch.path("parts/") + part + frame;
        const auto density = voxels_of(path, "density"), color = voxels_of(path, "Cd"),
                   velocity = voxels_of(path, "v");
        CHECK(density.size() > 500);
        for (const auto& [key, value] : density) {
          CHECK(sum.emplace(key, value).second);
          CHECK(color.at(key) == colors.at(key));
          CHECK(velocity.count(key) == 1);
        }
      }
      CHECK(sum == whole);
    }
    const FrameSampler first(model, 0);
    const MotionClusters clusters = find_clusters(model, 2);
    const Lattice& lattice = model.radiance.raw.topology->lattice;
    for (const auto& [key, value] : voxels_of(scratch.path("parts/cluster_1_frame_0001.vdb"), "density"))
      CHECK(clusters.at(first.canonical(
                lattice.position({std::get<0>(key), std::get<1>(key), std::get<2>(key)}))) == 1);

    CHECK(verify(scratch.path("parts")).size() == 8);  // two frames of two clusters, each with a mesh
    CHECK(result.frames[1].file.name == "cluster_0_frame_0002.vdb");
    CHECK(result.frames[1].beside.back().name == "cluster_1_mesh_0002.ply");
    CHECK(result.frames[1].beside.back().figures.at("cluster") == 1);
    std::filesystem::remove(scratch.path("parts/cluster_1_mesh_0002.ply"));
    const ExportResult again = export_vdb(model, scratch.path("parts"), options);
    CHECK(again.frames[0].kept);
    CHECK_FALSE(again.frames[1].kept);
    CHECK(again.frames[1].beside.back().digest == result.frames[1].beside.back().digest);
    options.clusters = 1;
    CHECK_THROWS_WITH_AS(validate(options), doctest::Contains("--clusters"), Error);
  }

  TEST_CASE("the scripts beside the clusters name every one") {
    const Scratch scratch;
    const VoxelModel model = half_moving();
    ExportOptions options = houdini_options(2);
    options.clusters = 2;
    options.profile = "blender";
    export_vdb(model, scratch.path("blender"), options);
    CHECK(slurp(scratch.path("blender/load_in_blender.py"))
              .find("PREFIXES = (\"cluster_0_\", \"cluster_1_\", )") != std::string::npos);
    options.profile = "usd";
    export_vdb(model, scratch.path("usd"), options);
    const std::string stage = slurp(scratch.path("usd/sequence.usda"));
    for (const char* part :
         {"def Xform \"splinevox\"\n{\n    def Volume \"cluster_0\"\n    {\n",
          "    def Volume \"cluster_1\"\n", "rel field:density = </splinevox/cluster_1/density>\n",
          "2: @./cluster_1_frame_0002.vdb@,\n"})
      CHECK_MESSAGE(stage.find(part) != std::string::npos, part);
    CHECK(std::count(stage.begin(), stage.end(), '{') == std::count(stage.begin(), stage.end(), '}'));
  }

  TEST_CASE(
      "harmonics are the model's, three to a grid, beside the positional colour; what cannot be is refused") {
    const Scratch scratch;
    const VoxelModel model = blob_model(24, {.twist = 0.4f, .light = 0.8f}, 2);
    ExportOptions options = houdini_options(2);
    options.sh = true;
    export_vdb(model, scratch.folder(), options);
    const std::string path = scratch.path("frame_0002.vdb");
    REQUIRE(read_vdb(path).grids.size() == 6);
    const FrameSampler sampler(model, 1);
    const Lattice& lattice = model.radiance.raw.topology->lattice;
    const auto color = voxels_of(path, "Cd"), density = voxels_of(path, "density");
    CHECK(density.size() > 400);
    const std::map<Key, Vec3> sh[] = {voxels_of(path, "sh0"), voxels_of(path, "sh1"), voxels_of(path, "sh2")};
    for (const auto& [key, value] : density) {
      const Vec3 x = lattice.position({std::get<0>(key), std::get<1>(key), std::get<2>(key)});
      const FrameSampler::Warp warp = sampler.warp(x);
      const auto radiance = sampler.radiance(x + warp.displacement);
      CHECK(length(color.at(key) - warp.light * radiance.color) < 1e-5f);
      for (int j = 0; j < 9; ++j) CHECK(sh[j / 3].at(key)[j % 3] == radiance.sh[j]);
    }
    for (const auto& grid : sh) CHECK(grid.size() == color.size());  // a voxel beyond the density as well

    // A mesh has no harmonics: its colours are what they are without.
    ExportOptions meshes = options;
    meshes.mesh = true;
    export_vdb(model, scratch.path("with"), meshes);
    meshes.sh = false;
    export_vdb(model, scratch.path("without"), meshes);
    CHECK(slurp(scratch.path("with/mesh_0002.ply")) == slurp(scratch.path("without/mesh_0002.ply")));
    meshes.sh = true;
    meshes.bake_view = "none";
    export_vdb(model, scratch.path("none"), meshes);
    CHECK(slurp(scratch.path("with/mesh_0002.ply")) != slurp(scratch.path("none/mesh_0002.ply")));

    const auto refused = [&](const char* option, auto change) {
      ExportOptions other = options;
      change(other);
      CHECK_THROWS_WITH_AS(validate(other), doctest::Contains(option), Error);
    };
    refused("--bake-view", [](ExportOptions& o) { o.bake_view = "dir=0,0,1"; });
    refused("--colorspace", [](ExportOptions& o) { o.colorspace = "linear"; });
    refused("--sh", [](ExportOptions& o) { o.profile = "unreal"; });
    refused("--frames-at-once", [](ExportOptions& o) { o.frames_at_once = -1; });
    CHECK_THROWS_WITH_AS(export_vdb(blob_model(16, {}, -1), scratch.path("matt"), options),
                         doctest::Contains("--sh"), Error);
  }
}
