// SPDX-License-Identifier: Apache-2.0
// How an export runs: profiles, options, interruption, faults. What its grids hold is in export_test.cpp.
#include <doctest/doctest.h>

#include <cmath>
#include <map>
#include <memory>

#include "data/expect_error.hpp"
#include "io/houdini_options.hpp"
#include "io/scratch.hpp"
#include "io/vdb/vdb_file.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/io/export_vdb.hpp"
#include "splinevox/io/inspect.hpp"
#include "support/blob_model.hpp"
#include "support/on_threads.hpp"

using namespace splinevox;
using test::blob_model, test::FileSizeLimit, test::Scratch, test::slurp, test::spit, test::refusal,
    test::houdini_options;

namespace {

std::string refused_options(const ExportOptions& options) {
  return refusal([&] { validate(options); });
}

}  // namespace

TEST_SUITE("io/export_run") {
  TEST_CASE("a shorter export says which frames of a longer one are left beside it") {
    const Scratch scratch;
    const VoxelModel model = blob_model(24);
    CHECK(export_vdb(model, scratch.folder(), houdini_options(3)).others.empty());
    ExportOptions shorter = houdini_options(1);
    shorter.resume = false;
    CHECK(export_vdb(model, scratch.folder(), shorter).others ==
          std::vector<std::string>{"frame_0002.vdb", "frame_0003.vdb"});
  }

  TEST_CASE("profiles differ in names and place only; the files say what they are") {
    const Scratch scratch;
    const VoxelModel model = blob_model(24);
    ExportOptions options = houdini_options(2);
    options.half = true;
    std::map<std::string, VdbInfo> infos;
    for (const std::string& profile : export_profiles()) {
      if (profile == "nanovdb" || profile == "splats" || profile == "spz") continue;  // no .vdb
      options.profile = profile;
      export_vdb(model, scratch.path(profile), options);
      infos[profile] = inspect_vdb(scratch.path(profile) + "/frame_0002.vdb");
    }
    const VdbInfo &blender = infos.at("blender"), &houdini = infos.at("houdini");
    const std::vector<std::string> blender_names{"density", "color", "velocity"},
        houdini_names{"density", "Cd", "v"};
    REQUIRE(blender.grids.size() == 3);
    REQUIRE(houdini.grids.size() == 3);
    const float spacing = model.radiance.raw.topology->lattice.spacing;
    for (std::size_t g = 0; g < 3; ++g) {
      const GridInfo &a = blender.grids[g], &b = houdini.grids[g];
      CHECK(a.name == blender_names[g]);
      CHECK(b.name == houdini_names[g]);
      CHECK(a.type == (g == 0 ? "float" : "vec3s"));
      CHECK(a.grid_class == "fog volume");
      CHECK(a.half);
      CHECK(a.active_voxels == b.active_voxels);
      CHECK(a.meta.at("creator") == "splinevox");
      CHECK(a.voxel_size == b.voxel_size);
      CHECK(a.origin == blender.grids[0].origin);
      for (int axis = 0; axis < 3; ++axis) {
        CHECK(b.origin[axis] == doctest::Approx(model.box.lo[axis]));
        CHECK(a.origin[axis] == doctest::Approx(model.box.lo[axis] - 0.5 * spacing));
      }
    }
    CHECK(blender.grids[1].meta.at("vector_type") == "invariant");
    CHECK(blender.grids[2].meta.at("vector_type") == "contravariant relative");
    CHECK(blender.meta.at("creator") == "splinevox");
    CHECK(blender.meta.at("fps") == "24");
    CHECK(blender.meta.at("frame") == "2");
    CHECK(blender.meta.at("time") == "1");
    CHECK(std::filesystem::exists(scratch.path("blender/load_in_blender.py")));
    CHECK_FALSE(std::filesystem::exists(scratch.path("houdini/load_in_blender.py")));
    const std::string script = slurp(scratch.path("blender/load_in_blender.py"));
    CHECK(script.find("FIRST, LAST = 1, 2\nFPS = 24\nVELOCITY = True") != std::string::npos);
    for (const FileCheck& check : verify(scratch.path("blender")))
      CHECK_MESSAGE(check.ok, check.file, check.problem);
    CHECK(verify(scratch.path("blender")).size() == 3);
  }

  TEST_CASE("a scene that stands still has no velocity; an empty model has empty frames") {
    const Scratch scratch;
    VoxelModel model = blob_model(16, {.moves = false});
    export_vdb(model, scratch.folder(), houdini_options(1));
    CHECK(read_vdb(scratch.path("frame_0001.vdb")).grids.size() == 2);
    const std::vector<float> background(8, -20.0f);
    model.radiance.raw =
        make_channels(make_topology(model.radiance.raw.topology->lattice, {}), 8, background.data());
    export_vdb(model, scratch.path("empty"), houdini_options(1));
    for (const VdbGrid& grid : read_vdb(scratch.path("empty/frame_0001.vdb")).grids)
      CHECK(grid.leaves.empty());
  }

  TEST_CASE("the same bytes for any number of threads") {
    const Scratch scratch;
    const VoxelModel model = blob_model(32, {.twist = 0.7f, .rigidity = true});
    std::vector<FileDigest> digests;
    for (const int threads : {1, 2, 3}) {
      const ExportResult result = test::on_threads(threads, [&] {
        return export_vdb(model, scratch.path(std::to_string(threads)), houdini_options(2));
      });
      digests.push_back(result.frames[1].file.digest);
    }
    CHECK(digests[0] == digests[1]);
    CHECK(digests[0] == digests[2]);
  }

  TEST_CASE(
      "the same bytes for any number of frames at once; stopped, those in the making are ended and kept") {
    const Scratch scratch;
    const VoxelModel model = blob_model(24, {.twist = 0.7f});
    ExportOptions options = houdini_options(8);
    test::on_threads(4, [&] {
      for (const int at_once : {1, 4, 0}) {
        options.frames_at_once = at_once;
        CHECK(export_vdb(model, scratch.path(std::to_string(at_once)), options).finished);
        CHECK(slurp(scratch.path(std::to_string(at_once) + "/manifest.json")) ==
              slurp(scratch.path("1/manifest.json")));
        for (const FileCheck& check : verify(scratch.path(std::to_string(at_once)))) CHECK(check.ok);
      }
      options.frames_at_once = 3;
      int calls = 0;
      const ExportResult part =
          export_vdb(model, scratch.path("part"), options, [&](const ExportedFrame& frame, int done, int) {
            CHECK(done == ++calls);
            CHECK(frame.frame == done);
            return done < 2;
          });
      CHECK_FALSE(part.finished);
      CHECK(part.frames.size() >= 2);
      CHECK(part.frames.size() <= 5);
      const ExportResult rest = export_vdb(model, scratch.path("part"), options);
      for (std::size_t i = 0; i < 8; ++i) CHECK(rest.frames[i].kept == (i < part.frames.size()));
      CHECK(slurp(scratch.path("part/manifest.json")) == slurp(scratch.path("1/manifest.json")));
    });
  }

  TEST_CASE("an interrupted export goes on where it stopped and ends in the same bytes") {
    const Scratch scratch;
    const VoxelModel model = blob_model(24);
    ExportOptions options = houdini_options(5);
    options.frames_at_once = 1;
    const ExportResult whole = export_vdb(model, scratch.path("whole"), options);
    const std::string folder = scratch.path("parts");
    int calls = 0;
    const ExportResult part =
        export_vdb(model, folder, options, [&](const ExportedFrame&, int done, int total) {
          CHECK(done == ++calls);
          CHECK(total == 5);
          return done < 2;
        });
    CHECK_FALSE(part.finished);
    CHECK(part.frames.size() == 2);
    CHECK_THROWS_WITH_AS(verify(folder), doctest::Contains("holds an export that was not finished"), Error);

    // A frame damaged in between is written again.
    spit(folder + "/frame_0001.vdb", "damaged");
    const ExportResult rest = export_vdb(model, folder, options);
    CHECK(rest.finished);
    const std::vector<bool> kept{false, true, false, false, false};
    for (std::size_t i = 0; i < 5; ++i) {
      CHECK(rest.frames[i].kept == kept[i]);
      CHECK(rest.frames[i].file.digest == whole.frames[i].file.digest);
    }
    CHECK(slurp(folder + "/manifest.json") == slurp(scratch.path("whole/manifest.json")));
    CHECK_FALSE(std::filesystem::exists(folder + "/manifest.partial.json"));
    for (const FileCheck& check : verify(folder)) CHECK(check.ok);

    const ExportResult again = export_vdb(model, folder, options);
    for (const ExportedFrame& frame : again.frames) CHECK(frame.kept);
    ExportOptions other = options;
    other.min_alpha = 0.01;
    other.resume = false;
    for (const ExportedFrame& frame : export_vdb(model, folder, other).frames) CHECK_FALSE(frame.kept);
    VoxelModel changed = model;
    changed.radiance.raw.values.back() += 1;
    for (const ExportedFrame& frame : export_vdb(changed, folder, other).frames) CHECK_FALSE(frame.kept);
  }

  TEST_CASE("a disk that fills up stops the export; finished frames stay and are used later") {
    const Scratch scratch;
    const VoxelModel model = blob_model(24, {.shift = {-0.9f, 0.1f, 0.1f}});
    ExportOptions options = houdini_options(3);
    options.frames_at_once = 1;
    int done = 0;
    try {
      std::unique_ptr<FileSizeLimit> limit;
      export_vdb(model, scratch.folder(), options, [&](const ExportedFrame&, int n, int) {
        done = n;
        if (n == 2) limit = std::make_unique<FileSizeLimit>(2000);
        return true;
      });
      FAIL("exported beyond the end of the disk");
    } catch (const Error& e) {
      CHECK(e.fault == Fault::output);
      CHECK(std::string(e.what()).find(scratch.path("frame_0003.vdb") + ": could not be written") == 0);
    }
    CHECK(done == 2);
    CHECK_FALSE(std::filesystem::exists(scratch.path("frame_0003.vdb")));
    const ExportResult rest = export_vdb(model, scratch.folder(), options);
    CHECK(rest.frames[1].kept);
    CHECK(rest.finished);
  }

  TEST_CASE("bad options and folders are refused by name") {
    const VoxelModel model = blob_model(16);
    struct Row {
      void (*spoil)(ExportOptions&);
      const char* says;
    };
    for (const Row& row : {Row{[](ExportOptions& o) { o.profile = "maya"; },
                               "--profile: there is no such export profile\n  expected: one of: blender, "
                               "houdini, unreal, usd, nanovdb, splats, spz\n  got:      'maya'"},
                           Row{[](ExportOptions& o) {
                                 o.first = 9;
                                 o.last = 3;
                               },
                               "--frames"},
                           Row{[](ExportOptions& o) { o.first = -1; }, "--frames"},
                           Row{[](ExportOptions& o) { o.fps = 0; }, "--fps"},
                           Row{[](ExportOptions& o) { o.fps = NAN; }, "--fps"},
                           Row{[](ExportOptions& o) { o.seconds = -1; }, "--seconds"},
                           Row{[](ExportOptions& o) { o.voxel_size = INFINITY; }, "--voxel-size"},
                           Row{[](ExportOptions& o) { o.shutter = 3; }, "--shutter"},
                           Row{[](ExportOptions& o) { o.min_alpha = 0; }, "--min-alpha"},
                           Row{[](ExportOptions& o) { o.colorspace = "acescg"; }, "--colorspace"},
                           Row{[](ExportOptions& o) { o.bake_view = "dir=0,0"; }, "--bake-view"},
                           Row{[](ExportOptions& o) { o.bake_view = "dir=0,0,0"; }, "--bake-view"},
                           Row{[](ExportOptions& o) { o.bake_view = "front"; }, "--bake-view"}}) {
      CAPTURE(row.says);
      ExportOptions options;
      row.spoil(options);
      CHECK(refused_options(options).find(row.says) == 0);
    }
    CHECK(refused_options({}).empty());
    const Scratch scratch;
    // Beyond the limit, beyond any integer, and beyond any float.
    for (const double size : {1e-6, 1e-10, 1e-50, 1e-300}) {
      CAPTURE(size);
      const std::string said =
          refusal([&] { export_vdb(model, scratch.path("tiny"), houdini_options(1, size)); });
      CHECK(said.find("--voxel-size: is too small for the model's box") == 0);
      CHECK(said.find("expected: at most 2^33 voxels") != std::string::npos);
      CHECK(said.find("the model's own voxel size is ") != std::string::npos);
    }
    CHECK(scratch.count() == 0);
    spit(scratch.path("file"), "x");
    CHECK_THROWS_WITH_AS(export_vdb(model, scratch.path("file"), houdini_options(1)),
                         doctest::Contains("is not a folder"), Error);
  }
}
