// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include "io/scratch.hpp"
#include "io/vdb/nvdb_write.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/io/export_vdb.hpp"
#include "splinevox/io/inspect.hpp"
#include "support/blob_model.hpp"
#if SPLINEVOX_NANOVDB
#include <nanovdb/util/IO.h>
#endif

using namespace splinevox;
using test::blob_model, test::Scratch;

TEST_SUITE("io/export_nvdb") {
#if SPLINEVOX_NANOVDB
  TEST_CASE(
      "NanoVDB reads back the voxels, names and places of the .vdb of the same frame; the bytes repeat") {
    const Scratch scratch;
    const VoxelModel model = blob_model(24);
    ExportOptions options;
    options.last = 2;
    options.half = false;
    options.profile = "usd";
    export_vdb(model, scratch.path("vdb"), options);
    options.profile = "nanovdb";
    const ExportResult one = export_vdb(model, scratch.path("one"), options);
    const ExportResult two = export_vdb(model, scratch.path("two"), options);
    CHECK(one.frames[0].file.name == "frame_0001.nvdb");
    for (std::size_t f = 0; f < 2; ++f) CHECK(one.frames[f].file.digest == two.frames[f].file.digest);
    for (const FileCheck& check : verify(scratch.path("one")))
      CHECK_MESSAGE(check.ok, check.file, check.problem);
    for (const ExportedFrame& frame : export_vdb(model, scratch.path("one"), options).frames)
      CHECK(frame.kept);

    const VdbFile expected = read_vdb(scratch.path("vdb/frame_0002.vdb"));
    const auto handles = nanovdb::io::readGrids(scratch.path("one/frame_0002.nvdb"));
    REQUIRE(handles.size() == expected.grids.size());
    for (std::size_t g = 0; g < handles.size(); ++g) {
      const VdbGrid& grid = expected.grids[g];
      const auto* meta = handles[g].gridMetaData();
      CHECK(std::string(meta->shortGridName()) == grid.name);
      CHECK(meta->isFogVolume() == (grid.width == 1));
      CHECK(meta->voxelSize()[0] == doctest::Approx(grid.spacing));
      const auto* floats = handles[g].grid<float>();
      const auto* vectors = handles[g].grid<nanovdb::Vec3f>();
      REQUIRE((grid.width == 1 ? floats != nullptr : vectors != nullptr));
      const nanovdb::Vec3d origin =
          floats ? floats->indexToWorld(nanovdb::Vec3d(0)) : vectors->indexToWorld(nanovdb::Vec3d(0));
      for (int a = 0; a < 3; ++a) CHECK(origin[a] == doctest::Approx(grid.origin[a]));
      std::uint64_t active = 0, wrong = 0;
      for (std::size_t l = 0; l < grid.leaves.size(); ++l)
        for (int i = 0; i < 512; ++i) {
          const nanovdb::Coord at(grid.leaves[l].x + (i >> 6), grid.leaves[l].y + (i >> 3 & 7),
                                  grid.leaves[l].z + (i & 7));
          const float* p = &grid.values[(l * 512 + std::size_t(i)) * std::size_t(grid.width)];
          const bool on = grid.active[l * 8 + std::size_t(i >> 6)] >> (i & 63) & 1;
          active += on;
          if (floats) {
            wrong += floats->tree().getValue(at) != p[0] || floats->tree().isActive(at) != on;
          } else {
            const nanovdb::Vec3f v = vectors->tree().getValue(at);
            wrong += v[0] != p[0] || v[1] != p[1] || v[2] != p[2] || vectors->tree().isActive(at) != on;
          }
        }
      CHECK(wrong == 0);
      CHECK(active > 500);
      CHECK(meta->activeVoxelCount() == active);
    }
  }
#else
  TEST_CASE("a build without NanoVDB refuses the profile and says what to install") {
    ExportOptions options;
    options.profile = "nanovdb";
    CHECK_FALSE(has_nanovdb());
    CHECK_THROWS_WITH_AS(validate(options), doctest::Contains("libnanovdb-dev"), Error);
  }
#endif
}
