// SPDX-License-Identifier: Apache-2.0
#include "field/edit/edit_motion.hpp"

#include <algorithm>
#include <cmath>

#include "core/parallel.hpp"
#include "field/lattice/slice.hpp"
#include "field/matter_reach.hpp"
#include "math/activation.hpp"
#include "math/time_curve.hpp"

namespace splinevox {
namespace {

constexpr int kSamplesPerPoint = 8;   ///< of a curve, where one is fitted to another
constexpr int kDifferenceTimes = 24;  ///< parameters at which motions are compared
constexpr int kDifferenceStride = 2;  ///< vertices
constexpr float kFaint = 1e-2f;       ///< opacity over a voxel below which a place is empty

/// Every `stride`th vertex of the radiance lattice.
Lattice every(const VoxelModel& model, int stride) {
  Lattice lattice = model.radiance.raw.topology->lattice;
  lattice.spacing *= float(stride);
  for (int a = 0; a < 3; ++a) lattice.size[a] = (lattice.size[a] + stride - 1) / stride;
  return lattice;
}

}  // namespace

std::vector<double> middles(int count) {
  std::vector<double> s;
  for (int i = 0; i < count; ++i) s.push_back((i + 0.5) / count);
  return s;
}

Matrix design(BasisKind basis, int points, const std::vector<double>& samples) {
  Matrix a(int(samples.size()), points);
  for (int i = 0; i < a.rows; ++i) {
    const BasisWeights<double> w = basis_of(basis).weights(points, samples[std::size_t(i)]);
    for (int k = 0; k < points; ++k) a(i, k) = w[std::size_t(k)];
  }
  return a;
}

void retime(MotionField& motion, const TimeCurve& change) {
  motion.time_curve = compose(motion.time_curve, change);
}

void scale_motion(MotionField& motion, float factor) {
  if (!motion.displaces) return;
  const int stride = motion.stride();
  for (Channels& level : motion.levels)
    for (std::size_t r = 0; r < level.topology->rows(); ++r)
      for (int k = 0; k < motion.stored_points(); ++k)
        for (int a = 0; a < 3; ++a) level.row(r)[stride * k + a] *= factor;
}

MotionField with_points(const MotionField& motion, BasisKind basis, int points, FirstPoint first,
                        const Matrix& map) {
  MotionField out = motion;
  out.basis = basis;
  out.points = points;
  out.first_point = first;
  const int from = motion.points - motion.stored_points(), to = out.points - out.stored_points();
  const int stride = motion.stride();
  for (std::size_t l = 0; l < motion.levels.size(); ++l) {
    const Channels& old = motion.levels[l];
    out.levels[l] =
        make_channels(old.topology, out.width(), std::vector<float>(std::size_t(out.width()), 0.0f).data());
    parallel_for(old.topology->brick_count() + 1, [&](int brick) {
      for (std::size_t r = std::size_t(brick) * kBrickRows; r < std::size_t(brick + 1) * kBrickRows; ++r) {
        const float* in = old.row(r);
        float* row = out.levels[l].row(r);
        for (int k = to; k < points; ++k)
          for (int a = 0; a < stride; ++a) {
            double sum = 0;
            for (int j = from; j < motion.points; ++j) sum += map(k, j) * in[stride * (j - from) + a];
            row[stride * (k - to) + a] = float(sum);
          }
        if (motion.rigidity) row[out.rigidity_column()] = in[motion.rigidity_column()];
      }
    });
  }
  return out;
}

MotionField elevated(const MotionField& motion, int by) {
  const Refinement& refinement = basis_of(motion.basis).refinement;
  const int points = motion.points + by;
  Matrix map(points, motion.points);
  for (int j = 0; j < motion.points; ++j) {  // the images of the unit vectors
    std::vector<double> p(std::size_t(motion.points), 0.0), q;
    p[std::size_t(j)] = 1;
    for (int n = motion.points; n < points; ++n) {
      q.assign(std::size_t(n) + 1, 0.0);
      refinement(n, p.data(), q.data());
      p = q;
    }
    for (int k = 0; k < points; ++k) map(k, j) = p[std::size_t(k)];
  }
  return with_points(motion, motion.basis, points, motion.first_point, map);
}

Matrix fit_matrix(BasisKind basis, int points, FirstPoint first, const std::vector<double>& samples) {
  const int pinned = first == FirstPoint::zero ? 1 : 0, n = int(samples.size());
  const Matrix all = design(basis, points, samples);
  Matrix a(n, points - pinned), one(n, n);
  for (int i = 0; i < n; ++i) {
    one(i, i) = 1;
    for (int k = pinned; k < points; ++k) a(i, k - pinned) = all(i, k);
  }
  const Matrix x = least_squares(std::move(a), std::move(one));
  Matrix out(points, n);
  for (int k = pinned; k < points; ++k)
    for (int i = 0; i < n; ++i) out(k, i) = x(k - pinned, i);
  return out;
}

MotionField converted(const MotionField& motion, BasisKind basis, int points) {
  const FirstPoint first = basis_of(basis).pinnable ? motion.first_point : FirstPoint::free;
  const std::vector<double> samples = middles(kSamplesPerPoint * std::max(points, motion.points));
  return with_points(
      motion, basis, points, first,
      product(fit_matrix(basis, points, first, samples), design(motion.basis, motion.points, samples)));
}

int matter_slabs(const VoxelModel& model, int stride) {
  return (every(model, stride).size.x + kBrick - 1) / kBrick;
}

void visit_matter(const VoxelModel& model, double parameter, int stride,
                  const std::function<void(int, const MatterSample&)>& visit) {
  const FrameSampler sampler(model, FrameSampler::AtParameter{parameter});
  const Lattice& all = model.radiance.raw.topology->lattice;
  const Lattice lattice = every(model, stride);
  const std::vector<Int3> leaves = MatterReach(model, float(optical_depth(kFaint)) / all.spacing)
                                       .candidates(lattice, parameter_weights(model.motion, parameter));
  const auto below = [](const Int3& leaf, int x) { return leaf.x < x; };
  parallel_for(matter_slabs(model, stride), [&](int slab) {
    const auto from = std::lower_bound(leaves.begin(), leaves.end(), slab, below),
               to = std::lower_bound(from, leaves.end(), slab + 1, below);
    for (auto leaf = from; leaf != to; ++leaf)
      for (int i = 0; i < kBrickRows; ++i) {
        const Int3 v = kBrick * *leaf + Int3{i >> 6, i >> 3 & 7, i & 7};
        if (v.x >= lattice.size.x || v.y >= lattice.size.y || v.z >= lattice.size.z) continue;
        MatterSample s;
        s.x = all.position(stride * v);
        s.warp = sampler.warp(s.x);
        s.weight = one_minus_exp_neg(sampler.radiance(s.x + s.warp.displacement, s.warp.presence).density *
                                     all.spacing);
        if (s.weight >= kFaint) visit(slab, s);
      }
  });
}

namespace {

/// What differs at the places of one model's matter.
struct Differences {
  DistanceSum distance;
  float light = 0, opacity = 0;
};

/// At the matter of one model at a parameter.
Differences differences(const VoxelModel& model, const VoxelModel& other, double parameter) {
  const float voxel = model.radiance.raw.topology->lattice.spacing;
  const FrameSampler sampler(other, FrameSampler::AtParameter{parameter});
  std::vector<Differences> slabs(std::size_t(matter_slabs(model, kDifferenceStride)));
  visit_matter(model, parameter, kDifferenceStride, [&](int slab, const MatterSample& place) {
    Differences& d = slabs[std::size_t(slab)];
    const FrameSampler::Warp there = sampler.warp(place.x);
    d.distance.add(
        length(cast<double>(there.displacement) - cast<double>(place.warp.displacement)) / double(voxel),
        place.weight);
    d.light = std::max(d.light, std::abs(there.light - place.warp.light));
    const float opacity = one_minus_exp_neg(
        sampler.radiance(place.x + place.warp.displacement, there.presence).density * voxel);
    d.opacity = std::max(d.opacity, std::abs(opacity - place.weight));
  });
  Differences all;
  for (const Differences& d : slabs) {
    all.distance.add(d.distance);
    all.light = std::max(all.light, d.light);
    all.opacity = std::max(all.opacity, d.opacity);
  }
  return all;
}

}  // namespace

MotionDifference motion_difference(const VoxelModel& before, const VoxelModel& after) {
  DistanceSum distance;
  float light = 0, opacity = 0;
  for (const double s : middles(kDifferenceTimes)) {
    const Differences here = differences(before, after, s);
    distance.add(here.distance);
    light = std::max(light, here.light);
    opacity = std::max(opacity, here.opacity);
    if (before.motion.presence)  // what appears was no matter before
      opacity = std::max(opacity, differences(after, before, s).opacity);
  }
  const MotionDifference d = distance.result();
  return {d.max, d.rms, light, opacity};
}

}  // namespace splinevox
