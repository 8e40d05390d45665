// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "field/columns.hpp"
#include "field/lattice/row_mask.hpp"
#include "splinevox/field/model.hpp"
#include "splinevox/math/basis.hpp"

namespace splinevox {

/// Basis weights of the *stored* control points at a time, computed in double and rounded once. The time
/// curve is in them.
/// @param t  clamped to [0, 1].
BasisWeights<float> stored_weights(const MotionField& motion, double t);
/// Their time derivatives, per unit of model time.
BasisWeights<float> stored_weights_dt(const MotionField& motion, double t);
/// The same at a parameter s of the curves in [0, 1]: without the time curve.
BasisWeights<float> parameter_weights(const MotionField& motion, double s);
BasisWeights<float> parameter_weights_dt(const MotionField& motion, double s);

/// Weights m_k whose sum with a curve's stored points is its mean over the parameters [0, 1]: what the curves
/// of presence go without (math/presence.hpp). Exact: Simpson's rule over each cubic piece, in double.
BasisWeights<float> mean_weights(const MotionField& motion);

/// Row of a slice: displacement before rigidity (3, scene units), raw rigidity (1), the curves of one number
/// (raw light, presence), padding.
inline constexpr int kSliceWidth = 8;
static_assert(kSliceUsed <= kSliceWidth);

/// What it takes to contract rows of a motion field: the layout of a row, and of a field with presence the
/// weights of the mean.
struct Contraction {
  MotionLayout layout;
  int count;                 ///< stored points
  BasisWeights<float> mean;  ///< 0 without presence

  Contraction(const MotionField& motion);  // NOLINT: a field stands for its contraction

  /// sum_k m_k p_k of a curve of one number. @param points  its first point in a row
  float mean_at(const float* points) const;
};

/// Floats of a slice's row that a field stores something for: from the first to the last of them.
int stored_floats(const MotionField& motion);

/// The motion field at one time, contracted: 6 floats a row instead of 5 K + 1. Every sample of a frame
/// shares its time and interpolation is linear, so sampling the slice equals sampling the curves.
struct MotionSlice {
  TopologyPtr topology;         ///< null: nothing changes over time
  AlignedVector<float> values;  ///< [rows * kSliceWidth]
};

/// Contracts the given rows of one brick of a level into the slices of several times ([times] of [rows *
/// kSliceWidth], all bricks): sum_k w_k p_k of every curve, less the mean of presence, and raw rigidity. A
/// row is read once for all times.
void contract_brick(const Contraction& by, const Channels& level,
                    std::span<const BasisWeights<float>> weights, int brick, const RowMask& rows,
                    std::span<float* const> out);
/// Adjoint of contract_brick for the given rows of one brick at one time, but for the mean of presence:
/// gradient += the slice's gradient expanded to control points. Clears what it has read.
/// @param slice_gradient  of this brick, [512 * kSliceWidth]
void expand_brick(const Contraction& by, const BasisWeights<float>& weights, const RowMask& rows,
                  float* slice_gradient, int brick, Channels& gradient);

/// The rest of the adjoint, once all times of a step are expanded: the gradient of the mean of presence.
/// @pre the weights of the stored points sum to 1 at every time: the first point is free
void centre_brick(const Contraction& by, const RowMask& rows, int brick, Channels& gradient);

/// d loss / d time of a slice by the given rows of one brick: the slice's gradient times what sum_k w'_k p_k
/// says that the slice changes by. Rigidity has no time.
/// @param weights_dt      stored_weights_dt at the slice's time
/// @param slice_gradient  of this brick, before expand_brick clears it
double slope_brick(const Contraction& by, const Channels& level, const BasisWeights<float>& weights_dt,
                   const RowMask& rows, const float* slice_gradient, int brick);

/// The slice for the weights of one time. @pre at most one level: collapse first.
MotionSlice make_slice(const MotionField& motion, const BasisWeights<float>& weights);
/// The same into the memory of an earlier slice: fresh memory costs as much as the contraction.
/// @param rows  [bricks + 1] of those that are not zero, the same for all slices that share memory; empty:
/// any may be.
void fill_slice(const MotionField& motion, const BasisWeights<float>& weights, MotionSlice& out,
                std::span<const RowMask> rows = {});

/// The same motion with all levels summed into one on the finest lattice.
MotionField collapse(const MotionField& motion);

}  // namespace splinevox
