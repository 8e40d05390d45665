// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <type_traits>
#include <vector>

#include "math/least_squares.hpp"
#include "splinevox/field/edit.hpp"
#include "splinevox/field/sample.hpp"

namespace splinevox {

/// The same motion with other control points: new point k = sum_j map(k, j) old point j, for control points
/// and light, summed in double. @param map  [points x motion.points]; a pinned first point counts as zero and
/// is left out of what is stored.
MotionField with_points(const MotionField& motion, BasisKind basis, int points, FirstPoint first,
                        const Matrix& map);

/// The middles of `count` equal parts of [0, 1]: parameters at which curves are compared or fitted.
std::vector<double> middles(int count);

/// Weights of every point of a basis at every sample: [samples x points].
Matrix design(BasisKind basis, int points, const std::vector<double>& samples);

/// Control points that give curves of this basis through (nearest to) samples: [points x samples.size()],
/// first row and column zero if the first point is pinned. @param samples  parameters in [0, 1], more than
/// points
Matrix fit_matrix(BasisKind basis, int points, FirstPoint first, const std::vector<double>& samples);

/// One place of observed space that has matter.
struct MatterSample {
  Vec3 x;                   ///< observed
  FrameSampler::Warp warp;  ///< there
  float weight;             ///< opacity over one voxel, (0, 1]
};

/// Calls visit(slab, sample) for every `stride`th vertex of the radiance lattice, anywhere in the box, that
/// has matter at a parameter of the curves. Slabs of 8 along x run in parallel; within one the order is
/// fixed. There are `matter_slabs` slabs.
void visit_matter(const VoxelModel& model, double parameter, int stride,
                  const std::function<void(int slab, const MatterSample&)>& visit);
int matter_slabs(const VoxelModel& model, int stride);

/// make(sample) of every vertex that has matter at a parameter, in the order of slabs. `make` runs in
/// parallel.
template <class Make>
auto matter_at(const VoxelModel& model, double parameter, const Make& make) {
  std::vector<std::vector<std::invoke_result_t<Make, const MatterSample&>>> slabs(
      std::size_t(matter_slabs(model, 1)));
  visit_matter(model, parameter, 1, [&](int slab, const MatterSample& sample) {
    slabs[std::size_t(slab)].push_back(make(sample));
  });
  std::vector<std::invoke_result_t<Make, const MatterSample&>> all;
  for (const auto& slab : slabs) all.insert(all.end(), slab.begin(), slab.end());
  return all;
}

/// Adds distances up to one.
struct DistanceSum {
  double max = 0, squares = 0, weight = 0;
  void add(double distance, double w) {
    max = std::max(max, distance);
    squares += w * distance * distance;
    weight += w;
  }
  void add(const DistanceSum& o) {
    max = std::max(max, o.max);
    squares += o.squares;
    weight += o.weight;
  }
  MotionDifference result() const { return {max, weight > 0 ? std::sqrt(squares / weight) : 0}; }
};

}  // namespace splinevox
