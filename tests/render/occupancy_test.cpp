// SPDX-License-Identifier: Apache-2.0
#include "render/occupancy.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "field/warped_centers.hpp"
#include "math/activation.hpp"
#include "render/active_rows.hpp"
#include "splinevox/field/sample.hpp"

using namespace splinevox;

namespace {

/// A slab whose sides have 65, 4 and 39 cells, warped by a motion that is linear in space and time.
/// @param still_from  x from which on nothing moves
VoxelModel slab(float still_from = 2) {
  VoxelModel m;
  m.box = {{-1, -0.05f, -0.6f}, {1, 0.05f, 0.6f}};
  m.radiance.raw =
      make_channels(make_dense_topology(make_lattice(m.box, 8)), 8, std::vector<float>(8, 0.0f).data());
  m.motion.points = 3;
  m.motion.rigidity = false;
  m.motion.levels = {make_channels(make_dense_topology(make_lattice(m.box, 16)), m.motion.width(),
                                   std::vector<float>(8, 0.0f).data())};
  Channels& level = m.motion.levels[0];
  const Topology& t = *level.topology;
  for (int b = 1; b <= t.brick_count(); ++b)
    for (int i = 0; i < kBrickRows; ++i) {
      const Vec3 x = t.position(b, i);
      if (x.x >= still_from) continue;
      const Vec3 d{0.3f + 0.2f * x.x, 0.02f, -0.1f - 0.3f * x.z};
      for (int a = 0; a < 3; ++a)
        for (int k = 1; k < 3; ++k)
          level.row(std::size_t(b) * kBrickRows + i)[3 * (k - 1) + a] = 0.5f * float(k) * d[a];
    }
  return m;
}

/// The same with matter in a ball that is there in the second half of time, and in another in the first.
VoxelModel comes_and_goes(bool moves) {
  VoxelModel m = slab(moves ? 2.0f : -2.0f);
  m.step = 0.02f;
  m.motion.basis = BasisKind::bspline;
  m.motion.first_point = FirstPoint::free;
  m.motion.points = 8;
  m.motion.displaces = moves;
  m.motion.presence = true;
  const Channels old = m.motion.levels[0];
  const Topology& t = *old.topology;
  const std::vector<float> zero(std::size_t(m.motion.width()), 0.0f);
  Channels& level = m.motion.levels[0] = make_channels(old.topology, m.motion.width(), zero.data());
  const int stride = m.motion.stride();
  for (int b = 1; b <= t.brick_count(); ++b)
    for (int i = 0; i < kBrickRows; ++i) {
      const std::size_t r = std::size_t(b) * kBrickRows + i;
      const Vec3 x = t.position(b, i);
      const float late = length(x - Vec3{0.4f, 0, 0.1f}) < 0.3f ? 14.0f : 0.0f,
                  early = length(x - Vec3{-0.5f, 0, -0.1f}) < 0.3f ? 14.0f : 0.0f;
      for (int k = 0; k < 8; ++k) {
        float* p = level.row(r) + stride * k;
        if (moves)
          for (int a = 0; a < 3; ++a) p[a] = old.row(r)[3 + a] * float(k) / 7;
        p[stride - 1] = k < 4 ? early : late;
      }
    }
  for (std::size_t r = 0; r < m.radiance.raw.topology->rows(); ++r) m.radiance.raw.row(r)[0] = -9;
  m.radiance.activation = {10, 2};
  return m;
}

/// A ball, and what is in one layer of cells.
BitGrid matter(const VoxelModel& model) {
  BitGrid out(model.box, 65);
  Int3 c;
  for (c.x = 0; c.x < out.size.x; ++c.x)
    for (c.y = 0; c.y < out.size.y; ++c.y)
      for (c.z = 0; c.z < out.size.z; ++c.z)
        if (length(out.center(c) - Vec3{0.5f, 0, 0.2f}) < 0.3f || c.x == 3) out.set(out.index(c));
  return out;
}

/// The cells that are not set.
BitGrid inverse(BitGrid grid) {
  for (std::uint32_t& word : grid.bits) word = ~word;
  return grid;
}

}  // namespace

