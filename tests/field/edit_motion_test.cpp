// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <cstring>

#include "math/time_curve.hpp"
#include "splinevox/field/edit.hpp"
#include "splinevox/field/sample.hpp"
#include "support/blob_model.hpp"

using namespace splinevox;
using test::blob_model, test::noisy_model;

namespace {

/// Largest difference of displacement (scene units), gain of the light and rigidity at some places and times.
double difference(const VoxelModel& a, double at_a, const VoxelModel& b, double at_b) {
  const FrameSampler x(a, at_a), y(b, at_b);
  std::mt19937 random(7);
  std::uniform_real_distribution<float> u(-0.9f, 0.7f);
  double worst = 0;
  for (int i = 0; i < 200; ++i) {
    const Vec3 p{u(random), u(random), u(random)};
    const auto v = x.warp(p), w = y.warp(p);
    worst = std::max({worst, double(length(v.displacement - w.displacement)),
                      double(std::abs(v.light - w.light)), double(std::abs(v.rigidity - w.rigidity))});
  }
  return worst;
}

VoxelModel in_basis(const VoxelModel& m, BasisKind basis, int points) {
  VoxelModel out = m;
  out.motion = converted(m.motion, basis, points);
  return out;
}

bool same_values(const MotionField& a, const MotionField& b) {
  return a.levels[0].values.size() == b.levels[0].values.size() &&
         std::memcmp(a.levels[0].values.data(), b.levels[0].values.data(), 4 * a.levels[0].values.size()) ==
             0;
}

}  // namespace

