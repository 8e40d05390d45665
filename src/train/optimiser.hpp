// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "math/adam.hpp"
#include "math/curve_prior.hpp"
#include "train/engine.hpp"

namespace splinevox {

/// Columns of a row that are drawn to zero together unless their gradients insist (math/shrink.hpp).
struct Shrink {
  std::vector<float> member;  ///< [width] 1 for columns of the group, else 0
  float threshold = 0;        ///< length of the group, per touch and at the full rate
};

/// What training keeps beside one value array: gradient, moments, and per column a learning rate and a total
/// variation weight.
struct Learner {
  Gradient gradient;
  AlignedVector<float> m, v;    ///< first and second moments, same rows
  std::vector<float> rate, tv;  ///< [width]; 0 in padding
  std::vector<Shrink> shrink;   ///< groups of columns

  Learner() = default;
  explicit Learner(const Channels& values);
  /// For values whose rows got another width, as the moments have: gradient, rates and weights begin anew;
  /// what is seen stays.
  void resize(const Channels& values);
};

/// One Adam (or RMSProp) step on every touched row, times `rate_scale`, then its groups' shrinkage; clears
/// gradient and mask. The only writer of parameters. Padding columns have rate 0 and stay as they are.
void update(Channels& values, Learner& learner, const MomentFactors& factors, float rate_scale);

/// Adds the gradient of scale * sum_c tv_c * (sum over voxels of Eq. 9), estimated on a random share of the
/// bricks and divided by it, and marks their rows touched. Absent neighbours do not count. @param draw
/// identifies the random subset.
void add_total_variation(const Channels& values, Learner& learner, float scale, float share,
                         std::uint64_t draw);

/// Adds the gradient of a prior on the curves of voxels, on the same random bricks. @param among  rows that
/// may be looked at, [bricks + 1]; empty: all
void add_curve_prior(const Channels& values, Learner& learner, const MotionField& motion,
                     const CurvePrior& prior, float share, std::uint64_t draw);
void add_curve_prior(const Channels& values, Learner& learner, const MotionField& motion,
                     const RestPrior& prior, float share, std::uint64_t draw, std::span<const RowMask> among);

}  // namespace splinevox
