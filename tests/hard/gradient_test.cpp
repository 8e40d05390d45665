// SPDX-License-Identifier: Apache-2.0
// From the loss to every stored number of a model: the float engine against the double kernel, which
// tests/render/gradient_test.cpp checks against dual numbers, with the splines' weights in double.
#include <doctest/doctest.h>

#include <vector>

#include "backend/host/engine.hpp"
#include "core/rng.hpp"
#include "hard/measured.hpp"
#include "hard/scenes.hpp"
#include "math/bernstein.hpp"
#include "math/bspline.hpp"
#include "math/photometric.hpp"
#include "render/backward.hpp"
#include "render/field_view.hpp"
#include "render/scatter.hpp"
#include "support/blob_model.hpp"
#include "train/batch.hpp"

using namespace splinevox;
using namespace splinevox::test;

namespace {

/// Where lane a of a control point stands in a slice: place, light, presence.
constexpr int in_slice(int lane) { return lane < 3 ? lane : lane + 1; }

/// Gradients of radiance rows and of control points, rigidity, light and presence, all in double.
struct Exact {
  std::vector<double> radiance, motion;
  double value = 0;
};

template <int Sh>
Exact exact_gradients(const VoxelModel& model, const Batch& batch, const std::vector<double>& times,
                      const MotionLoss<double>& loss, double stop, std::uint64_t seed) {
  constexpr int kWidth = radiance_width(Sh);
  const Channels& level = model.motion.levels[0];
  const MotionField& m = model.motion;
  Exact out;
  const std::vector<double> rows(model.radiance.raw.values.begin(), model.radiance.raw.values.end());
  const FieldView<double> field = view_field(model, rows.data(), double(model.step));
  out.radiance.assign(rows.size(), 0.0);
  out.motion.assign(level.values.size(), 0.0);
  for (std::size_t f = 0; f < times.size(); ++f) {
    const auto all = m.basis == BasisKind::bezier ? bernstein_weights(m.points, times[f])
                                                  : bspline_weights(m.points, times[f]);
    const int pinned = m.points - m.stored_points();
    const auto weight = [&](int k,
                            int lane) {  // presence is less its mean: a cubic piece has 1, 11, 11, 1 / 24
      constexpr double kMean[4] = {1 / 24.0, 11 / 24.0, 11 / 24.0, 1 / 24.0};
      return all[k + pinned] - (lane == 4 ? kMean[k] : 0);
    };
    std::vector<double> slice(level.topology->rows() * kSliceWidth, 0.0);
    for (std::size_t r = 0; r < level.topology->rows(); ++r) {
      for (int k = 0; k < m.stored_points(); ++k)
        for (int a = 0; a < m.stride(); ++a)
          slice[r * kSliceWidth + in_slice(a)] += weight(k, a) * level.row(r)[m.stride() * k + a];
      if (m.rigidity) slice[r * kSliceWidth + 3] = level.row(r)[m.rigidity_column()];
    }
    FrameView<double> frame;
    frame.slice = slice.data();
    RayKernel<double, Sh> kernel;
    RayRecords<double, kWidth, true> records;
    for (const RayTask& task : batch.tasks) {
      if (task.slot != int(f)) continue;
      for (int i = task.first; i < task.last; ++i) {
        const RayInput<float>& in = batch.rays[i];
        const RayInput<double> ray{
            cast<double>(in.origin), cast<double>(in.direction), in.count, cast<double>(in.background), {}};
        const auto result = kernel.forward(ray, field, frame, stop);
        const Vec3d error = photometric_error(result.rgb, cast<double>(batch.targets[i]));
        out.value += dot(error, error);
        const std::size_t first = records.motion.size();
        backward(kernel, ray, result, field, 2.0 * error, 0.0, records);
        const std::uint64_t bits = Rng(seed, 5).bits(std::uint64_t(i));
        out.value += motion_losses(kernel, field, frame, loss,
                                   Vec3d{bits & 1 ? 1. : -1., bits & 2 ? 1. : -1., bits & 4 ? 1. : -1.}, 0.0,
                                   first, records);
      }
    }
    const auto gather = [](auto& scatter, const auto& list, const BrickView<double>& view, const Topology& t,
                           int width, std::vector<double>& to) {
      scatter.begin(1, t.brick_count() + 1);
      scatter.count(0, list, view, 0);
      scatter.scan();
      scatter.fill(0, view);
      RowMask mask;
      for (int b = 1; b <= t.brick_count(); ++b)
        scatter.reduce(b, to.data() + std::size_t(b) * kBrickRows * width, mask);
    };
    std::vector<double> d_slice(slice.size(), 0.0);
    Scatter<double, kWidth, false> radiance;
    Scatter<double, kSliceWidth, true> motion;
    gather(radiance, records.radiance, field.radiance, *model.radiance.raw.topology, kWidth, out.radiance);
    gather(motion, records.motion, field.motion, *level.topology, kSliceWidth, d_slice);
    for (std::size_t r = kBrickRows; r < level.topology->rows(); ++r) {
      double* to = out.motion.data() + r * level.width;
      for (int k = 0; k < m.stored_points(); ++k)
        for (int a = 0; a < m.stride(); ++a)
          to[m.stride() * k + a] += weight(k, a) * d_slice[r * kSliceWidth + in_slice(a)];
      if (m.rigidity) to[m.rigidity_column()] += d_slice[r * kSliceWidth + 3];
    }
  }
  return out;
}

/// Gives a model with light a presence of noise beside what it has.
void add_presence(VoxelModel& model) {
  MotionField& m = model.motion;
  const Channels old = m.levels[0];
  const int stride = m.stride(), rigidity = m.rigidity_column();
  m.presence = true;
  const std::vector<float> zero(std::size_t(m.width()), 0.0f);
  m.levels[0] = make_channels(old.topology, m.width(), zero.data());
  for (std::size_t r = kBrickRows; r < old.topology->rows(); ++r) {
    float* row = m.levels[0].row(r);
    for (int k = 0; k < m.points; ++k) {
      std::copy_n(old.row(r) + stride * k, stride, row + m.stride() * k);
      row[m.stride() * k + 4] = float(Rng(5, r).bits(std::size_t(k)) % 1000) / 500 - 1;
    }
    row[m.rigidity_column()] = old.row(r)[rigidity];
  }
}

}  // namespace