TEST_SUITE("field/edit_motion") {
  TEST_CASE("a change of time moves pictures in time and touches no control point; light goes with it") {
    const VoxelModel model = noisy_model(4, 6, FirstPoint::free, BasisKind::bspline, 1, true, true);
    VoxelModel edited = model;
    retime(edited.motion, reversed_time());
    for (const double t : {0.0, 0.25, 0.6, 1.0}) CHECK(difference(edited, t, model, 1 - t) == 0);
    CHECK(difference(edited, 0, model, 0) > 1e-3);
    const FrameSampler back(edited, 0.25), there(model, 0.75);
    CHECK(length(back.warp({0.1f, 0.1f, 0.1f}).velocity_to_canonical +
                 there.warp({0.1f, 0.1f, 0.1f}).velocity_to_canonical) == 0);
    retime(edited.motion, reversed_time());
    CHECK(edited.motion.time_curve.identity());
    CHECK(same_values(edited.motion, model.motion));
    retime(edited.motion, speed_time(0.5));
    for (const double t : {0.0, 0.125, 0.3, 0.5}) CHECK(difference(edited, 2 * t, model, t) == 0);
    edited = model;
    retime(edited.motion, frozen_time(0.4));
    CHECK(difference(edited, 0.9, model, 0.4) == 0);
    CHECK(length(FrameSampler(edited, 0.9).warp({}).velocity_to_canonical) == 0);
  }
  TEST_CASE("points are tracked along the motion, not along time: through a jump of a loop as well") {
    VoxelModel model = blob_model(32);
    const std::vector<Vec3> points{{0.1f, -0.05f, 0.1f}, {0, 0, 0}};
    const auto plain = track(model, points, 0, std::vector<double>{0.5, 0.25});
    retime(model.motion, loop_time(2, false));
    const auto looped = track(model, points, 0, std::vector<double>{0.25, 0.625});
    for (std::size_t i = 0; i < points.size(); ++i) {
      CHECK(looped[0][i].position == plain[0][i].position);
      CHECK(length(looped[1][i].position - plain[1][i].position) < 1e-6f);
      CHECK_FALSE(looped[1][i].folded);
    }
  }
  TEST_CASE("scaled motion leaves light and rigidity") {
    const VoxelModel model = noisy_model(5, 5, FirstPoint::zero, BasisKind::bezier, 1, true, true);
    VoxelModel edited = model;
    scale_motion(edited.motion, 0.5f);
    const FrameSampler a(model, 0.7), b(edited, 0.7);
    for (const Vec3 p : {Vec3{0.1f, 0.2f, 0}, Vec3{-0.5f, 0.3f, 0.4f}}) {
      CHECK(b.warp(p).displacement == 0.5f * a.warp(p).displacement);
      CHECK(b.warp(p).light == a.warp(p).light);
      CHECK(b.warp(p).rigidity == a.warp(p).rigidity);
    }
  }
  TEST_CASE("degree elevation is exact to rounding, pinned or free, with light") {
    for (const FirstPoint first : {FirstPoint::zero, FirstPoint::free}) {
      VoxelModel model = noisy_model(6, 5, first, BasisKind::bezier, 0, true, true), more = model;
      more.motion = elevated(model.motion, 9);
      CHECK(more.motion.points == 14);
      CHECK(more.motion.first_point == first);
      for (const double t : {0.0, 0.3, 0.8, 1.0}) CHECK(difference(more, t, model, t) < 5e-7);
    }
  }
  TEST_CASE("a basis that holds the old curves holds them exactly, to rounding") {
    const VoxelModel spline =
        noisy_model(7, 7, FirstPoint::free, BasisKind::bspline, 0, true, true);  // 4 spans
    const VoxelModel bezier = noisy_model(8, 4, FirstPoint::zero, BasisKind::bezier, 0, true, true);
    struct Row {
      const VoxelModel& from;
      BasisKind to;
      int points;
    };
    for (const Row& row : {Row{spline, BasisKind::poly_bezier, 13}, Row{spline, BasisKind::hermite, 10},
                           Row{spline, BasisKind::hermite, 18}, Row{spline, BasisKind::bspline, 11},
                           Row{bezier, BasisKind::bspline, 4}, Row{bezier, BasisKind::bspline, 9},
                           Row{bezier, BasisKind::poly_bezier, 7}, Row{bezier, BasisKind::hermite, 4},
                           Row{bezier, BasisKind::bezier, 15}}) {
      CAPTURE(int(row.to));
      CAPTURE(row.points);
      const VoxelModel to = in_basis(row.from, row.to, row.points);
      for (const double t : {0.0, 0.3, 0.8, 1.0}) CHECK(difference(to, t, row.from, t) < 2e-6);
      const VoxelModel back = in_basis(to, row.from.motion.basis, row.from.motion.points);
      for (const double t : {0.0, 0.45, 1.0}) CHECK(difference(back, t, row.from, t) < 4e-6);
      CHECK(motion_difference(row.from, to).max * row.from.radiance.raw.topology->lattice.spacing < 2e-6);
    }
    CHECK(in_basis(bezier, BasisKind::hermite, 4).motion.first_point == FirstPoint::zero);
    CHECK(in_basis(bezier, BasisKind::bspline, 4).motion.first_point == FirstPoint::free);
  }
  TEST_CASE("where it does not, the error is reported, and more points make it smaller") {
    const VoxelModel spline = noisy_model(9, 10, FirstPoint::free, BasisKind::bspline, 0, false);
    double last = 1e9;
    for (const int points : {3, 6, 12, 20}) {
      const MotionDifference d = motion_difference(spline, in_basis(spline, BasisKind::bezier, points));
      CHECK(d.rms < d.max);
      CHECK(d.rms < last);
      last = d.rms;
    }
    CHECK(last > 0);
  }
  TEST_CASE("light alone is converted and retimed too") {
    VoxelModel model = noisy_model(3, 6, FirstPoint::free, BasisKind::bspline, 0, false, true);
    model.motion.displaces = false;
    Channels light = make_channels(model.motion.levels[0].topology, model.motion.width(),
                                   std::vector<float>(std::size_t(model.motion.width()), 0.0f).data());
    for (std::size_t r = kBrickRows; r < light.topology->rows(); ++r)
      for (int k = 0; k < 6; ++k) light.row(r)[k] = 0.1f * float(r % 17) - float(k);
    model.motion.levels[0] = light;
    const VoxelModel to = in_basis(model, BasisKind::hermite, 8);
    for (const double t : {0.0, 0.3, 1.0}) CHECK(difference(to, t, model, t) < 2e-6);
    CHECK(motion_difference(model, to).light < 2e-6);
    for (std::size_t r = kBrickRows; r < light.topology->rows(); ++r) model.motion.levels[0].row(r)[2] += 2;
    const MotionDifference bent = motion_difference(model, in_basis(model, BasisKind::bezier, 2));
    CHECK(bent.light > 1e-2);
    CHECK(bent.max == 0);
    CHECK(bent.opacity == 0);
  }
  TEST_CASE("the anchored first moment is canonical, and every moment looks as before") {
    test::BlobMotion way;
    way.shift = {-0.3f, 0.1f, 0.1f};
    way.twist = 0.2f;
    VoxelModel model = blob_model(48, way);
    model.motion = converted(model.motion, BasisKind::bspline, 6);
    retime(model.motion, simplified({{0, 0.4}, {0.5, 1}, {1, 0}}));  // begins in the middle of the motion
    VoxelModel edited = model;
    const MotionDifference d = anchor_first(edited);
    CHECK(d.rms < 0.05);
    CHECK(d.max < 0.5);
    const FrameSampler start(edited, 0);
    const std::vector<Vec3> places{{0.1f, 0, 0}, {0.3f, -0.2f, 0.1f}, {-0.1f, 0.1f, 0.2f}, {0.35f, 0.05f, 0}};
    for (const Vec3 p : places) CHECK(length(start.warp(p).displacement) < 1e-6f);
    for (const double t : {0.0, 0.3, 0.7, 1.0}) {
      const FrameSampler a(model, t), b(edited, t);
      for (const Vec3 p : places)
        CHECK(std::abs(a.radiance(a.canonical(p)).density - b.radiance(b.canonical(p)).density) <
              12);  // of 240
    }
    VoxelModel pinned =
        blob_model(32, way);  // t = 0 is canonical already: nothing to do but rounding and fitting
    CHECK(anchor_first(pinned).max < 1e-2);
    CHECK(pinned.motion.first_point == FirstPoint::zero);
  }
}
