// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <cmath>
#include <cstdio>
#include <vector>

#include "math/activation.hpp"
#include "math/divergence.hpp"
#include "math/light.hpp"
#include "math/offset.hpp"
#include "math/photometric.hpp"
#include "math/sh.hpp"
#include "math/view_factor.hpp"
#include "render/backward.hpp"
#include "render/scatter.hpp"
#include "support/dual.hpp"
#include "tiny_scene.hpp"

using namespace splinevox;
using test::Duals;
using test::kStep;
using test::TinyScene;

namespace {

/// Eight corner rows around x by plain arithmetic, row 0 where a brick is absent.
struct Corners {
  std::size_t row[8];
  bool stored = false;
};
Corners corners_of(const Topology& t, const Int3& base) {
  Corners out;
  for (int c = 0; c < 8; ++c) {
    const Int3 v{base.x + (c >> 2), base.y + (c >> 1 & 1), base.z + (c & 1)};
    const Int3 brick{v.x >> 3, v.y >> 3, v.z >> 3};
    bool inside = true;
    for (int a = 0; a < 3; ++a) inside = inside && brick[a] >= -1 && brick[a] <= t.dims[a] - 2;
    const int b = inside ? t.brick_at(brick) : 0;
    out.row[c] = std::size_t(b) * kBrickRows + ((v.x & 7) << 6 | (v.y & 7) << 3 | (v.z & 7));
    out.stored |= b != 0;
  }
  return out;
}

/// The loss of Eq. 8 by the textbook, on any scalar: no packets, no records, sums in the order of the
/// equations. Motion losses take their visibility weights from `fixed_weights`, because those are constants
/// by definition; empty: fills it in.
template <class T, int Sh>
T reference_loss(const TinyScene<Sh>& scene, const std::vector<T>& rows, const std::vector<T>& slice,
                 const std::vector<T>& behind, const MotionLoss<double>& loss,
                 std::vector<double>& fixed_weights, double stop) {
  constexpr int kWidth = TinyScene<Sh>::kWidth;
  const bool record = fixed_weights.empty();
  std::size_t used = 0;
  T total(0);
  const auto value_of = [](const T& x) {
    if constexpr (std::is_same_v<T, Duals>)
      return x.a;
    else
      return x;
  };
  for (std::size_t ray = 0; ray < scene.rays.size(); ++ray) {
    const RayInput<double>& in = scene.rays[ray];
    T transmittance(1), distance(0);
    Vec3T<T> color{T(0), T(0), T(0)};
    for (int i = 0; i < in.count; ++i) {
      const Vec3d at = in.origin + (i * kStep) * in.direction;
      // Motion: value, spatial derivatives, rigidity.
      Vec3T<T> u;
      Int3 base;
      T w[8];
      Vec3T<T> dw[8];
      for (int a = 0; a < 3; ++a) {
        const double g =
            (at[a] - double(scene.motion->lattice.origin[a])) / double(scene.motion->lattice.spacing);
        base[a] = int(std::floor(g));
        u[a] = T(g - base[a]);
      }
      trilinear_weights(u, w);
      trilinear_weight_gradients(u, dw);
      const Corners mc = corners_of(*scene.motion, base);
      MotionJet<T> jet{};
      T rho(0), light(0), presence(0);
      const T inv(1 / double(scene.motion->lattice.spacing));
      for (int c = 0; c < 8; ++c) {
        const T* row = slice.data() + mc.row[c] * kSliceWidth;
        const Vec3T<T> d{row[0], row[1], row[2]};
        jet.delta += w[c] * d;
        rho += w[c] * row[3];
        light += w[c] * row[4];
        presence += w[c] * row[5];
        for (int j = 0; j < 3; ++j) {
          jet.d_delta[j] += (inv * dw[c][j]) * d;
          jet.d_rho[j] += inv * dw[c][j] * row[3];
        }
      }
      const auto r = sigmoid(rho + T(0.4));
      jet.r = r.value;
      jet.r1 = r.slope;
      jet.r2 = r.slope * (T(1) - T(2) * r.value);
      // Radiance at x + r Delta_0.
      for (int a = 0; a < 3; ++a) {
        const T g = (T(at[a] - double(scene.radiance->lattice.origin[a])) + jet.r * jet.delta[a]) /
                    T(double(scene.radiance->lattice.spacing));
        base[a] = int(std::floor(value_of(g)));
        u[a] = g - T(base[a]);
      }
      trilinear_weights(u, w);
      const Corners rc = corners_of(*scene.radiance, base);
      if (!rc.stored) continue;
      T raw[4 + kMaxShCount] = {};
      for (int c = 0; c < 8; ++c)
        for (int k = 0; k < 4 + (Sh + 1) * (Sh + 1); ++k) raw[k] += w[c] * rows[rc.row[c] * kWidth + k];
      T factor = light_gain(light).value;
      if constexpr (Sh >= 0) {
        double y[kMaxShCount];
        sh_basis(Sh, in.direction, y);
        T q(0);
        for (int k = 0; k < (Sh + 1) * (Sh + 1); ++k) q += raw[4 + k] * T(y[k]);
        factor = factor * view_factor(q).value;
      }
      const T depth = T(3) * softplus(raw[0] + presence - T(0.5)).value * T(kStep);
      const T weight = transmittance * one_minus_exp_neg(depth);
      for (int c = 0; c < 3; ++c) color[c] += weight * factor * sigmoid(raw[1 + c]).value;
      distance += weight * T(i * kStep);
      transmittance *= exp_(-depth);
      if (loss.offset > 0 || loss.divergence > 0 || scene.rest > 0) {
        if (record) fixed_weights.push_back(value_of(weight));
        const T fixed(fixed_weights[used++]);
        MotionJetAdjoint<T> unused;
        const Vec3T<T> probe{T(scene.probes[ray].x), T(scene.probes[ray].y), T(scene.probes[ray].z)};
        const T q = loss.hutchinson ? divergence_probe(jet, probe, unused) : divergence(jet, unused);
        total += T(loss.divergence) * fixed * q * q;
        const Vec3T<T> displacement = jet.r * jet.delta;
        total += T(scene.rest) * fixed * dot(displacement, displacement);
        if (loss.offset > 0)
          total += T(loss.offset) * fixed *
                   offset_term(jet.delta, jet.r, T(loss.offset_rigidity), T(loss.offset_softening)).value;
      }
      if (value_of(transmittance) < stop) break;
    }
    total += transmittance_prior(transmittance, T(scene.prior)).value;
    const DepthTarget<double>& known = scene.depths[ray];
    if (scene.depth_weight > 0 && known.scale > 0)
      total += T(scene.depth_weight) * depth_error(distance + transmittance * T(in.count * kStep),
                                                   DepthTarget<T>{T(known.distance), T(known.scale)})
                                           .value;
    for (int c = 0; c < 3; ++c) {
      const T e = color[c] + transmittance * behind[3 * ray + c] - T(std::abs(scene.targets[ray][c]));
      const bool clipped = scene.targets[ray][c] < 0 && value_of(e) > 0;
      if (!clipped) total += e * e;
    }
  }
  return total;
}

/// Gradients through the production kernel, records and scatter, in the scalar of production or of the
/// oracle.
template <class Real, int Sh>
void kernel_gradients(const TinyScene<Sh>& scene, const MotionLoss<double>& loss, double stop,
                      std::vector<Real>& d_rows, std::vector<Real>& d_slice, std::vector<Real>& d_behind,
                      double& value) {
  constexpr int kWidth = TinyScene<Sh>::kWidth;
  const std::vector<Real> rows(scene.rows.begin(), scene.rows.end()),
      slice(scene.slice.begin(), scene.slice.end());
  const FieldView<Real> field = scene.field_in(rows);
  FrameView<Real> frame;
  frame.slice = slice.data();
  const MotionLoss<Real> losses{Real(loss.offset), Real(loss.offset_rigidity), Real(loss.offset_softening),
                                Real(loss.divergence), loss.hutchinson};
  RayKernel<Real, Sh> kernel;
  RayRecords<Real, kWidth, true> records;
  value = 0;
  for (std::size_t i = 0; i < scene.rays.size(); ++i) {
    RayInput<Real> ray;
    ray.origin = cast<Real>(scene.rays[i].origin);
    ray.direction = cast<Real>(scene.rays[i].direction);
    ray.count = scene.rays[i].count;
    ray.background = cast<Real>(scene.rays[i].background);
    ray.rest = Real(scene.rest);
    const auto result = kernel.forward(ray, field, frame, Real(stop));
    const Vec3T<Real> error = photometric_error(result.rgb, cast<Real>(scene.targets[i]));
    value += dot(error, error) + transmittance_prior(result.transmittance, Real(scene.prior)).value;
    const std::size_t first = records.motion.size();
    for (int c = 0; c < 3; ++c) d_behind.push_back(Real(2) * result.transmittance * error[c]);
    if (scene.depth_weight > 0 && scene.depths[i].scale > 0) {
      const auto off =
          depth_error(expected_distance(kernel, ray, result, field.step),
                      DepthTarget<Real>{Real(scene.depths[i].distance), Real(scene.depths[i].scale)});
      value += scene.depth_weight * double(off.value);
      backward<true>(kernel, ray, result, field, Real(2) * error, Real(0), records, Real(scene.prior),
                     Real(scene.depth_weight) * off.slope);
    } else {
      backward(kernel, ray, result, field, Real(2) * error, Real(0), records, Real(scene.prior));
    }
    for (int k = 0; k < kernel.count; ++k) {
      const Vec3T<Real> displacement = displacement_of(kernel.samples[k].warp.motion, kernel.r[k]);
      value += scene.rest * double(kernel.weight[k]) * double(dot(displacement, displacement));
    }
    value +=
        motion_losses(kernel, field, frame, losses, cast<Real>(scene.probes[i]), Real(0), first, records);
  }
  const auto gather = [](auto& scatter, const auto& list, const BrickView<Real>& view, const Topology& t,
                         int width, std::vector<Real>& out) {
    out.assign(t.rows() * width, Real(0));
    scatter.begin(1, t.brick_count() + 1);
    scatter.count(0, list, view, 0);
    scatter.scan();
    scatter.fill(0, view);
    for (int b = 1; b <= t.brick_count(); ++b) {
      RowMask mask;
      scatter.reduce(b, out.data() + std::size_t(b) * kBrickRows * width, mask);
      for (int i = 0; i < kBrickRows; ++i) {
        bool any = false;
        for (int c = 0; c < width; ++c) any |= out[(std::size_t(b) * kBrickRows + i) * width + c] != 0;
        if (any) REQUIRE(mask.test(i));
      }
    }
  };
  Scatter<Real, kWidth, false> radiance;
  Scatter<Real, kSliceWidth, true> motion;
  gather(radiance, records.radiance, field.radiance, *scene.radiance, kWidth, d_rows);
  gather(motion, records.motion, field.motion, *scene.motion, kSliceWidth, d_slice);
}
/// The largest errors over everything checked, printed for docs/numerics.md.
struct Figures {
  double relative = 0;  ///< double against dual numbers, elementwise
  double floats = 0;    ///< float against double, of the largest gradient
  std::size_t parameters = 0, wrong_signs = 0;
};

/// Every parameter that has a gradient, and every 40th of the others, against dual numbers; then the float
/// kernel against the double one. Below a millionth of the largest gradient, or where rays cancel, an error
/// is measured against that millionth.
template <int Sh>
void check_gradients(unsigned seed, const MotionLoss<double>& loss, double stop, Figures& figures,
                     double rest = 0, double depth = 0) {
  TinyScene<Sh> scene(seed);
  scene.rest = rest;
  scene.depth_weight = depth;
  scene.prior = depth / 100;
  std::vector<double> d_rows, d_slice, d_behind, weights;
  std::vector<float> f_rows, f_slice, f_behind;
  double value, f_value;
  kernel_gradients<double>(scene, loss, stop, d_rows, d_slice, d_behind, value);
  kernel_gradients<float>(scene, loss, stop, f_rows, f_slice, f_behind, f_value);
  CHECK(value == doctest::Approx(reference_loss<double, Sh>(scene, scene.rows, scene.slice, scene.behind,
                                                            loss, weights, stop))
                     .epsilon(1e-12));
  CHECK(f_value == doctest::Approx(value).epsilon(1e-5));
  std::vector<Duals> rows(scene.rows.begin(), scene.rows.end()),
      slice(scene.slice.begin(), scene.slice.end()), behind(scene.behind.begin(), scene.behind.end());
  const auto check = [&](std::vector<Duals>& parameters, const std::vector<double>& gradient,
                         const std::vector<float>& in_float, std::size_t first) {
    double largest = 0;
    for (const double g : gradient) largest = std::max(largest, std::abs(g));
    REQUIRE(largest > 0);
    std::vector<std::size_t> chosen;
    for (std::size_t i = first; i < gradient.size(); ++i)
      if (gradient[i] != 0 || i % 40 == seed % 40) chosen.push_back(i);
    for (std::size_t at = 0; at < chosen.size(); at += Duals::kSlopes) {
      const std::size_t n = std::min<std::size_t>(Duals::kSlopes, chosen.size() - at);
      for (std::size_t k = 0; k < n; ++k) parameters[chosen[at + k]].b[k] = 1;
      const Duals exact = reference_loss<Duals, Sh>(scene, rows, slice, behind, loss, weights, stop);
      for (std::size_t k = 0; k < n; ++k) {
        const std::size_t i = chosen[at + k];
        parameters[i].b[k] = 0;
        figures.relative = std::max(figures.relative, std::abs(gradient[i] - exact.b[k]) /
                                                          std::max(std::abs(exact.b[k]), 1e-6 * largest));
        figures.floats = std::max(figures.floats, std::abs(in_float[i] - gradient[i]) / largest);
        figures.wrong_signs +=
            std::abs(gradient[i]) > 1e-6 * largest && (in_float[i] > 0) != (gradient[i] > 0);
        ++figures.parameters;
      }
    }
  };
  check(rows, d_rows, f_rows, std::size_t(kBrickRows) * TinyScene<Sh>::kWidth);
  check(slice, d_slice, f_slice, std::size_t(kBrickRows) * kSliceWidth);
  check(behind, d_behind, f_behind, 0);
}

/// The same with harmonics of another order for every seed.
void check_any_order(unsigned seed, const MotionLoss<double>& loss, double stop, Figures& figures,
                     double rest = 0, double depth = 0) {
  switch (seed % 5) {
    case 0:
      return check_gradients<-1>(seed, loss, stop, figures, rest, depth);
    case 1:
      return check_gradients<0>(seed, loss, stop, figures, rest, depth);
    case 2:
      return check_gradients<1>(seed, loss, stop, figures, rest, depth);
    case 3:
      return check_gradients<2>(seed, loss, stop, figures, rest, depth);
    default:
      return check_gradients<3>(seed, loss, stop, figures, rest, depth);
  }
}

void report(const char* what, const Figures& f) {
  char text[200];
  std::snprintf(
      text, sizeof text,
      "measured gradients, %s: %zu parameters, double %.2g, float %.2g of the largest, %zu wrong signs", what,
      f.parameters, f.relative, f.floats, f.wrong_signs);
  MESSAGE(text);
  CHECK(f.relative <= 1e-10);
  CHECK(f.floats <= 1e-5);
  CHECK(f.wrong_signs == 0);
}

}  // namespace

