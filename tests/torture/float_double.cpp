// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <random>

#include "render/backward.hpp"
#include "render/scatter.hpp"
#include "torture/trial.hpp"

namespace splinevox::torture {
namespace {

constexpr int kSh = 1, kWidth = RayKernel<double, kSh>::kWidth, kRays = 8;

/// A field of a few bricks with random rows, in numbers that a float holds exactly, and rays through it.
template <class Real>
struct MicroScene {
  TopologyPtr radiance, motion;
  AlignedVector<Real> rows, slice;
  FieldView<Real> field;
  FrameView<Real> frame;
  std::vector<RayInput<Real>> rays;

  explicit MicroScene(std::uint64_t seed) {
    std::mt19937_64 random(seed);
    const auto uniform = [&] { return Real(float(double(random() >> 11) * 0x1p-52 - 1)); };
    const auto one_of = [&](std::initializer_list<float> list) {
      return Real(list.begin()[random() % list.size()]);
    };
    const Lattice fine{{-1, -1, -1}, 0.25f, {12, 9, 9}}, coarse{{-1, -1, -1}, 0.5f, {9, 5, 5}};
    radiance = make_topology(fine, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
    motion = make_dense_topology(coarse);
    rows.resize(radiance->rows() * kWidth);
    slice.resize(motion->rows() * kSliceWidth);
    const Real spread = one_of({0.5f, 1.5f, 8.0f}), moves = one_of({0, 0.03f, 0.3f});
    for (Real& v : rows) v = Real(float(spread * uniform()));
    for (Real& v : slice) v = Real(float(moves * uniform()));
    for (int i = 0; i < kBrickRows; ++i)
      for (int c = 0; c < kWidth; ++c) rows[i * kWidth + c] = c == 0 ? -10 : 0;
    std::fill_n(slice.begin(), kBrickRows * kSliceWidth, Real(0));
    field.radiance = BrickView<Real>(*radiance);
    field.radiance_rows = rows.data();
    field.motion = BrickView<Real>(*motion);
    field.moving = field.rigidity = true;
    field.rigidity_offset = Real(0.5f);
    field.density_scale = one_of({0.1f, 3, 100});
    field.density_shift = Real(-0.5f);
    field.step = Real(0.109375f);
    frame.slice = slice.data();
    for (int i = 0; i < kRays; ++i) {
      RayInput<Real> ray;
      ray.origin = {Real(float(-1 + 0.05 * double(uniform()))), Real(float(0.4 * double(uniform()))),
                    Real(float(0.4 * double(uniform())))};
      const Vec3d d = normalize(Vec3d{1, 0.4 * double(uniform()), 0.4 * double(uniform())});
      ray.direction = {Real(float(d.x)), Real(float(d.y)), Real(float(d.z))};
      ray.count = 16;
      ray.background = {Real(0.25f), Real(0.5f), Real(0.75f)};
      rays.push_back(ray);
    }
  }
};

/// Colours of all rays, the gradient of half their squares as doubles, and the cells that the samples fell
/// into.
template <class Real>
void run(std::uint64_t seed, std::vector<double>& colours, std::vector<double>& gradient,
         std::vector<int>& cells) {
  const MicroScene<Real> scene(seed);
  RayKernel<Real, kSh> kernel;
  RayRecords<Real, kWidth, false> records;
  colours.clear();
  for (const RayInput<Real>& ray : scene.rays) {
    const RayResult<Real> result = kernel.forward(ray, scene.field, scene.frame, Real(0));
    for (int c = 0; c < 3; ++c) colours.push_back(double(result.rgb[c]));
    backward(kernel, ray, result, scene.field, result.rgb, Real(0), records);
  }
  gradient.clear();
  cells.clear();
  for (const auto& r : records.radiance) cells.insert(cells.end(), {r.cell.slot, r.cell.local});
  for (const auto& r : records.motion) cells.insert(cells.end(), {r.cell.slot, r.cell.local});
  const auto gather = [&](auto&& scatter, const auto& list, const BrickView<Real>& view, const Topology& t,
                          int width) {
    AlignedVector<Real> sum(t.rows() * std::size_t(width), Real(0));
    scatter.begin(1, t.brick_count() + 1);
    scatter.count(0, list, view, 0);
    scatter.scan();
    scatter.fill(0, view);
    for (int b = 1; b <= t.brick_count(); ++b) {
      RowMask mask;
      scatter.reduce(b, sum.data() + std::size_t(b) * kBrickRows * width, mask);
    }
    gradient.insert(gradient.end(), sum.begin(), sum.end());
  };
  gather(Scatter<Real, kWidth, false>(), records.radiance, scene.field.radiance, *scene.radiance, kWidth);
  gather(Scatter<Real, kSliceWidth, false>(), records.motion, scene.field.motion, *scene.motion, kSliceWidth);
}

}  // namespace

Line try_float_double(const Options& o, double seconds) {
  const Clock::time_point begin = Clock::now();
  Line line{"float against double", "micro-scenes"};
  // A gradient is measured against the largest of its scene.
  const double most_colour = 2e-6 + 1e-6 * std::sqrt(16 / 256.0), most_gradient = 1e-5;
  double worst_colour = 0, worst_gradient = 0;
  std::uint64_t wrong_signs = 0;
  std::vector<double> c32, c64, g32, g64;
  std::vector<int> cells32, cells64;
  std::uint64_t kinks = 0;
  while (since(begin) < seconds) {
    const std::uint64_t seed = o.seed + line.tried++;
    run<float>(seed, c32, g32, cells32);
    run<double>(seed, c64, g64, cells64);
    double colour = 0, gradient = 0, largest = 0;
    for (const double g : g64) largest = std::max(largest, std::abs(g));
    for (std::size_t i = 0; i < c64.size(); ++i) colour = std::max(colour, std::abs(c32[i] - c64[i]));
    std::uint64_t signs = 0;
    bool finite = true;
    for (std::size_t i = 0; i < g64.size(); ++i) {
      finite = finite && std::isfinite(g32[i]);
      gradient = std::max(gradient, std::abs(g32[i] - g64[i]));
      signs += std::abs(g64[i]) > 1e-6 * largest && g32[i] * g64[i] < 0;
    }
    gradient /= std::max(largest, 1e-30);
    if (cells32 != cells64) {  // a sample within rounding of a face of its cell, where the derivative of a
                               // trilinear function jumps
      ++kinks;
      gradient = 0;
      signs = 0;
    }
    worst_colour = std::max(worst_colour, colour);
    worst_gradient = std::max(worst_gradient, gradient);
    wrong_signs += signs;
    if (finite && signs == 0 && colour <= most_colour && gradient <= most_gradient) continue;
    ++line.lost;
    std::ofstream(o.out + "/float_double.txt", std::ios::app)
        << fmt::format("seed {}: colour {:.3g}, gradient {:.3g}\n", seed, colour, gradient);
  }
  line.seconds = since(begin);
  line.note = fmt::format(
      "largest error: colour {:.2g} (at most {:.2g}), gradient {:.2g} of the largest (at most {:.0g}), {} "
      "wrong signs "
      "above 1e-6; {} scenes with a sample on a face, colour only",
      worst_colour, most_colour, worst_gradient, most_gradient, wrong_signs, kinks);
  return line;
}

}  // namespace splinevox::torture
