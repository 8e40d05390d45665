// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "render/scatter.hpp"
#include "render/track_sight.hpp"
#include "support/dual.hpp"
#include "tiny_scene.hpp"

/// The loss of tracked points: where rays see them, and how far two such places are apart.
namespace {

using namespace splinevox;
using test::Duals;
using test::kStep;
using test::TinyScene;

/// The loss by the textbook, of all rays as sightings of one point, on any scalar. Shares of samples in their
/// pixels are constants by definition: those of `kernels`.
template <class T, int Sh>
T reference_loss(const TinyScene<Sh>& scene, const std::vector<RayKernel<double, Sh>>& kernels,
                 const std::vector<T>& slice, double scale) {
  std::vector<Sighting<T>> seen;
  for (std::size_t r = 0; r < kernels.size(); ++r) {
    Vec3T<T> sum{T(0), T(0), T(0)};
    double all = 0;
    for (int i = 0; i < kernels[r].count; ++i) {
      const Vec3d at = scene.rays[r].origin + (kernels[r].distance[i] * kStep) * scene.rays[r].direction;
      const auto& warp = kernels[r].samples[i].warp;
      T row[4] = {T(0), T(0), T(0), T(0)}, w[kCorners];
      trilinear_weights(Vec3T<T>{T(warp.fraction.x), T(warp.fraction.y), T(warp.fraction.z)}, w);
      const CellRows rows = scene.field.motion.rows(warp.cell);
      for (int c = 0; c < kCorners; ++c)
        for (int k = 0; k < 4; ++k) row[k] += w[c] * slice[std::size_t(rows.row[c]) * kSliceWidth + k];
      const T rigidity = rigidity_of(row[3], T(scene.field.rigidity_offset)).value;
      const Vec3T<T> moved = displacement_of(row, rigidity);
      for (int a = 0; a < 3; ++a) sum[a] += T(kernels[r].weight[i]) * (T(at[a]) + moved[a]);
      all += kernels[r].weight[i];
    }
    seen.push_back({T(1 / all) * sum, T(all)});
  }
  T loss(0);
  for (std::size_t a = 0; a < seen.size(); ++a)
    for (std::size_t b = 0; b < a; ++b) loss += track_error(seen[a], seen[b], T(scale)).value;
  return loss;
}

/// The gradient of the same by the production code.
template <class Real, int Sh>
std::vector<Real> kernel_gradient(const TinyScene<Sh>& scene, double scale,
                                  std::vector<RayKernel<Real, Sh>>& kernels) {
  const std::vector<Real> rows(scene.rows.begin(), scene.rows.end()),
      slice(scene.slice.begin(), scene.slice.end());
  const FieldView<Real> field = scene.field_in(rows);
  FrameView<Real> frame;
  frame.slice = slice.data();
  kernels.resize(scene.rays.size());
  std::vector<RayInput<Real>> rays;
  std::vector<Sighting<Real>> seen;
  for (std::size_t r = 0; r < kernels.size(); ++r) {
    rays.push_back(
        {cast<Real>(scene.rays[r].origin), cast<Real>(scene.rays[r].direction), scene.rays[r].count, {}, {}});
    kernels[r].forward(rays[r], field, frame, Real(0));
    seen.push_back(sighting_of(kernels[r], rays[r], field.step));
  }
  RayRecords<Real, TinyScene<Sh>::kWidth, false> records;
  for (std::size_t a = 0; a < seen.size(); ++a) {
    Vec3T<Real> slope{};
    for (std::size_t b = 0; b < seen.size(); ++b)
      if (a != b) slope += track_error(seen[a], seen[b], Real(scale)).slope;
    sighting_vjp(kernels[a], seen[a], slope, Real(0), records);
  }
  CHECK(records.radiance.empty());
  std::vector<Real> out(slice.size(), Real(0));
  Scatter<Real, kSliceWidth, false> scatter;
  scatter.begin(1, scene.motion->brick_count() + 1);
  scatter.count(0, records.motion, field.motion, 0);
  scatter.scan();
  scatter.fill(0, field.motion);
  for (int b = 1; b <= scene.motion->brick_count(); ++b) {
    RowMask mask;
    scatter.reduce(b, out.data() + std::size_t(b) * kBrickRows * kSliceWidth, mask);
  }
  return out;
}

template <int Sh>
void check_gradient(unsigned seed) {
  const TinyScene<Sh> scene(seed);
  constexpr double kScale = 0.1;
  std::vector<RayKernel<double, Sh>> kernels;
  std::vector<RayKernel<float, Sh>> in_float;
  const std::vector<double> gradient = kernel_gradient<double, Sh>(scene, kScale, kernels);
  const std::vector<float> rounded = kernel_gradient<float, Sh>(scene, kScale, in_float);
  double largest = 0, worst = 0, worst_float = 0;
  for (const double g : gradient) largest = std::max(largest, std::abs(g));
  REQUIRE(largest > 0);
  std::vector<Duals> slice(scene.slice.begin(), scene.slice.end());
  const std::size_t first = std::size_t(kBrickRows) * kSliceWidth;
  std::vector<std::size_t> chosen;
  for (std::size_t i = first; i < gradient.size(); ++i)
    if (gradient[i] != 0 || i % 40 == seed % 40) chosen.push_back(i);
  for (std::size_t at = 0; at < chosen.size(); at += Duals::kSlopes) {
    const std::size_t n = std::min<std::size_t>(Duals::kSlopes, chosen.size() - at);
    for (std::size_t k = 0; k < n; ++k) slice[chosen[at + k]].b[k] = 1;
    const Duals exact = reference_loss<Duals, Sh>(scene, kernels, slice, kScale);
    for (std::size_t k = 0; k < n; ++k) {
      const std::size_t i = chosen[at + k];
      slice[i].b[k] = 0;
      worst = std::max(worst,
                       std::abs(gradient[i] - exact.b[k]) / std::max(std::abs(exact.b[k]), 1e-6 * largest));
      worst_float = std::max(worst_float, std::abs(double(rounded[i]) - gradient[i]) / largest);
    }
  }
  CHECK(worst <= 1e-10);
  CHECK(worst_float <= 1e-5);
}

TEST_SUITE("render/track") {
  TEST_CASE(
      "how far two sightings of a point are apart has the gradient of its value, by motion and rigidity") {
    for (unsigned seed = 1; seed <= 6; ++seed) {
      CAPTURE(seed);
      seed % 2 ? check_gradient<-1>(seed) : check_gradient<2>(seed);
    }
  }

  TEST_CASE("a ray that shows nothing, and one that sees itself, ask nothing") {
    const Sighting<float> none{}, far{{1e6f, 0, 0}, 1}, faint{{0, 0, 0}, 1e-30f};
    for (const auto& [a, b] : {std::pair{none, far}, {far, far}, {faint, faint}, {none, none}}) {
      const TrackError<float> e = track_error(a, b, 0.1f);
      CHECK(e.value == 0);
      CHECK(e.slope == Vec3{});
    }
    const TrackError<float> e = track_error(faint, far, 0.1f);
    CHECK(std::isfinite(e.value));
    CHECK(std::abs(e.slope.x) <= 1e-28f);
  }

  TEST_CASE(
      "the pull of a track has a bound: one that is wrong pulls no more than one that is nearly right") {
    const Sighting<double> here{{0, 0, 0}, 1};
    const auto pull = [&](double away) {
      return length(track_error(here, Sighting<double>{{away, 0, 0}, 1}, 1.0).slope);
    };
    CHECK(pull(kTrackWidth / 10) < 0.2 * pull(10 * kTrackWidth));
    CHECK(pull(10) < 1.01 * pull(10 * kTrackWidth));
    CHECK(pull(10) <= 1.000001 / kTrackWidth);
  }
}

}  // namespace
