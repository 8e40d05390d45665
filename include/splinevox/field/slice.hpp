// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "splinevox/field/model.hpp"
#include "splinevox/field/row_mask.hpp"
#include "splinevox/math/basis.hpp"

namespace splinevox {

/// Basis weights of the *stored* control points at a time, computed in double and rounded once.
/// @param t  clamped to [0, 1].
BasisWeights<float> stored_weights(const MotionField& motion, double t);
/// Their time derivatives, per unit of model time.
BasisWeights<float> stored_weights_dt(const MotionField& motion, double t);

/// Row of a slice: displacement before rigidity (3, scene units) and raw rigidity (1).
inline constexpr int kSliceWidth = 4;

/// The motion field at one time, contracted: 4 floats a row instead of 3 K + 1. Every sample of a frame shares its time and
/// interpolation is linear, so sampling the slice equals sampling the curves.
struct MotionSlice {
  TopologyPtr topology;         ///< null: the scene does not move
  AlignedVector<float> values;  ///< [rows * 4]
};

/// Contracts bricks [first, last) of one level: out ([rows * 4]) = sum_k w_k p_k and raw rigidity.
void contract_bricks(const MotionField& motion, const Channels& level, const BasisWeights<float>& weights, int first,
                     int last, float* out);
/// Adjoint of contract_bricks for one brick, summed over frames: gradient += the slices' gradients ([frames] of [rows * 4]),
/// expanded to control points. Marks the rows that any frame touched.
void expand_brick(const MotionField& motion, const BasisWeights<float>* weights, const float* const* slice_gradients,
                  int frames, int brick, Channels& gradient, RowMask& touched);

/// The slice for the weights of one time. @pre at most one level: collapse first.
MotionSlice make_slice(const MotionField& motion, const BasisWeights<float>& weights);

/// The same motion with all levels summed into one on the finest lattice.
MotionField collapse(const MotionField& motion);

}  // namespace splinevox
