// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include "field/lattice/lattice_view.hpp"
#include "splinevox/field/edit.hpp"
#include "support/empty_model.hpp"

using namespace splinevox;
using test::kEmpty;

namespace {

constexpr float kFog = -1.5f, kSolid = 6;  // raw densities: below 5% a voxel, opaque

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

  TEST_CASE("an empty model has no pieces") {
    VoxelModel m = nothing();
    const RemovedFloaters removed = remove_floaters(m, 0.01);
    CHECK(removed.count == 0);
    CHECK(removed.left == 0);
    CHECK(removed.share == 0);
  }
}
