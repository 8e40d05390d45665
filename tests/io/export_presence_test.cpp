// SPDX-License-Identifier: Apache-2.0
// What artists get of matter that comes and goes: grids, flame, and what the files beside them say.
#include <doctest/doctest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "io/export/export_controls.hpp"
#include "io/scratch.hpp"
#include "io/vdb/vdb_file.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/field/sample.hpp"
#include "splinevox/io/export_vdb.hpp"
#include "support/blob_model.hpp"

using namespace splinevox;
using test::blob_model, test::Scratch, test::slurp;

namespace {

constexpr Vec3 kShift{-0.4f, 0.1f, 0.2f};  ///< to canonical at t = 1
constexpr float kGone = 14;                ///< raw density added at t = 0, and taken away at t = 1

/// A ball that fades away over time, in place or while it is carried.
VoxelModel fading_ball(bool moves, bool light = false) {
  VoxelModel m = blob_model(32);
  MotionField& motion = m.motion;
  motion.first_point = FirstPoint::free;
  motion.displaces = moves;
  motion.light = light;
  motion.presence = true;
  const std::vector<float> zero(std::size_t(motion.width()), 0.0f);
  motion.levels[0] = make_channels(motion.levels[0].topology, motion.width(), zero.data());
  Channels& level = motion.levels[0];
  const int stride = motion.stride();
  for (std::size_t r = kBrickRows; r < level.topology->rows(); ++r)
    for (int k = 0; k < motion.points; ++k) {
      float* point = level.row(r) + stride * k;
      const float share = float(k) / float(motion.points - 1);
      for (int a = 0; moves && a < 3; ++a) point[a] = share * kShift[a];
      point[stride - 1] = kGone * (1 - 2 * share);
    }
  return m;
}

ExportOptions options_for(const std::string& profile) {
  ExportOptions o;
  o.profile = profile;
  o.last = 3;
  o.half = false;
  return o;
}

std::vector<std::string> names(const VdbFile& file) {
  std::vector<std::string> out;
  for (const VdbGrid& grid : file.grids) out.push_back(grid.name);
  return out;
}

/// Calls f(voxel, values) for every active voxel. @return how many there are
template <class F>
int each_active(const VdbGrid& grid, const F& f) {
  int count = 0;
  for (std::size_t l = 0; l < grid.leaves.size(); ++l)
    for (int i = 0; i < 512; ++i) {
      if (!(grid.active[l * 8 + std::size_t(i >> 6)] >> (i & 63) & 1)) continue;
      f(grid.leaves[l] + Int3{i >> 6, i >> 3 & 7, i & 7},
        &grid.values[(l * 512 + std::size_t(i)) * std::size_t(grid.width)]);
      ++count;
    }
  return count;
}

/// The values at a voxel, which must be active.
const float* value_at(const VdbGrid& grid, const Int3& voxel) {
  const float* found = nullptr;
  each_active(grid, [&](Int3 v, const float* p) {
    if (v == voxel) found = p;
  });
  REQUIRE(found != nullptr);
  return found;
}

}  // namespace