TEST_SUITE("hard/gradients") {
  TEST_CASE(
      "every control point, rigidity, light, presence, density, colour and harmonic in float: within 1e-5, "
      "no "
      "wrong sign") {
    Worst radiance, motion, slope;
    std::size_t wrong = 0, count = 0;
    for (const int made : {0, 1, 2}) {
      const bool spline = made > 0;
      VoxelModel model = blob_model(20, {true, 5, {-0.3f, 0.1f, 0.2f}, 0.2f, true, 0.5f}, 1, 10);
      if (spline) {
        // The same rows read as a B-spline of four points: every number is stored.
        model.motion.basis = BasisKind::bspline;
        model.motion.points = 4;
        model.motion.first_point = FirstPoint::free;
      }
      if (made == 2) add_presence(model);
      const Split& train = *ball().find("train");
      SamplingConfig sampling;
      sampling.frames = 4;
      sampling.rays = 512;
      sampling.growth = 1;
      sampling.carve = 0;
      const BatchSampler sampler(train, model.box, sampling, 3);
      Batch batch;
      sampler.draw(1, 1, model.step, {}, {}, batch);
      const std::vector<double>& times = batch.times;
      BitGrid all(model.box, 16);
      std::fill(all.bits.begin(), all.bits.end(), ~0u);
      const ActiveRows active{
          std::vector<RowMask>(model.motion.levels[0].topology->bricks.size(), RowMask::all()), {}};
      const MotionLoss<double> loss{.offset = 0.02,
                                    .offset_rigidity = 0.3,
                                    .offset_softening = 1e-3,
                                    .divergence = 0.01,
                                    .hutchinson = spline};
      const RayLosses asked{.motion = {0.02f, 0.3f, 1e-3f, 0.01f, spline}, .probe_seed = 77};
      Gradient d_radiance(model.radiance.raw), d_motion(model.motion.levels[0]);
      std::vector<Vec3> behind(batch.rays.size());
      StepModel now{};
      now.model = &model;
      now.radiance.values = &model.radiance.raw;
      now.active = &active;
      now.occupancy = {&all, 1};
      StepInput in{};
      const std::vector<int> grids(times.size(), 0);
      in.rays = batch.rays;
      in.targets = batch.targets;
      in.times = times;
      in.occupancy = grids;
      in.losses = asked;
      std::vector<double> slopes(times.size());
      const PassResult pass = make_engine(1, true, true)
                                  ->run(now, &model.motion.levels[0], in, {batch.tasks, {}}, d_radiance,
                                        &d_motion, {.behind = behind, .slopes = slopes});
      const Exact exact = exact_gradients<1>(model, batch, times, loss, 0, 77);
      CHECK(pass.squared_error + pass.motion_loss == doctest::Approx(exact.value).epsilon(1e-5));
      // The loss is quadratic in the colour behind a ray, so a central difference of any width is exact.
      for (std::size_t i = 0; i < batch.rays.size(); i += batch.rays.size() / 3) {
        const auto value = [&](float by) {
          Batch moved = batch;
          moved.rays[i].background.y += by;
          return exact_gradients<1>(model, moved, times, loss, 0, 77).value;
        };
        const float y = batch.rays[i].background.y, up = (y + 0.25f) - y, down = (y - 0.25f) - y;
        CHECK(behind[i].y ==
              doctest::Approx((value(up) - value(down)) / double(up - down)).epsilon(1e-5).scale(0.1));
      }
      // Of each slot's time, of the photometric error alone: the losses of motion take visibility as given,
      // and a difference of their values does not.
      Gradient d_rest(model.radiance.raw), d_rest_motion(model.motion.levels[0]);
      in.losses.motion = {};
      make_engine(1, true, true)
          ->run(now, &model.motion.levels[0], in, {batch.tasks, {}}, d_rest, &d_rest_motion,
                {.behind = behind, .slopes = slopes});
      double steepest = 0;
      std::vector<double> slope_wanted(times.size());
      for (std::size_t f = 0; f < times.size(); ++f) {
        constexpr double kHalf = 1e-5;
        const auto value = [&](double by) {
          std::vector<double> moved = times;
          moved[f] += by;
          return exact_gradients<1>(model, batch, moved, {}, 0, 77).value;
        };
        slope_wanted[f] = (value(kHalf) - value(-kHalf)) / (2 * kHalf);
        steepest = std::max(steepest, std::abs(slope_wanted[f]));
      }
      REQUIRE(steepest > 0);
      for (std::size_t f = 0; f < times.size(); ++f)
        slope.see(std::abs(slopes[f] - slope_wanted[f]) / steepest);
      const auto compare = [&](const Channels& got, const std::vector<double>& want, Worst& worst) {
        double largest = 0;
        for (const double g : want) largest = std::max(largest, std::abs(g));
        REQUIRE(largest > 0);
        for (std::size_t i = std::size_t(kBrickRows) * got.width; i < want.size(); ++i) {
          worst.see(std::abs(double(got.values[i]) - want[i]) / largest);
          count += want[i] != 0;
          wrong += std::abs(want[i]) > 1e-5 * largest && (got.values[i] > 0) != (want[i] > 0);
        }
      };
      compare(d_radiance.values, exact.radiance, radiance);
      compare(d_motion.values, exact.motion, motion);
    }
    CHECK(count > 10000);
    CHECK(wrong == 0);
    measured("gradient of radiance in float, of the largest", radiance.value, 2e-5, "");
    measured("gradient of the times of slots in float, of the largest", slope.value, 1e-4, "");
    measured("gradient of control points, rigidity, light and presence in float, of the largest",
             motion.value, 2e-5, "");
  }
}