TEST_SUITE("render/gradient") {
  TEST_CASE(
      "photometric gradients of every radiance and motion parameter and of what is behind equal dual "
      "numbers, with and without early stop") {
    Figures figures;
    for (unsigned seed = 1; seed <= 20; ++seed) {
      CAPTURE(seed);
      check_any_order(seed, {}, seed % 2 ? 0.2 : 0, figures);
    }
    report("photometric, 20 scenes", figures);
  }
  TEST_CASE(
      "what shows nothing that moves is asked to be at rest: the gradient of the squared displacement") {
    Figures figures;
    for (unsigned seed = 1; seed <= 20; ++seed) check_any_order(seed, {}, seed % 2 ? 0.2 : 0, figures, 0.5);
    report("rest, 20 scenes", figures);
  }

  TEST_CASE(
      "the error of an expected distance and the prior on transmittance have the gradients of their values") {
    Figures figures;
    for (unsigned seed = 1; seed <= 20; ++seed) check_any_order(seed, {}, seed % 2 ? 0.2 : 0, figures, 0, 40);
    report("depth and transmittance, 20 scenes", figures);
  }

  TEST_CASE("offset and divergence losses have the gradients of their values") {
    Figures offset, divergence, probe;
    for (unsigned seed = 21; seed <= 40; ++seed) {
      CAPTURE(seed);
      check_any_order(seed, {.offset = 0.7, .offset_rigidity = 0.3, .offset_softening = 1e-3}, 0, offset);
      check_any_order(seed, {.divergence = 0.4}, 0, divergence);
      check_any_order(seed, {.divergence = 0.4, .hutchinson = true}, 0, probe);
    }
    report("offset, 20 scenes", offset);
    report("divergence, 20 scenes", divergence);
    report("divergence by a probe, 20 scenes", probe);
  }
}
