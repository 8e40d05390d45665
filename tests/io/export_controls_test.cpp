// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <filesystem>

#include "io/scratch.hpp"
#include "io/vdb/vdb_file.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/field/sample.hpp"
#include "splinevox/io/export_vdb.hpp"
#include "splinevox/io/inspect.hpp"
#include "support/blob_model.hpp"

using namespace splinevox;
using test::blob_model, test::Scratch;

TEST_SUITE("io/export_controls") {
  TEST_CASE(
      "rigidity times the Bezier curve of the control points is the model's displacement, at every vertex") {
    const Scratch scratch;
    const VoxelModel model = blob_model(24, {.twist = 0.7f, .rigidity = true, .light = 0.5f});
    ExportOptions options;
    options.last = 1;
    options.controls = true;
    export_vdb(model, scratch.folder(), options);
    CHECK(verify(scratch.folder()).size() == 3);  // a frame, motion.vdb, Blender's script
    const VdbFile file = read_vdb(scratch.path("motion.vdb"));
    REQUIRE(file.grids.size() == 3);
    CHECK(file.grids[0].name == "control_1");
    CHECK(file.grids[1].name == "control_2");
    CHECK(file.grids[2].name == "rigidity");
    CHECK(std::get<std::string>(file.grids[0].meta.at("basis")) == "bezier");
    CHECK(file.grids[2].width == 1);
    const double t = 0.6;
    const FrameSampler sampler(model, t);
    const VdbGrid& first = file.grids[0];
    const Lattice& lattice = model.motion.levels[0].topology->lattice;
    int compared = 0;
    double worst = 0;
    for (std::size_t l = 0; l < first.leaves.size(); ++l) {
      for (const VdbGrid& grid : file.grids) REQUIRE(grid.leaves[l] == first.leaves[l]);
      for (int i = 0; i < 512; ++i) {
        const Int3 v = first.leaves[l] + Int3{i >> 6, i >> 3 & 7, i & 7};
        bool inside = true;
        Vec3 x{};
        for (int a = 0; a < 3; ++a) {
          inside = inside && v[a] < lattice.size[a];
          x[a] = float(first.origin[a] + first.spacing * v[a]);
        }
        if (!inside) continue;
        const std::size_t row = l * 512 + std::size_t(i);
        const float r = file.grids[2].values[row];
        CHECK(r > 0.5f);
        CHECK(r < 1);
        const Vec3 expected = sampler.warp(x).displacement;
        for (int a = 0; a < 3; ++a) {
          const double c1 = file.grids[0].values[row * 3 + std::size_t(a)],
                       c2 = file.grids[1].values[row * 3 + std::size_t(a)];
          worst = std::max(worst, std::abs(r * (2 * t * (1 - t) * c1 + t * t * c2) - expected[a]));
        }
        ++compared;
      }
    }
    CHECK(compared > 200);
    CHECK(worst < 1e-4);
  }

  TEST_CASE("a scene that stands still is refused before anything is written") {
    const Scratch scratch;
    ExportOptions options;
    options.controls = true;
    CHECK_THROWS_WITH_AS(export_vdb(blob_model(16, {.moves = false}), scratch.path("out"), options),
                         doctest::Contains("--controls: this model has no motion"), Error);
    CHECK_FALSE(std::filesystem::exists(scratch.path("out")));
  }
}
