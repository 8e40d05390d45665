// SPDX-License-Identifier: Apache-2.0
#include "io/export/velocity_band.hpp"

#include <doctest/doctest.h>

#include <cmath>

#include "splinevox/core/vec3.hpp"

using namespace splinevox;

namespace {

/// Voxels of [lo, hi) with the velocity that `of` says.
template <class Of>
LeafValues block(Int3 lo, Int3 hi, const Of& of) {
  const Int3 first{lo.x >> 3, lo.y >> 3, lo.z >> 3};
  LeafSet set(first, Int3{hi.x >> 3, hi.y >> 3, hi.z >> 3} - first + Int3{1, 1, 1});
  Int3 v;
  const auto each = [&](const auto& visit) {
    for (v.x = lo.x; v.x < hi.x; ++v.x)
      for (v.y = lo.y; v.y < hi.y; ++v.y)
        for (v.z = lo.z; v.z < hi.z; ++v.z) visit();
  };
  each([&] {
    LeafMask one{};
    add_voxel(one, (v.x & 7) << 6 | (v.y & 7) << 3 | (v.z & 7));
    set.unite({v.x >> 3, v.y >> 3, v.z >> 3}, one);
  });
  LeafValues out(std::move(set), 3);
  each([&] {
    const Vec3 velocity = of(v);
    for (int a = 0; a < 3; ++a) out.find(v)[a] = velocity[a];
  });
  return out;
}

}  // namespace

TEST_SUITE("io/velocity_band") {
  TEST_CASE("one velocity goes on as far as its matter moves, and one voxel more") {
    for (const double moved : {0.0, 0.3, 4.6}) {  // voxels in half the shutter
      CAPTURE(moved);
      const Vec3 velocity{0, 2, 0};
      const VelocityBand band =
          spread_velocity(block({-3, 0, 5}, {6, 9, 20}, [&](Int3) { return velocity; }), moved / 2);
      const int reach = int(std::ceil(moved)) + 1;
      CHECK(band.padding == reach);
      CHECK(band.missing == 0);
      CHECK(band.values.set().count() == std::uint64_t(9 + 2 * reach) * (9 + 2 * reach) * (15 + 2 * reach));
      LeafValues values = band.values;
      for (const Int3 v : {Int3{-3, 0, 5}, {-3 - reach, -reach, 5 - reach}, {5 + reach, 4, 19 + reach}}) {
        CHECK(values.set().active(v));
        CHECK(Vec3{values.find(v)[0], values.find(v)[1], values.find(v)[2]} == velocity);
      }
    }
  }

  TEST_CASE("what stands still beside what is fast gets one voxel") {
    const VelocityBand band = spread_velocity(block({0, 0, 0}, {60, 8, 8},
                                                    [](Int3 v) {
                                                      return Vec3{0, 0, v.x < 30 ? 0.0f : 10.0f};
                                                    }),
                                              1);
    CHECK(band.padding == 11);
    const LeafSet& set = band.values.set();
    for (const int z : {8, 9, 18, 19}) {
      CAPTURE(z);
      CHECK(set.active({5, 4, z}) == (z == 8));
      CHECK(set.active({55, 4, z}) == (z < 19));
    }
  }

  TEST_CASE("a voxel that is wrongly fast is averaged away") {
    const auto wrong = [](Int3 v) { return Vec3{v == Int3{7, 7, 15} ? 1000.0f : 0.0f, 0, 0}; };
    const VelocityBand band = spread_velocity(block({0, 0, 0}, {16, 16, 16}, wrong), 1);
    CHECK(band.values.set().count() < 40 * 40 * 40);
    CHECK_FALSE(band.values.set().active({7, 7, -3}));
  }

  TEST_CASE("memory has an end, and it is said how much is missing") {
    const VelocityBand band = spread_velocity(block({0, 0, 0}, {2, 2, 2},
                                                    [](Int3) {
                                                      return Vec3{99, 0, 0};
                                                    }),
                                              1);
    CHECK(band.padding == 64);
    CHECK(band.missing == 36);
    CHECK(spread_velocity(LeafValues(LeafSet({}, {2, 2, 2}), 3), 1).padding == 0);
  }
}
