// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "splinevox/core/error.hpp"
#include "splinevox/field/edit.hpp"
#include "splinevox/field/sample.hpp"
#include "support/empty_model.hpp"

using namespace splinevox;

namespace {

constexpr Vec3 kStillBall{-0.5f, -0.5f, 0}, kMovingBall{0.4f, 0, -0.4f};
constexpr float kRise = 0.8f;  ///< of the moving ball from time 0 to 1, along z

/// Two balls of radius 0.2: one stands, one rises. Its colour is a function of the place within it.
VoxelModel two_balls() {
  VoxelModel m = test::empty_model(48, {60, -4}, 1);
  const Topology& t = *m.radiance.raw.topology;
  for (int b = 1; b <= t.brick_count(); ++b)
    for (int i = 0; i < kBrickRows; ++i) {
      const Vec3 x = t.position(b, i);
      const bool first = length(x - kStillBall) < length(x - kMovingBall);
      const Vec3 d = x - (first ? kStillBall : kMovingBall);
      float* row = m.radiance.raw.row(std::size_t(b) * kBrickRows + std::size_t(i));
      row[0] = std::clamp((0.2f - length(d)) / 0.02f, -14.0f, 6.0f);
      row[1] = 10 * d.x;
      row[2] = 10 * d.y;
      row[3] = 10 * d.z;
      row[4] = 0.1f;
      row[5] = 0.2f;
      row[6] = 0.3f;
      row[7] = 0.4f;
    }
  m.motion.points = 2;
  m.motion.rigidity = false;
  Channels& level = test::add_level(m, 12);
  for (int b = 1; b <= level.topology->brick_count(); ++b)
    for (int i = 0; i < kBrickRows; ++i)
      if (level.topology->position(b, i).x > -0.01f)
        level.row(std::size_t(b) * kBrickRows + std::size_t(i))[2] = -kRise;
  return m;
}

/// The same, and the ball that rises grows denser.
VoxelModel growing_denser() {
  VoxelModel m = two_balls();
  const Channels old = m.motion.levels[0];
  m.motion.first_point = FirstPoint::free;
  m.motion.presence = true;
  const int stride = m.motion.stride(), width = m.motion.width();
  m.motion.levels[0] =
      make_channels(old.topology, width, std::vector<float>(std::size_t(width), 0.0f).data());
  for (std::size_t r = kBrickRows; r < old.topology->rows(); ++r) {
    if (old.row(r)[2] == 0) continue;
    float* row = m.motion.levels[0].row(r);
    row[stride + 2] = old.row(r)[2];
    row[3] = -2;
    row[stride + 3] = 2;
  }
  return m;
}

/// A solid ball on the left. On the right the canonical volume has another one, which is thin on the mean
/// over time. It is shown further along y, where presence makes it dense in the end.
VoxelModel brief_ball() {
  VoxelModel m = test::empty_model(48, {60, -4}, -1);
  const Topology& t = *m.radiance.raw.topology;
  for (int b = 1; b <= t.brick_count(); ++b)
    for (int i = 0; i < kBrickRows; ++i) {
      const Vec3 x = t.position(b, i);
      const bool left = x.x < 0;
      const float d = length(x - Vec3{left ? -0.5f : 0.5f, 0, 0});
      m.radiance.raw.row(std::size_t(b) * kBrickRows + std::size_t(i))[0] =
          std::clamp((0.2f - d) / 0.02f, test::kEmpty, left ? 6.0f : -6.0f);
    }
  m.motion.points = 2;
  m.motion.first_point = FirstPoint::free;
  m.motion.rigidity = false;
  m.motion.presence = true;
  const int stride = m.motion.stride();
  Channels& level = test::add_level(m, 12);
  for (int b = 1; b <= level.topology->brick_count(); ++b)
    for (int i = 0; i < kBrickRows; ++i) {
      if (const Vec3 x = level.topology->position(b, i); x.x < 0.1f || x.y < 0.6f) continue;
      float* row = level.row(std::size_t(b) * kBrickRows + std::size_t(i));
      for (int k = 0; k < 2; ++k) {
        row[stride * k + 1] = -0.75f;
        row[stride * k + 3] = k == 0 ? -12.0f : 12.0f;
      }
    }
  return m;
}

float density(const VoxelModel& m, double t, Vec3 x) {
  const FrameSampler s(m, t);
  return s.radiance(s.canonical(x)).density;
}

Vec3 ball_at(double t) { return kMovingBall + Vec3{0, 0, kRise * float(t)}; }

/// Largest difference of density (relative) and colour of the ball of one model and, carried there, of
/// another.
double ball_difference(const VoxelModel& a, double at_a, const VoxelModel& b, double at_b,
                       const RigidMotion& g) {
  const FrameSampler x(a, at_a), y(b, at_b);
  double worst = 0;
  for (int i = 0; i < 400; ++i) {
    const float u = float(i) / 400, phi = 40 * u;
    const Vec3 d = 0.22f * std::cbrt(float(i % 20) / 20) *
                   Vec3{std::sqrt(4 * u * (1 - u)) * std::cos(phi),
                        std::sqrt(4 * u * (1 - u)) * std::sin(phi), 1 - 2 * u};
    const Vec3 p = ball_at(at_a) + d, q = cast<float>(g(cast<double>(p)));
    const auto v = x.radiance(x.canonical(p)), w = y.radiance(y.canonical(q));
    worst = std::max(worst, double(std::abs(v.density - w.density)) / 100);
    if (v.density > 1) worst = std::max(worst, double(length(v.color - w.color)));
  }
  return worst;
}

RigidMotion shift(Vec3d by) {
  RigidMotion g;
  g.offset = by;
  return g;
}

}  // namespace

