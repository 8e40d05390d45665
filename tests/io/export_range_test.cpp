// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "core/own_folder.hpp"
#include "data/expect_error.hpp"
#include "io/manifest.hpp"
#include "io/scratch.hpp"
#include "io/vdb/vdb_file.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/io/export_vdb.hpp"
#include "splinevox/io/inspect.hpp"
#include "support/blob_model.hpp"
#include "support/on_threads.hpp"

using namespace splinevox;
using namespace splinevox::test;

namespace {

ExportOptions part_of_shot(int first, int last, double seconds = 4) {
  ExportOptions o;
  o.profile = "houdini";
  o.first = first;
  o.last = last;
  o.at = 1001;
  o.seconds = seconds;
  return o;
}

std::string refused_export(const VoxelModel& model, const std::string& folder, const ExportOptions& options) {
  return refusal([&] { export_vdb(model, folder, options); });
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != text.npos; }

}  // namespace

TEST_SUITE("io/export_range") {
  TEST_CASE("any part of a shot has the times of the whole; outside of the motion all stands still") {
    FrameRange whole{.first = 1001, .last = 1097, .seconds = 4, .at = 1001};
    FrameRange part{.first = 1050, .last = 1051, .seconds = 4, .at = 1001};
    for (const int frame : {1050, 1051}) {
      CHECK(part.time_at(frame) == whole.time_at(frame));
      CHECK(part.time_at(frame) == doctest::Approx((frame - 1001) / 96.0));
      CHECK(part.rate_at(frame) == 0.25);
    }
    CHECK(whole.time_at(990) == 0);
    CHECK(whole.rate_at(990) == 0);
    CHECK(whole.time_at(1097) == 1);
    CHECK(whole.rate_at(1097) == 0.25);
    CHECK(whole.time_at(1098) == 1);
    CHECK(whole.rate_at(1098) == 0);
  }

  TEST_CASE("without more words the frames show the whole motion, and one frame its first moment") {
    const FrameRange all{.first = 9, .last = 11};
    CHECK(all.time_at(9) == 0);
    CHECK(all.time_at(10) == 0.5);
    CHECK(all.time_at(11) == 1);
    const FrameRange one{.first = 9, .last = 9};
    CHECK(one.time_at(9) == 0);
    CHECK(one.length() == 1);
    const FrameRange from{.first = 9, .last = 11, .at = 7};
    CHECK(from.time_at(9) == 0.5);
    FrameRange bad{.first = 9, .last = 11, .at = 11};
    CHECK_THROWS_WITH_AS(validate(bad), doctest::Contains("--at: is out of range"), Error);
    bad.seconds = 2;
    CHECK_NOTHROW(validate(bad));
  }

  TEST_CASE("frames of one shot join those that are there, and parts have the bytes of the whole") {
    const Scratch scratch;
    const VoxelModel model = blob_model(24);
    export_vdb(model, scratch.path("whole"), part_of_shot(1050, 1053));
    const std::string folder = scratch.path("parts");
    export_vdb(model, folder, part_of_shot(1052, 1053));
    const ExportResult result = export_vdb(model, folder, part_of_shot(1050, 1051));
    CHECK(result.in_folder == std::vector<int>{1050, 1051, 1052, 1053});
    CHECK(result.others.empty());
    CHECK(slurp(folder + "/manifest.json") == slurp(scratch.path("whole/manifest.json")));
    for (const FileCheck& check : verify(folder)) CHECK(check.ok);
    const ExportResult longer = export_vdb(model, folder, part_of_shot(1051, 1054));
    CHECK(longer.frames[0].kept);
    CHECK_FALSE(longer.frames[3].kept);
    CHECK(longer.in_folder == std::vector<int>{1050, 1051, 1052, 1053, 1054});
  }

  TEST_CASE("stopped in the middle, an export of more frames forgets none of those before") {
    const Scratch scratch;
    const VoxelModel model = blob_model(24);
    export_vdb(model, scratch.folder(), part_of_shot(1050, 1051));
    ExportOptions more = part_of_shot(1060, 1063);
    more.frames_at_once = 1;
    CHECK_FALSE(export_vdb(model, scratch.folder(), more, [](const ExportedFrame&, int done, int) {
                  return done < 2;
                }).finished);
    const ExportResult rest = export_vdb(model, scratch.folder(), more);
    CHECK(rest.frames[1].kept);
    CHECK(rest.in_folder == std::vector<int>{1050, 1051, 1060, 1061, 1062, 1063});
  }

  TEST_CASE("an export that is told once to stop stops, on several threads too") {
    const Scratch scratch;
    const VoxelModel model = blob_model(16);
    ExportOptions options = part_of_shot(1, 60);
    const ExportResult stopped = test::on_threads(2, [&] {
      return export_vdb(model, scratch.folder(), options,
                        [](const ExportedFrame&, int done, int) { return done != 3; });
    });
    CHECK_FALSE(stopped.finished);
    CHECK(stopped.frames.size() < 20);  // those that were in the making are finished
  }

  TEST_CASE("nor does it forget those of its own that it has not come to") {
    const Scratch scratch;
    const VoxelModel model = blob_model(24);
    ExportOptions options = part_of_shot(1052, 1053);
    options.profile = "usd";
    options.mesh = true;
    options.mesh_format = "ply";
    options.frames_at_once = 1;
    export_vdb(model, scratch.folder(), options);
    spit(scratch.path("mesh_1053.ply"), "cut off");
    options.first = 1050;
    CHECK_FALSE(export_vdb(model, scratch.folder(), options, [](const ExportedFrame&, int, int) {
                  return false;
                }).finished);
    std::vector<std::string> listed;
    for (const ManifestFile& file : read_manifest(scratch.folder(), kPartialManifestName).files)
      listed.push_back(file.name);
    CHECK(listed == std::vector<std::string>{"frame_1050.vdb", "mesh_1050.ply", "frame_1052.vdb",
                                             "mesh_1052.ply", "frame_1053.vdb", "sequence.usda"});
    const ExportResult rest = export_vdb(model, scratch.folder(), options);
    const std::vector<bool> kept{true, false, true, false};
    for (std::size_t i = 0; i < 4; ++i) CHECK(rest.frames[i].kept == kept[i]);
    for (const FileCheck& check : verify(scratch.folder())) CHECK(check.ok);
    export_vdb(model, scratch.path("whole"), options);
    CHECK(slurp(scratch.path("manifest.json")) == slurp(scratch.path("whole/manifest.json")));
  }

  TEST_CASE("the stage of a sequence with a gap names the frames that are there") {
    const Scratch scratch;
    const VoxelModel model = blob_model(24);
    ExportOptions options = part_of_shot(1050, 1050);
    options.profile = "usd";
    export_vdb(model, scratch.folder(), options);
    options.first = options.last = 1053;
    export_vdb(model, scratch.folder(), options);
    const std::string stage = slurp(scratch.path("sequence.usda"));
    CHECK(contains(stage, "startTimeCode = 1050"));
    CHECK(contains(stage, "endTimeCode = 1053"));
    CHECK(contains(stage, "1053: @./frame_1053.vdb@"));
    CHECK_FALSE(contains(stage, "1051:"));
  }

  TEST_CASE("an export with other settings is refused by name and leaves what is there as it was") {
    const Scratch scratch;
    const VoxelModel model = blob_model(24);
    export_vdb(model, scratch.folder(), part_of_shot(1050, 1051));
    const std::string before = slurp(scratch.path("manifest.json"));

    ExportOptions other = part_of_shot(1050, 1051);
    other.profile = "usd";
    const std::string profile = refused_export(model, scratch.folder(), other);
    CHECK(contains(profile, "holds an export with other settings"));
    CHECK(contains(profile, "expected: profile houdini\n  got:      profile usd"));
    CHECK(contains(profile, "--afresh"));

    ExportOptions squeezed = part_of_shot(1050, 1051);
    squeezed.at.reset();
    squeezed.seconds = 0;
    const std::string range = refused_export(model, scratch.folder(), squeezed);
    CHECK(contains(range, "expected: at 1001, seconds 4\n  got:      at 1050, seconds 0.041"));
    CHECK(contains(range, "try:      --at 1001 --seconds 4 --fps 24 for more frames of the shot"));

    VoxelModel changed = model;
    changed.radiance.raw.values.back() += 1;
    CHECK(contains(refused_export(changed, scratch.folder(), part_of_shot(1050, 1051)),
                   "its model is not the run's present one"));
    CHECK(slurp(scratch.path("manifest.json")) == before);
    for (const FileCheck& check : verify(scratch.folder())) CHECK(check.ok);
  }

  TEST_CASE("a file of a frame's name that no export lists is somebody else's") {
    const Scratch scratch;
    const VoxelModel model = blob_model(24);
    int number = 0;
    for (const char* name : {"frame_1051.vdb", "sequence.usda", "mesh.usda"}) {
      CAPTURE(name);
      const std::string folder = scratch.path(std::to_string(++number));
      std::filesystem::create_directories(folder);
      spit(folder + "/" + name, "a simulation");
      ExportOptions options = part_of_shot(1050, 1051);
      options.profile = "usd";
      options.mesh = true;
      const std::string said = refused_export(model, folder, options);
      CHECK(contains(said, "holds a file that this would overwrite"));
      CHECK(contains(said, name));
      CHECK(contains(said, "--afresh"));
      CHECK(slurp(folder + "/" + name) == "a simulation");
      CHECK(names_in_folder(folder).size() == 1);
      options.resume = false;
      export_vdb(model, folder, options);
      for (const FileCheck& check : verify(folder)) CHECK(check.ok);
    }
    // Files of other names are no matter.
    spit(scratch.path("notes.txt"), "mine");
    export_vdb(model, scratch.folder(), part_of_shot(1050, 1051));
    CHECK(slurp(scratch.path("notes.txt")) == "mine");
  }

  TEST_CASE("beside the frames of an export too, a .vdb of a frame's name is ours only if it says so") {
    const Scratch scratch;
    const VoxelModel model = blob_model(24);
    export_vdb(model, scratch.folder(), part_of_shot(1050, 1051));
    const std::string list = slurp(scratch.path("manifest.json")), next = scratch.path("frame_1052.vdb");
    VdbFile theirs;
    theirs.meta = {{"creator", std::string("a simulation")}};
    theirs.grids.resize(1);
    theirs.grids[0].name = "density";
    theirs.grids[0].leaves.push_back({0, 0, 0});
    theirs.grids[0].values.assign(512, 1.0f);
    write_vdb(next, theirs);
    const std::string simulation = slurp(next);
    for (const std::string& bytes : {simulation, std::string("no VDB"), std::string()}) {
      spit(next, bytes);
      const std::string said = refused_export(model, scratch.folder(), part_of_shot(1050, 1053));
      CHECK(contains(said, "holds a file that this would overwrite"));
      CHECK(contains(said, "frame_1052.vdb"));
      CHECK(slurp(next) == bytes);
      CHECK(slurp(scratch.path("manifest.json")) == list);
      CHECK(partial_manifests(scratch.folder()).empty());
    }
    CHECK(export_vdb(model, scratch.folder(), part_of_shot(1050, 1051)).finished);  // it is not in its way
    // As a killed export leaves a frame that it had finished and not yet listed.
    spit(next, slurp(scratch.path("frame_1051.vdb")));
    CHECK(export_vdb(model, scratch.folder(), part_of_shot(1050, 1053)).finished);
    for (const FileCheck& check : verify(scratch.folder())) CHECK(check.ok);
  }

  TEST_CASE("what lies beside the frames of a shot stays, or is asked for again") {
    const Scratch scratch;
    const VoxelModel model = blob_model(24);
    ExportOptions options = part_of_shot(1002, 1003);
    options.profile = "usd";
    options.points.chosen = 5;
    options.controls = true;
    export_vdb(model, scratch.folder(), options);
    ExportOptions plain = options;
    plain.points = {};
    plain.controls = false;
    const auto listed = [&](const char* name) {
      return read_manifest(scratch.folder()).find(name) != nullptr;
    };
    export_vdb(model, scratch.folder(), plain);  // the same frames
    for (const char* name : {"motion.vdb", "points.usda"}) CHECK(listed(name));
    CHECK(contains(slurp(scratch.path("sequence.usda")), "@./points.usda@"));
    plain.last = 1005;
    const std::string said = refused_export(model, scratch.folder(), plain);
    CHECK(contains(said, "has points of the frames that are there"));
    CHECK(contains(said, "--points"));
    plain.points.chosen = 5;
    export_vdb(model, scratch.folder(), plain);
    for (const char* name : {"motion.vdb", "points.usda"}) CHECK(listed(name));
    CHECK(contains(slurp(scratch.path("points.usda")), "endTimeCode = 1005"));
    for (const FileCheck& check : verify(scratch.folder())) CHECK(check.ok);
    ExportOptions meshes = part_of_shot(1002, 1003);
    meshes.mesh = true;
    export_vdb(model, scratch.path("mesh"), meshes);
    meshes.mesh_format = "obj";
    CHECK(contains(refused_export(model, scratch.path("mesh"), meshes), "mesh_format ply"));
  }

  TEST_CASE("asked to, it replaces what is there, and goes on with itself after a stop") {
    const Scratch scratch;
    const VoxelModel model = blob_model(24);
    export_vdb(model, scratch.folder(), part_of_shot(1050, 1052));
    ExportOptions other = part_of_shot(1050, 1051);
    other.profile = "usd";
    other.resume = false;
    other.frames_at_once = 1;
    export_vdb(model, scratch.folder(), other, [](const ExportedFrame&, int, int) { return false; });
    other.resume = true;
    const ExportResult result = export_vdb(model, scratch.folder(), other);
    CHECK(result.frames[0].kept);
    CHECK(result.in_folder == std::vector<int>{1050, 1051});
    CHECK(result.others == std::vector<std::string>{"frame_1052.vdb"});
  }

  TEST_CASE("replaced, an export leaves nothing beside its frames that would show the new ones") {
    const Scratch scratch;
    const VoxelModel model = blob_model(24);
    const auto there = [&](const char* name) { return std::filesystem::exists(scratch.path(name)); };
    ExportOptions usd = part_of_shot(1050, 1051);
    usd.profile = "usd";
    usd.mesh = true;
    usd.controls = true;
    usd.points.chosen = 5;
    export_vdb(model, scratch.folder(), usd);
    for (const char* name : {"sequence.usda", "mesh.usda", "motion.vdb", "points.usda"}) CHECK(there(name));
    spit(scratch.path("notes.txt"), "mine");
    spit(scratch.path("points.usda"), "changed by hand");
    ExportOptions blender = part_of_shot(1050, 1050);
    blender.profile = "blender";
    blender.controls = true;
    blender.resume = false;
    blender.frames_at_once = 1;
    export_vdb(model, scratch.folder(), blender);
    for (const char* name : {"sequence.usda", "mesh.usda"}) CHECK_FALSE(there(name));
    for (const char* name : {"load_in_blender.py", "motion.vdb", "frame_1051.vdb"}) CHECK(there(name));
    CHECK(slurp(scratch.path("notes.txt")) == "mine");
    CHECK(slurp(scratch.path("points.usda")) == "changed by hand");
    for (const FileCheck& check : verify(scratch.folder())) CHECK(check.ok);

    // One that was stopped is replaced as a whole one is.
    blender.first = 1052;
    blender.last = 1053;
    blender.resume = true;
    export_vdb(model, scratch.folder(), blender, [](const ExportedFrame&, int, int) { return false; });
    CHECK(there("load_in_blender.py"));
    ExportOptions houdini = part_of_shot(1050, 1050);
    houdini.resume = false;
    export_vdb(model, scratch.folder(), houdini);
    for (const char* name : {"load_in_blender.py", "motion.vdb"}) CHECK_FALSE(there(name));
    for (const FileCheck& check : verify(scratch.folder())) CHECK(check.ok);
  }

  TEST_CASE("where the model came from is noted and is no setting") {
    const Scratch scratch;
    const VoxelModel model = blob_model(24);
    ExportOptions options = part_of_shot(1050, 1050);
    options.run = "/runs/a";
    export_vdb(model, scratch.folder(), options);
    CHECK(read_manifest(scratch.folder()).info.at("run") == "/runs/a");
    options.run = "/runs/moved";
    CHECK(export_vdb(model, scratch.folder(), options).frames[0].kept);
    const ManifestFile frame = read_manifest(scratch.folder()).files[0];
    const VdbGrid density = read_vdb(scratch.path(frame.name)).grids[0];
    CHECK(frame.figures.at("min_x") > density.origin.x);
    CHECK(frame.figures.at("max_x") > frame.figures.at("min_x"));
  }
}