TEST_SUITE("io/export_presence") {
  TEST_CASE("matter that goes in place: density is the model's at each time, and there is no velocity") {
    const Scratch scratch;
    const VoxelModel model = fading_ball(false);
    const ExportResult result = export_vdb(model, scratch.folder(), options_for("houdini"));
    REQUIRE(result.frames.size() == 3);
    std::vector<int> voxels;
    for (const ExportedFrame& frame : result.frames) {
      const VdbFile file = read_vdb(scratch.path(frame.file.name));
      CHECK(names(file) == std::vector<std::string>{"density", "Cd"});
      CHECK(frame.file.figures.count("max_speed") == 0);
      const FrameSampler sampler(model, frame.time);
      const Lattice& lattice = model.radiance.raw.topology->lattice;
      voxels.push_back(each_active(file.grids[0], [&](Int3 v, const float* p) {
        CHECK(*p == doctest::Approx(sampler.density(lattice.position(v))));
      }));
    }
    CHECK(voxels[0] > voxels[1]);
    CHECK(voxels[1] > 100);
    CHECK(voxels[2] == 0);
  }

  TEST_CASE("the files beside the frames name no velocity where nothing moves, and it where something does") {
    for (const bool moves : {false, true}) {
      const Scratch scratch;
      const VoxelModel model = fading_ball(moves);
      export_vdb(model, scratch.path("blender"), options_for("blender"));
      export_vdb(model, scratch.path("usd"), options_for("usd"));
      const std::string script = slurp(scratch.path("blender/load_in_blender.py"));
      const std::string stage = slurp(scratch.path("usd/sequence.usda"));
      CHECK((script.find("VELOCITY = False") != std::string::npos) == !moves);
      CHECK((stage.find("rel field:velocity") != std::string::npos) == moves);
      CHECK(script.find("{\"seen\": seen, \"smoke\": smoke, \"fire\": fire}") != std::string::npos);
    }
  }

  TEST_CASE("what is carried while it goes has the velocity of what carries it") {
    const Scratch scratch;
    ExportOptions options = options_for("houdini");
    options.seconds = 2;
    options.fps = 1;
    export_vdb(fading_ball(true), scratch.folder(), options);
    for (const char* name : {"frame_0001.vdb", "frame_0002.vdb"}) {
      const VdbFile file = read_vdb(scratch.path(name));
      REQUIRE(names(file) == std::vector<std::string>{"density", "Cd", "v"});
      const int dense = each_active(file.grids[0], [](Int3, const float*) {});
      const int moving = each_active(file.grids[2], [&](Int3, const float* v) {
        for (int a = 0; a < 3; ++a) CHECK(v[a] == doctest::Approx(-kShift[a] / 2).epsilon(1e-4));
      });
      CHECK(dense > 100);
      CHECK(moving > dense);
    }
  }

  TEST_CASE("flame is the luminance of the colour beside it times density, where there is density") {
    for (const char* profile : {"blender", "houdini", "usd"}) {
      CAPTURE(profile);
      for (const char* colorspace : {"display", "linear"}) {
        const Scratch scratch;
        ExportOptions options = options_for(profile);
        options.last = 1;
        options.colorspace = colorspace;
        const VoxelModel model = fading_ball(true);
        export_vdb(model, scratch.folder(), options);
        const VdbFile without = read_vdb(scratch.path("frame_0001.vdb"));
        CHECK(std::ranges::count(names(without), "flame") == 0);
        options.flame = true;
        options.resume = false;
        CHECK_FALSE(export_vdb(model, scratch.folder(), options).frames[0].kept);
        const VdbFile file = read_vdb(scratch.path("frame_0001.vdb"));
        REQUIRE(file.grids.size() == 4);
        const VdbGrid &density = file.grids[0], &color = file.grids[1], &flame = file.grids[2];
        CHECK(flame.name == "flame");
        CHECK(flame.width == 1);
        CHECK(flame.leaves == density.leaves);
        CHECK(flame.active == density.active);
        CHECK(flame.origin == density.origin);
        int nth = 0;
        float most = 0;
        const int voxels = each_active(flame, [&](Int3 v, const float* p) {
          most = std::max(most, *p);
          if (nth++ % 97 != 0) return;
          const float* c = value_at(color, v);
          const float brightness = 0.2126f * c[0] + 0.7152f * c[1] + 0.0722f * c[2];
          CHECK(*p == doctest::Approx(brightness * *value_at(density, v)));
        });
        CHECK(voxels > 500);
        CHECK(most > 1);
      }
    }
  }

  TEST_CASE("the stage names flame where it was asked for; a profile without room for it refuses") {
    const Scratch scratch;
    ExportOptions options = options_for("usd");
    options.flame = true;
    export_vdb(fading_ball(false), scratch.path("usd"), options);
    CHECK(slurp(scratch.path("usd/sequence.usda")).find("rel field:flame = </splinevox/flame>") !=
          std::string::npos);
    options.profile = "unreal";
    CHECK_THROWS_WITH_AS(validate(options), doctest::Contains("--flame"), Error);
  }

  TEST_CASE("a refusal of --controls says what changes where nothing moves") {
    VoxelModel light = fading_ball(false, true);
    light.motion.presence = false;
    CHECK_THROWS_WITH_AS(check_controls(light), doctest::Contains("only its light changes"), Error);
    CHECK_THROWS_WITH_AS(check_controls(fading_ball(false)),
                         doctest::Contains("one where matter only comes and goes"), Error);
    CHECK_THROWS_WITH_AS(check_controls(fading_ball(false, true)),
                         doctest::Contains("only its light changes, and matter comes and goes"), Error);
    CHECK_THROWS_WITH_AS(check_controls(blob_model(16, {.moves = false})),
                         doctest::Contains("one that stands still"), Error);
    CHECK_NOTHROW(check_controls(fading_ball(true)));
  }
}
