// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <memory>

#include "core/parallel.hpp"
#include "field/columns.hpp"
#include "field/edit/edit_motion.hpp"
#include "field/edit/observed_at.hpp"
#include "field/largest_presence.hpp"
#include "field/lattice/locate.hpp"
#include "math/rigidity.hpp"

namespace splinevox {
namespace {

using Eight = Simd<float>::Eight;

constexpr int kSamplesPerPoint = 4;
constexpr float kEmpty = 1e-4f;          ///< opacity over a voxel that a stored brick has at some time
constexpr double kTolerance = 1e-3;      ///< of a voxel, of the inverse
constexpr int kTimes = 16, kStride = 2;  ///< at which the result is measured

/// Observed space at the time of the sampler, as a canonical volume.
Channels observed_volume(const VoxelModel& model, const FrameSampler& first) {
  const RadianceField& field = model.radiance;
  const Lattice& lattice = field.raw.topology->lattice;
  Channels dense = make_channels(make_dense_topology(lattice), field.raw.width, field.raw.row(0));
  const BrickView<float> view(*field.raw.topology);
  const Topology& t = *dense.topology;
  const LargestPresence presence(model);
  std::vector<char> matters(t.bricks.size(), 0);
  parallel_for(t.brick_count(), [&](int index) {
    for (int i = 0; i < kBrickRows; ++i) {
      const Vec3 c = first.canonical(t.position(index + 1, i));
      const Located at = locate(view, c);
      float* row = dense.row(std::size_t(index + 1) * kBrickRows + std::size_t(i));
      for (int k = 0; k < dense.width; k += 8)
        store(row + k, interpolate<Eight>(at, field.raw.values.data(), dense.width, k));
      const float density = first.radiance(c, presence.around(c, lattice.spacing)).density;
      if (density * lattice.spacing >= kEmpty) matters[std::size_t(index + 1)] = 1;
    }
  });
  std::vector<Int3> bricks;
  for (int b = 1; b <= t.brick_count(); ++b)
    if (matters[std::size_t(b)]) bricks.push_back(t.bricks[std::size_t(b)]);
  Channels out = make_channels(make_topology(lattice, bricks), dense.width, dense.row(0));
  for (int b = 1; b <= out.topology->brick_count(); ++b) {
    const auto from = std::size_t(t.brick_at(out.topology->bricks[std::size_t(b)]));
    std::copy_n(dense.row(from * kBrickRows), std::size_t(kBrickRows) * std::size_t(dense.width),
                out.row(std::size_t(b) * kBrickRows));
  }
  return out;
}

}  // namespace

MotionDifference anchor_first(VoxelModel& model) {
  const VoxelModel before = model;
  const MotionField& m = before.motion;
  const double s0 = m.time_curve(0), voxel = before.radiance.raw.topology->lattice.spacing;
  const FrameSampler first(before, FrameSampler::AtParameter{s0});
  model.radiance.raw = observed_volume(before, first);

  const std::vector<double> at = middles(kSamplesPerPoint * m.points);
  const int n = int(at.size());
  std::vector<std::unique_ptr<FrameSampler>> samplers;
  for (const double s : at)
    samplers.push_back(std::make_unique<FrameSampler>(before, FrameSampler::AtParameter{s}));
  // A light that is not zero at time 0 needs its first point, and so the curves keep theirs.
  const Basis& basis = basis_of(m.basis);
  const bool alone = m.stride() == facts_of(ColumnKind::control).width;
  const FirstPoint pin = basis.pinnable && s0 == 0 && alone ? FirstPoint::zero : FirstPoint::free;
  Matrix same(m.points, m.points);
  for (int k = 0; k < m.points; ++k) same(k, k) = 1;
  model.motion = with_points(m, m.basis, m.points, pin, same);
  const Matrix fit = fit_matrix(m.basis, m.points, pin, at);
  const BasisWeights<double> w0 = basis.weights(m.points, s0);
  Channels& level = model.motion.levels[0];
  const int skipped = model.motion.points - model.motion.stored_points(), stride = model.motion.stride();
  parallel_for(level.topology->brick_count(), [&](int index) {
    std::vector<Vec3d> wanted(std::size_t(n), Vec3d{}), points(std::size_t(m.points), Vec3d{});
    for (int i = 0; i < kBrickRows; ++i) {
      const Vec3 x = level.topology->position(index + 1, i);
      const float r = std::max(first.warp(x).rigidity, kLeastRigidity);
      Vec3d y = cast<double>(x);
      for (int j = 0; j < n; ++j) {
        const Vec3d target = cast<double>(samplers[std::size_t(j)]->canonical(x));
        y = observed_at(first, target,
                        {y, target - cast<double>(first.warp(x).displacement), target, cast<double>(x)},
                        kTolerance * voxel);
        wanted[std::size_t(j)] = (y - cast<double>(x)) * (1.0 / r);
      }
      Vec3d start{};
      for (int k = 0; k < m.points; ++k) {
        points[std::size_t(k)] = {};
        for (int j = 0; j < n; ++j) points[std::size_t(k)] += fit(k, j) * wanted[std::size_t(j)];
        start += w0[std::size_t(k)] * points[std::size_t(k)];
      }
      float* row = level.row(std::size_t(index + 1) * kBrickRows + std::size_t(i));
      for (int k = skipped; k < m.points; ++k) {
        Vec3d p = points[std::size_t(k)];
        if (pin == FirstPoint::free && basis.is_place(k)) p -= start;
        for (int a = 0; a < 3; ++a) row[stride * (k - skipped) + a] = float(p[a]);
      }
    }
  });

  DistanceSum all;
  for (const double s : middles(kTimes)) {
    const FrameSampler now(model, FrameSampler::AtParameter{s});
    std::vector<DistanceSum> slabs(std::size_t(matter_slabs(before, kStride)));
    visit_matter(before, s, kStride, [&](int slab, const MatterSample& place) {
      const double d =
          length(first.canonical(now.canonical(place.x)) - (place.x + place.warp.displacement)) / voxel;
      slabs[std::size_t(slab)].add(d, place.weight);
    });
    for (const DistanceSum& sum : slabs) all.add(sum);
  }
  return all.result();
}

}  // namespace splinevox
