// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "field/lattice/lattice_view.hpp"
#include "splinevox/field/edit.hpp"
#include "splinevox/field/sample.hpp"
#include "support/empty_model.hpp"

using namespace splinevox;
using test::kEmpty;

namespace {

constexpr float kFog = -1.5f, kSolid = 6;  // raw densities: below 5% a voxel, opaque
constexpr float kAdded = 10;               // what is added at the end of time, and lacks at its beginning

VoxelModel nothing() { return test::empty_model(24, {2, -1}, -1); }

float& at(VoxelModel& m, Int3 v) {
  const std::size_t row = view_of(*m.radiance.raw.topology).row_of(v);
  REQUIRE(row >= kBrickRows);
  return m.radiance.raw.row(row)[0];
}

/// A cube of solid vertices in the middle: 6 of them an edge, over several bricks.
VoxelModel cube() {
  VoxelModel m = nothing();
  for (int x = 5; x < 11; ++x)
    for (int y = 5; y < 11; ++y)
      for (int z = 5; z < 11; ++z) at(m, {x, y, z}) = kSolid;
  return m;
}

/// The same, with matter that comes and goes in one of the eight parts of the box. @param side  -1 or 1
VoxelModel comes_on(VoxelModel m, float side) {
  m.motion.displaces = m.motion.rigidity = false;
  m.motion.first_point = FirstPoint::free;
  m.motion.points = 2;
  m.motion.presence = true;
  Channels& level = test::add_level(m, 8);
  for (int b = 1; b <= level.topology->brick_count(); ++b)
    for (int i = 0; i < kBrickRows; ++i) {
      const Vec3 x = side * level.topology->position(b, i);
      if (std::min({x.x, x.y, x.z}) < 0.1f) continue;
      float* row = level.row(std::size_t(b) * kBrickRows + std::size_t(i));
      row[0] = -kAdded;
      row[1] = kAdded;
    }
  return m;
}

}  // namespace

TEST_SUITE("field/floaters") {
  TEST_CASE("a speck goes with the fog around it, the rest keeps its bits") {
    VoxelModel m = cube();
    at(m, {20, 20, 20}) = kSolid;
    at(m, {21, 20, 22}) = kFog;  // two voxels beside the speck
    at(m, {3, 8, 8}) = kFog;     // beside the cube
    at(m, {20, 20, 16}) = kFog;  // four voxels away from it
    const RemovedFloaters removed = remove_floaters(m, 0.01);
    CHECK(removed.count == 1);
    CHECK(removed.left == 1);
    CHECK(removed.share == doctest::Approx(1 / 217.0).epsilon(1e-3));
    VoxelModel expected = cube();
    at(expected, {3, 8, 8}) = kFog;
    at(expected, {20, 20, 16}) = kFog;
    CHECK(m.radiance.raw.values == expected.radiance.raw.values);
  }

  TEST_CASE("what touches by a corner hangs together, across bricks as well") {
    VoxelModel m = cube();
    at(m, {11, 11, 11}) = kSolid;
    at(m, {12, 12, 12}) = kSolid;
    const VoxelModel before = m;
    CHECK(remove_floaters(m, 0.01).count == 0);
    CHECK(m.radiance.raw.values == before.radiance.raw.values);
  }

  TEST_CASE("a piece of more than the share stays, and so does all for a share of 0") {
    VoxelModel m = cube();
    for (int x = 18; x < 21; ++x) at(m, {x, 20, 20}) = kSolid;  // 3 of 219: 1.4%
    const VoxelModel before = m;
    CHECK(remove_floaters(m, 0.01).count == 0);
    CHECK(remove_floaters(m, 0).left == 2);
    CHECK(m.radiance.raw.values == before.radiance.raw.values);
    CHECK(remove_floaters(m, 0.02).count == 1);
    CHECK(at(m, {19, 20, 20}) == kEmpty);
  }

  TEST_CASE("what lies beside the matter that stays is left, since its surface runs through there") {
    VoxelModel m = cube();
    at(m, {13, 8, 8}) = kSolid;
    at(m, {11, 8, 8}) = at(m, {12, 8, 8}) = kFog;
    CHECK(remove_floaters(m, 0.01).count == 1);
    CHECK(at(m, {13, 8, 8}) == kEmpty);
    CHECK(at(m, {12, 8, 8}) == kEmpty);
    CHECK(at(m, {11, 8, 8}) == kFog);
    CHECK(at(m, {10, 8, 8}) == kSolid);
  }

  TEST_CASE("what is thin on the mean over time and solid for a moment is matter") {
    VoxelModel m = nothing();
    for (int x = 5; x < 11; ++x)
      for (int y = 5; y < 11; ++y)
        for (int z = 5; z < 11; ++z) at(m, {x, y, z}) = kSolid - kAdded;
    at(m, {20, 20, 20}) = kSolid;
    m = comes_on(std::move(m), -1);
    const RemovedFloaters removed = remove_floaters(m, 0.01);
    CHECK(removed.count == 1);
    CHECK(removed.left == 1);
    CHECK(removed.share == doctest::Approx(1 / 217.0).epsilon(1e-3));
    CHECK(at(m, {20, 20, 20}) == kEmpty);
    CHECK(at(m, {8, 8, 8}) == kSolid - kAdded);
  }

  TEST_CASE("a speck that is there part of the time goes, at all times") {
    VoxelModel m = cube();
    at(m, {20, 20, 20}) = kSolid - kAdded;
    m = comes_on(std::move(m), 1);
    const Vec3 speck = m.radiance.raw.topology->lattice.position({20, 20, 20});
    CHECK(FrameSampler(m, 1).density(speck) > 5);
    CHECK(remove_floaters(m, 0.01).count == 1);
    for (const double t : {0.0, 0.5, 1.0}) CHECK(FrameSampler(m, t).density(speck) < 1e-4f);
    CHECK(at(m, {8, 8, 8}) == kSolid);
  }

  TEST_CASE("an empty model has no pieces") {
    VoxelModel m = nothing();
    const RemovedFloaters removed = remove_floaters(m, 0.01);
    CHECK(removed.count == 0);
    CHECK(removed.left == 0);
    CHECK(removed.share == 0);
  }
}