TEST_SUITE("field/edit_cluster") {
  TEST_CASE("what moves and what stands come apart; one of them is hidden or kept at all times") {
    const VoxelModel model = two_balls();
    const MotionClusters c = find_clusters(model, 0);
    REQUIRE(c.clusters.size() == 2);
    CHECK(c.at(kStillBall + Vec3{0.19f, 0, 0}) == 0);
    CHECK(c.at(kMovingBall + Vec3{0, -0.19f, 0}) == 1);
    CHECK(c.at({0, 0.9f, 0.9f}) == -1);
    CHECK(c.clusters[0].motion < 0.1);
    CHECK(c.clusters[1].motion ==
          doctest::Approx(kRise * 24 / std::sqrt(12.0)).epsilon(0.1));  // of an even rise
    CHECK(c.clusters[1].share == doctest::Approx(0.5).epsilon(0.2));
    CHECK(length(c.clusters[1].center - kMovingBall) < 0.03f);
    VoxelModel hidden = model, kept = model;
    hide_clusters(hidden, c, {false, true});
    keep_clusters(kept, c, {false, true});
    for (const double t : {0.0, 0.5, 1.0}) {
      CHECK(density(model, t, ball_at(t)) > 100);
      CHECK(density(hidden, t, ball_at(t)) < 1e-3f);
      CHECK(density(kept, t, ball_at(t)) == density(model, t, ball_at(t)));
      CHECK(density(hidden, t, kStillBall) == density(model, t, kStillBall));
      CHECK(density(kept, t, kStillBall) < 1e-3f);
    }
  }
  TEST_CASE("a painted part has its colour from every side") {
    VoxelModel model = two_balls();
    const MotionClusters c = find_clusters(model, 2);
    paint_clusters(model, c, {false, true}, {0.6f, 0.3f, 0.15f});
    const FrameSampler s(model, 0);
    const auto r = s.radiance(kMovingBall);
    CHECK(0.75f * r.color.x == doctest::Approx(0.6));
    CHECK(0.75f * r.color.z == doctest::Approx(0.15));
    CHECK(r.sh[3] == 0);
    CHECK(s.radiance(kStillBall).sh[3] == 0.4f);
  }
  TEST_CASE(
      "a part that is moved by whole voxels of both lattices is the same elsewhere, to rounding, at all "
      "times") {
    const VoxelModel model = two_balls();
    const MotionClusters c = find_clusters(model, 2);
    for (const Vec3d by :
         {Vec3d{0, 0.5, 0}, Vec3d{0, 0, 2}, Vec3d{0.5, -2, 0}}) {  // within the box, and out of it
      CAPTURE(by.z);
      VoxelModel moved = model;
      const PartEdit e = carry_clusters(moved, c, {false, true}, shift(by), 0.02);
      CHECK(e.disturbed == 0);
      CHECK(e.covered == 0);
      CHECK(e.error_max < 1e-4);
      for (const double t : {0.0, 0.4, 1.0}) {
        CHECK(ball_difference(model, t, moved, t, shift(by)) < 1e-3);
        CHECK(density(moved, t, ball_at(t) + Vec3{0, 0, 0}) < 1e-3f);
        CHECK(density(moved, t, kStillBall) == doctest::Approx(density(model, t, kStillBall)).epsilon(1e-3));
      }
    }
  }
  TEST_CASE("a part that is turned keeps its path, turned; any other offset costs what resampling costs") {
    const VoxelModel model = two_balls();
    const MotionClusters c = find_clusters(model, 2);
    VoxelModel turned = model;
    const RigidMotion g = rotation({1, 0, 0}, 90, {0.5, 0, 0});
    const PartEdit e = carry_clusters(turned, c, {false, true}, g, 0.02);
    CHECK(e.error_max < 1e-3);
    for (const double t : {0.0, 0.6, 1.0}) CHECK(ball_difference(model, t, turned, t, g) < 1e-2);
    VoxelModel odd = model;
    CHECK(carry_clusters(odd, c, {false, true}, shift({0.013, 0.471, 0.02}), 0.02).error_rms < 0.05);
    CHECK(ball_difference(model, 0.5, odd, 0.5, shift({0.013, 0.471, 0.02})) < 0.5);
  }
  TEST_CASE("harmonics turn with the part: what was seen from a side is seen from the turned side") {
    const VoxelModel model = two_balls();
    VoxelModel turned = model;
    carry_clusters(turned, find_clusters(model, 2), {false, true},
                   rotation({1, 0, 0}, 90, cast<double>(kMovingBall)), 0.02);
    const auto r = FrameSampler(turned, 0).radiance(kMovingBall);
    // Y1 ~ y, Y2 ~ z, Y3 ~ x; y turns into z and z into -y.
    CHECK(r.sh[0] == doctest::Approx(0.1));
    CHECK(r.sh[1] == doctest::Approx(-0.3));
    CHECK(r.sh[2] == doctest::Approx(0.2));
    CHECK(r.sh[3] == doctest::Approx(0.4));
  }
  TEST_CASE("what would drag other matter along is refused and changes nothing") {
    VoxelModel model = two_balls();
    const MotionClusters c = find_clusters(model, 2);
    const PartEdit e = carry_clusters(model, c, {false, true}, shift({-0.9, -0.5, 0}), 0.02);
    CHECK(e.disturbed > 0.5);
    CHECK(density(model, 0, kMovingBall) > 100);
    CHECK(model.box == two_balls().box);
  }
  TEST_CASE("a part has a time of its own; the rest does not") {
    VoxelModel model = two_balls();
    const VoxelModel before = model;
    const PartEdit e = slow_clusters(model, find_clusters(model, 2), {false, true}, 0.5, 0.02);
    CHECK(e.disturbed == 0);
    CHECK(e.error_max < 1e-4);
    for (const double t : {0.0, 0.3, 0.5}) CHECK(ball_difference(before, t, model, 2 * t, shift({})) < 1e-3);
  }
  TEST_CASE(
      "a part whose presence would have another mean over time is not slowed, and is without presence") {
    VoxelModel model = growing_denser();
    const VoxelModel before = model;
    const MotionClusters c = find_clusters(model, 2);
    const ChosenClusters rising{false, true};
    CHECK_THROWS_WITH_AS(slow_clusters(model, c, rising, 0.5, 0.02), doctest::Contains("--freeze-presence"),
                         Error);
    CHECK(model.motion.levels[0].values == before.motion.levels[0].values);
    VoxelModel mean = before, frozen = before;
    scale_presence(mean.motion, 0);
    freeze_presence(frozen, 0.5);
    for (const VoxelModel& steady : {mean, frozen}) {
      VoxelModel slowed = steady;
      CHECK(slow_clusters(slowed, c, rising, 0.5, 0.02).disturbed == 0);
      for (const double t : {0.0, 0.3, 0.5})
        CHECK(ball_difference(steady, t, slowed, 2 * t, shift({})) < 1e-3);
    }
  }
  TEST_CASE("what was hidden stays hidden when presence grows or motion changes, and empty air stays empty") {
    VoxelModel model = growing_denser();
    hide_clusters(model, find_clusters(model, 2), {false, true});
    using Change = std::function<void(MotionField&)>;
    for (const Change& change : {Change([](MotionField& m) { scale_presence(m, 3); }),
                                 Change([](MotionField& m) { scale_presence(m, -3); }),
                                 Change([](MotionField& m) { scale_motion(m, -1); })}) {
      VoxelModel scaled = model;
      keep_emptied(scaled, change);
      for (const double t : {0.0, 0.4, 1.0}) {
        const FrameSampler sampler(scaled, t), before(model, t);
        double most = 0, other = 0;
        for (float x = -0.9f; x <= 0.9f; x += 0.1f)
          for (float z = -0.9f; z <= 0.9f; z += 0.1f) {
            most = std::max(most, double(sampler.density({x, 0, z})));
            other = std::max(other, double(before.density({x, 0, z})));
          }
        CHECK(most == doctest::Approx(other).epsilon(1e-3));  // the other ball, which does not come and go
      }
    }
  }
  TEST_CASE("a part does not come to where other canonical matter is seen part of the time") {
    VoxelModel model = brief_ball();
    const VoxelModel before = model;
    MotionClusters c;
    c.cells = model.radiance.raw.topology->lattice;
    c.clusters.resize(2);
    for (int x = 0; x < c.cells.size.x; ++x)
      c.label.insert(c.label.end(), std::size_t(c.cells.size.y) * c.cells.size.z,
                     c.cells.position({x, 0, 0}).x < 0);
    const PartEdit e = carry_clusters(model, c, {false, true}, shift({1, 0, 0}), 0.02);
    CHECK(e.disturbed == 0);
    CHECK(e.covered > 0.5);
    CHECK(model.radiance.raw.values == before.radiance.raw.values);
  }
}