TEST_SUITE("render/occupancy") {
  TEST_CASE(
      "a frame's cells are those whose centre is warped into an occupied one, found by blocks or one by "
      "one") {
    const VoxelModel model = slab();
    const BitGrid some = matter(model), most = inverse(some);
    Int3 c;
    for (const BitGrid* canonical : {&some, &most})
      for (const double time : {0.0, 0.45, 1.0}) {
        CAPTURE(time);
        const FrameSampler sampler(model, time);
        const OccupancyPyramid pyramid(*canonical);
        CHECK(pyramid.full[1].test(pyramid.full[1].index({6, 0, 2})) == (canonical == &most));
        const BitGrid found =
            frame_occupancy(model, make_slice(model.motion, stored_weights(model.motion, time)), pyramid);
        int differ = 0;
        for (c.x = 0; c.x < some.size.x; ++c.x)
          for (c.y = 0; c.y < some.size.y; ++c.y)
            for (c.z = 0; c.z < some.size.z; ++c.z) {
              const Vec3 x = sampler.canonical(min(some.center(c), model.box.hi));
              differ += found.test(some.index(c)) != canonical->test(some.index(some.cell_of(x)));
            }
        CHECK(found.count() > 100);
        CHECK(differ <= 3);  // a centre that lands on the border of two cells may round either way
      }
  }
  TEST_CASE("where matter comes and goes no place is skipped that has any, and most of what has none is") {
    constexpr float kAlpha = 0.01f;
    for (const bool moves : {false, true}) {
      CAPTURE(moves);
      const VoxelModel model = comes_and_goes(moves);
      const OccupancyPyramid canonical(model, 40, kAlpha, model.step);
      const BitGrid ever = canonical_occupancy(model, 40, kAlpha, model.step);
      for (const double time : {0.0, 0.2, 0.75, 0.9, 1.0}) {
        CAPTURE(time);
        const FrameSampler sampler(model, time);
        const BitGrid found =
            frame_occupancy(model, make_slice(model.motion, stored_weights(model.motion, time)), canonical);
        int matter = 0, skipped = 0, pruned = 0;
        const Vec3 size = model.box.extent();
        for (int i = 0; i < 80; ++i)
          for (int j = 0; j < 9; ++j)
            for (int k = 0; k < 60; ++k) {
              const Vec3 x =
                  model.box.lo + Vec3{size.x * (float(i) + 0.5f) / 80, size.y * (float(j) + 0.5f) / 9,
                                      size.z * (float(k) + 0.5f) / 60};
              if (one_minus_exp_neg(sampler.density(x) * model.step) < kAlpha) continue;
              ++matter;
              skipped += !found.test(found.index(found.cell_of(x)));
              const Vec3 there = sampler.canonical(x);
              if (max(there, model.box.lo) == min(there, model.box.hi))
                pruned += !ever.test(ever.index(ever.cell_of(there)));
            }
        CHECK(matter > 100);
        CHECK(skipped == 0);
        CHECK(pruned == 0);
        CHECK(found.count() < found.cells() / 2);
      }
    }
  }
  TEST_CASE("a frame's cells are the same if it is known where nothing is displaced") {
    for (const float still_from : {-2.0f, -0.2f, 0.6f}) {
      CAPTURE(still_from);
      const VoxelModel model = slab(still_from);
      const Channels& level = model.motion.levels[0];
      const BitGrid canonical = matter(model),
                    reach = reach_of(*level.topology, nonzero_rows(level), canonical);
      CHECK((reach.count() > 0) == (still_from > -1));
      CHECK(reach.count() < reach.cells());
      for (const double time : {0.0, 0.45, 1.0}) {
        const MotionSlice slice = make_slice(model.motion, stored_weights(model.motion, time));
        CHECK(frame_occupancy(model, slice, OccupancyPyramid(canonical, reach)).bits ==
              frame_occupancy(model, slice, OccupancyPyramid(canonical)).bits);
      }
    }
  }
  TEST_CASE("eight centres are warped as each is alone, in one motion cell or in several") {
    VoxelModel model = slab();
    model.motion.rigidity = true;
    model.motion.presence = true;
    const TopologyPtr topology = model.motion.levels[0].topology;
    const std::vector<float> zero(std::size_t(model.motion.width()), 0.0f);
    Channels& level = model.motion.levels[0] = make_channels(topology, model.motion.width(), zero.data());
    for (std::size_t i = kBrickRows * zero.size(); i < level.values.size(); ++i)
      level.values[i] = std::sin(float(i));
    const MotionSlice slice = make_slice(model.motion, stored_weights(model.motion, 0.4));
    for (const int cells : {65, 32, 16}) {  // four, two and one a motion cell and axis
      CAPTURE(cells);
      const CellGrid grid(model.box, cells);
      const WarpedCenters warped(model, slice, grid);
      float apart = 0;
      Int3 first;
      for (first.x = 0; first.x < grid.size.x; first.x += 2)
        for (first.y = 0; first.y < grid.size.y; first.y += 2)
          for (first.z = 0; first.z < grid.size.z; first.z += 2) {
            const WarpedCenters::Eight eight = warped.eight(first);
            for (int i = 0; i < kCorners; ++i) {
              const Int3 c = first + corner(i);
              if (c.x >= grid.size.x || c.y >= grid.size.y || c.z >= grid.size.z) continue;
              const WarpedCenters::Warped alone = warped.at(c);
              apart = std::max({apart, length(eight.at(i) - alone.position),
                                std::abs(eight.presence[i] - alone.presence)});
            }
          }
      CHECK(apart < 1e-6f);
    }
  }
  TEST_CASE("matter that stands still is not lost beside what comes from far away") {
    VoxelModel model = slab(0.22f);
    Channels& level = model.motion.levels[0];
    for (std::size_t r = kBrickRows; r < level.topology->rows(); ++r)
      for (float& v : std::span(level.row(r), 6)) v *= 8;  // it looks up what lies beyond the box
    const BitGrid canonical = matter(model),
                  reach = reach_of(*level.topology, nonzero_rows(level), canonical);
    const BitGrid found = frame_occupancy(model, make_slice(model.motion, stored_weights(model.motion, 1)),
                                          OccupancyPyramid(canonical, reach));
    int still = 0, lost = 0;
    for (std::size_t c = 0; c < canonical.cells(); ++c)
      if (canonical.test(c) && !reach.test(c)) {
        ++still;
        lost += !found.test(c);
      }
    CHECK(still > 100);
    CHECK(lost == 0);
  }
}
