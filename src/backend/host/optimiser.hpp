// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

#include "backend/host/gradient.hpp"
#include "backend/step.hpp"

namespace splinevox {

/// One Adam (or RMSProp) step on every touched row, times `rate_scale`, then its groups' shrinkage; clears
/// gradient and mask. The only writer of parameters. Padding columns have rate 0 and stay as they are.
void update(const LearnedRows& rows, Gradient& gradient, const MomentFactors& factors, float rate_scale);

/// Adds the gradient of scale * sum_c tv_c * (sum over voxels of Eq. 9), estimated on a random share of the
/// bricks and divided by it, and marks their rows touched. Absent neighbours do not count, and rows that are
/// not visible are as if absent: Adam's steps do not shrink with the gradient, so what no ray sees would soon
/// be as its neighbours are, and matter would grow there.
/// @param tv       [width]
/// @param draw     identifies the random subset
/// @param visible  LearnedRows::visible; empty: all rows
void add_total_variation(const Channels& values, std::span<const float> tv, float scale, float share,
                         std::uint64_t draw, std::span<const RowMask> visible, Gradient& gradient);

/// Adds the gradient of a prior on the curves of voxels, on the same random bricks.
/// @param motion  columns of the rows
/// @param among   rows that the prior acts on, [bricks + 1]; empty: all
void add_curve_prior(const Channels& values, const MotionField& motion, const CurvePrior& prior, float share,
                     std::uint64_t draw, std::span<const RowMask> among, Gradient& gradient);
void add_curve_prior(const Channels& values, const MotionField& motion, const StaticPrior& prior, float share,
                     std::uint64_t draw, std::span<const RowMask> among, Gradient& gradient);

}  // namespace splinevox
