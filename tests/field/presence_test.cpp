// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "splinevox/field/edit.hpp"
#include "splinevox/field/sample.hpp"
#include "support/blob_model.hpp"
#include "support/empty_model.hpp"

using namespace splinevox;

namespace {

VoxelModel noisy() {
  return test::noisy_model(3, 7, FirstPoint::free, BasisKind::bspline, 1, true, true, true);
}

constexpr Vec3 kFirst{0.125f, 0, 0}, kWay{0.25f, 0.1f, 0};  ///< displacement at time 0; its change to time 1
constexpr double kDense = 0.4;                              ///< when the ball below is dense

/// A ball about the canonical origin that is thin on the mean over time. All is displaced alike.
VoxelModel dense_for_a_while() {
  VoxelModel m = test::empty_model(32, {60, -4}, -1);
  const Topology& t = *m.radiance.raw.topology;
  for (int b = 1; b <= t.brick_count(); ++b)
    for (int i = 0; i < kBrickRows; ++i)
      m.radiance.raw.row(std::size_t(b) * kBrickRows + std::size_t(i))[0] =
          std::clamp(2 - 40 * length(t.position(b, i)), test::kEmpty, -8.0f);
  m.motion.basis = BasisKind::bspline;
  m.motion.first_point = FirstPoint::free;
  m.motion.points = 8;
  m.motion.rigidity = false;
  m.motion.presence = true;
  const int stride = m.motion.stride();
  Channels& level = test::add_level(m, 8);
  const Vec3 seen = -1.0f * (kFirst + float(kDense) * kWay);
  for (int b = 1; b <= level.topology->brick_count(); ++b)
    for (int i = 0; i < kBrickRows; ++i) {
      float* row = level.row(std::size_t(b) * kBrickRows + std::size_t(i));
      for (int k = 0; k < 8; ++k)  // evenly over time
        for (int a = 0; a < 3; ++a) row[stride * k + a] = kFirst[a] + float(k - 1) / 5 * kWay[a];
      if (length(level.topology->position(b, i) - seen) < 0.5f) row[stride * 3 + 3] = 24;
    }
  return m;
}

}  // namespace

TEST_SUITE("field/presence") {
  TEST_CASE("presence scales about its mean over time, and 0 leaves the mean") {
    VoxelModel model = noisy(), doubled = model, none = model;
    scale_presence(doubled.motion, 2);
    scale_presence(none.motion, 0);
    VoxelModel same = model;
    keep_emptied(same, [](MotionField& motion) { scale_presence(motion, 1); });
    CHECK(same.radiance.raw.values == model.radiance.raw.values);
    CHECK(same.motion.levels[0].values == model.motion.levels[0].values);
    const Vec3 x{0.2f, -0.1f, 0.1f};
    for (const double t : {0.0, 0.3, 1.0}) {
      const auto before = FrameSampler(model, t).warp(x), twice = FrameSampler(doubled, t).warp(x);
      CHECK(before.presence != 0);
      CHECK(twice.presence == doctest::Approx(2 * before.presence).epsilon(1e-5));
      CHECK(length(twice.displacement - before.displacement) == 0);
      const FrameSampler still(none, t);
      CHECK(still.warp(x).presence == 0);
      CHECK(still.density(x) == still.radiance(still.canonical(x)).density);
    }
    CHECK(motion_difference(model, model).opacity == 0);
    CHECK(motion_difference(model, doubled).opacity > 1e-3);
    CHECK(motion_difference(model, doubled).max == 0);
  }

  TEST_CASE("what is there at a time stays once presence is frozen: its density, motion and light") {
    VoxelModel model = noisy();
    for (std::size_t r = 0; r < model.motion.levels[0].topology->rows(); ++r)
      for (int k = 0; k < model.motion.points; ++k)  // a gentle warp, and a presence that counts
        for (int a = 0; a < 5; ++a)
          model.motion.levels[0].row(r)[model.motion.stride() * k + a] *= a < 3 ? 0.1f : a == 4 ? 8.0f : 1.0f;
    VoxelModel frozen = model;
    constexpr double kTime = 0.6;
    freeze_presence(frozen, kTime);
    CHECK_FALSE(frozen.motion.presence);
    CHECK(frozen.motion.light);
    const FrameSampler before(model, kTime), after(frozen, kTime);
    double error = 0, changed = 0;
    int count = 0;
    for (int i = 0; i < 400; ++i) {
      const Vec3 x{-0.2f + 0.6f * float(i % 20) / 20, -0.3f + 0.5f * float(i / 20) / 20, 0.05f};
      const float d = before.density(x);
      if (d == 0) continue;
      ++count;
      error += std::abs(std::log(after.density(x) / d));
      changed += std::abs(std::log(before.radiance(before.canonical(x)).density / d));
      CHECK(after.warp(x).light == doctest::Approx(before.warp(x).light).epsilon(1e-5));
      CHECK(length(after.warp(x).displacement - before.warp(x).displacement) < 1e-6f);
    }
    CHECK(count > 100);
    CHECK(changed / count > 0.2);
    CHECK(error < 0.2 * changed);  // two lattices: what is between their vertices differs
  }

  TEST_CASE("the first moment becomes canonical with the matter that is there at other times alone") {
    const VoxelModel model = dense_for_a_while();
    VoxelModel anchored = model;
    CHECK(anchor_first(anchored).max < 0.05);
    CHECK(length(FrameSampler(anchored, 0).warp({}).displacement) < 1e-5f);
    CHECK(anchored.radiance.raw.topology->brick_count() < model.radiance.raw.topology->brick_count());
    int dense = 0, wrong = 0;
    for (const double t : {0.0, 0.25, kDense, 0.9}) {
      CAPTURE(t);
      const FrameSampler before(model, t), after(anchored, t);
      for (int i = 0; i < 1000; ++i) {
        const Vec3 x =
            Vec3{-0.6f, -0.4f, -0.4f} + 0.08f * Vec3{float(i % 10), float(i / 10 % 10), float(i / 100)};
        const float was = before.density(x);
        dense += was > 10;
        wrong += std::abs(after.density(x) - was) > 0.02f * was + 3e-3f;
      }
    }
    CHECK(dense > 50);
    CHECK(wrong == 0);
  }

  TEST_CASE("a track tells the density where it leads") {
    const VoxelModel model = noisy();
    const std::vector<Vec3> points{{0.1f, 0, 0.05f}, {0.15f, -0.1f, 0}};
    const std::vector<double> times{0.0, 0.5, 1.0};
    const auto found = track(model, points, 0.5, times);
    for (std::size_t k = 0; k < times.size(); ++k)
      for (const TrackedPoint& p : found[k])
        CHECK(p.density == doctest::Approx(FrameSampler(model, times[k]).density(p.position)).epsilon(1e-3));
    CHECK(found[1][0].density > 0);
  }
}
