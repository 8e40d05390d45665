// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>

#include "core/team.hpp"
#include "render/field_view.hpp"
#include "render/ray_kernel.hpp"
#include "render/shade.hpp"
#include "support/blob_model.hpp"

using namespace splinevox;

namespace {

struct Worst {
  double relative = 0;
  void see(float a, float b, float scale) {
    relative = std::max(relative, double(std::abs(a - b)) / std::max(double(scale), 1e-30));
  }
};

/// Every sample of rays through a model, by the CPU's kernel for many and by the one for lanes. Returns the
/// largest difference in units of rounding of a coordinate: a place is found in numbers of up to that many
/// vertices, whatever is read there.
template <int Sh, bool Moving>
double compare(const VoxelModel& model, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const MotionSlice slice = make_slice(model.motion, stored_weights(model.motion, 0.6));
  const FieldView<float> field = view_field(model, model.step);
  const FrameView<float> frame{slice.values.data(), {}};
  RayKernel<float, Sh, float, Moving> kernel;
  Worst worst;
  int seen = 0;
  for (int i = 0; i < 200; ++i) {
    const Ray ray{{2.5, uniform(random), uniform(random)},
                  normalize(Vec3d{-1, 0.3 * uniform(random), 0.3 * uniform(random)})};
    const RayInput<float> input = clip_ray(ray, model.box, model.step, 0.5f, model.background.color);
    kernel.forward(input, field, frame, 0.0f);
    const RowHarmonics<Sh> harmonics(input.direction);
    for (int k = 0; k < kernel.count; ++k, ++seen) {
      const Shaded<Sh, Moving> s =
          shade_sample<Sh, Moving>(input, int(kernel.distance[k]), field, frame, harmonics);
      REQUIRE(s.stored);
      CHECK(s.at.cell.slot == kernel.samples[k].radiance_cell.slot);
      CHECK(s.at.cell.local == kernel.samples[k].radiance_cell.local);
      const float before = k == 0 ? 1.0f : kernel.transmittance_next[k - 1];
      worst.see(before * s.alpha, kernel.weight[k], 1);
      worst.see(s.emission.sigma_slope, kernel.sigma_slope[k], field.density_scale);
      for (int c = 0; c < 3; ++c) {
        worst.see(s.emission.base[c], kernel.base[c][k], 1);
        worst.see(s.emission.base_slope[c], kernel.base_slope[c][k], 1);
      }
      if constexpr (Sh >= 0) {
        worst.see(s.emission.view, kernel.view[k], 1);
        worst.see(s.emission.view_slope, kernel.view_slope[k], 1);
      }
      if constexpr (Moving) {
        worst.see(s.emission.light, kernel.light[k], 1);
        worst.see(s.r, kernel.r[k], 1);
        for (int c = 0; c < 4; ++c) worst.see(s.motion[c], kernel.samples[k].warp.motion[c], 1);
      }
    }
  }
  CHECK(seen > 1000);
  const float vertices = std::max({field.radiance.limit.x, field.radiance.limit.y, field.radiance.limit.z});
  return worst.relative / (double(vertices) * 0x1p-24);
}

}  // namespace

TEST_SUITE("backend/kernels") {
  TEST_CASE("a sample shaded alone is the sample shaded among others, to 4 units of rounding") {
    // Gentle slopes: raw values that change by tens within a cell turn one unit of a fraction into more than
    // that.
    const auto gentle = [](int sh, bool moves) {
      VoxelModel m = test::noisy_model(11, 4, FirstPoint::zero, BasisKind::bezier, sh, true, true);
      if (!moves) m.motion.levels.clear();
      for (std::size_t i = std::size_t(kBrickRows) * m.radiance.raw.width; i < m.radiance.raw.values.size();
           ++i)
        m.radiance.raw.values[i] *= 0.25f;
      m.radiance.activation = {1 / m.step, -2};
      return m;
    };
    const double worst[] = {compare<-1, false>(gentle(-1, false), 1), compare<-1, true>(gentle(-1, true), 2),
                            compare<0, true>(gentle(0, true), 3),     compare<1, false>(gentle(1, false), 4),
                            compare<1, true>(gentle(1, true), 5),     compare<2, true>(gentle(2, true), 6),
                            compare<3, true>(gentle(3, true), 7),     compare<3, false>(gentle(3, false), 8)};
    for (const double w : worst) CHECK(w <= 4);
    std::printf("samples differ by %.2f units of rounding at most\n",
                *std::max_element(std::begin(worst), std::end(worst)));
  }
  TEST_CASE("a team's scans are those of a plain loop") {
    std::mt19937 random(3);
    std::uniform_real_distribution<float> uniform(0.5f, 1.0f);
    const HostTeam team(nullptr);
    HostTeam::Lanes<float> x, product, sum;
    for (int l = 0; l < kLanes; ++l) x[l] = product[l] = sum[l] = uniform(random);
    const float all_product = team.product_before(product), all_sum = team.sum_after(sum);
    double p = 1, s = 0;
    for (int l = 0; l < kLanes; ++l) {
      CHECK(product[l] == doctest::Approx(p).epsilon(1e-6));
      p *= x[l];
    }
    for (int l = kLanes - 1; l >= 0; --l) {
      CHECK(sum[l] == doctest::Approx(s).epsilon(1e-6));
      s += x[l];
    }
    CHECK(all_product == doctest::Approx(p).epsilon(1e-6));
    CHECK(all_sum == doctest::Approx(s).epsilon(1e-6));
    CHECK(team.sum(x) == doctest::Approx(s).epsilon(1e-6));
    CHECK(team.at(x, 17) == x[17]);
  }
}
