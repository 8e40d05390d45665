// SPDX-License-Identifier: Apache-2.0
#include "io/vdb/leaf_set.hpp"

#include <doctest/doctest.h>

#include <random>
#include <set>
#include <tuple>

#include "field/lattice/slice.hpp"
#include "field/matter_reach.hpp"
#include "support/blob_model.hpp"

using namespace splinevox;

namespace {

using Key = std::tuple<int, int, int>;

LeafSet random_set(unsigned seed, int voxels) {
  std::mt19937 random(seed);
  std::set<Key> leaves;
  std::vector<LeafMask> masks;
  LeafSet set({-2, 0, 1}, {4, 3, 5});
  for (int l = 0; l < 6; ++l) {
    const Int3 at{int(random() % 4) - 2, int(random() % 3), int(random() % 5) + 1};
    if (!leaves.insert({at.x, at.y, at.z}).second) continue;
    LeafMask mask{};
    for (int i = 0; i < voxels; ++i) mask[random() % 8] |= std::uint64_t(1) << random() % 64;
    set.add(at, mask);
  }
  return set;
}

std::set<Key> voxels_of(const LeafSet& set) {
  std::set<Key> out;
  for (std::size_t l = 0; l < set.size(); ++l)
    for (int i = 0; i < 512; ++i)
      if (set.masks()[l][std::size_t(i >> 6)] >> (i & 63) & 1) {
        const Int3 v = 8 * set.leaves()[l] + Int3{i >> 6, i >> 3 & 7, i & 7};
        out.insert({v.x, v.y, v.z});
      }
  return out;
}

}  // namespace

TEST_SUITE("io/leaf_set") {
  TEST_CASE("growing is what it says, voxel by voxel") {
    for (unsigned seed = 0; seed < 20; ++seed) {
      CAPTURE(seed);
      const LeafSet set = random_set(seed, seed < 10 ? 2 : 40);
      const std::set<Key> before = voxels_of(set);
      CHECK(set.count() == before.size());
      for (const int n : {0, 1, 2, 9}) {
        CAPTURE(n);
        std::set<Key> expected;
        if (n * before.size() < 500)
          for (const auto& [x, y, z] : before)
            for (int dx = -n; dx <= n; ++dx)
              for (int dy = -n; dy <= n; ++dy)
                for (int dz = -n; dz <= n; ++dz) expected.insert({x + dx, y + dy, z + dz});
        else
          continue;
        const LeafSet grown = set.grown(n);
        CHECK(voxels_of(grown) == expected);
        for (const auto& [x, y, z] : before) CHECK(grown.active({x, y, z}));
        CHECK_FALSE(grown.active({500, 0, 0}));
      }
    }
  }

  TEST_CASE("an empty set stays empty") {
    CHECK(LeafSet({}, {2, 2, 2}).grown(3).size() == 0);
    CHECK(LeafSet().grown(1).count() == 0);
  }

  TEST_CASE("the search for leaves passes over most of an empty box") {
    const VoxelModel model = test::blob_model(96, {.shift = {-0.5f, 0.1f, 0.2f}});
    const Lattice& lattice = model.radiance.raw.topology->lattice;
    const double all = double(test::all_bricks(lattice).size());
    for (const double time : {0.0, 0.5, 1.0}) {
      const double found =
          double(MatterReach(model, 0.05f).candidates(lattice, stored_weights(model.motion, time)).size());
      CAPTURE(found);
      CHECK(found > 0.02 * all);
      CHECK(found < 0.35 * all);
    }
  }
}
