// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/hd.hpp"

namespace splinevox {

/// Raw density of a sample whose matter comes and goes: what its canonical place says, and the presence of
/// its place and time. Its adjoint is the identity: the gradient by either is that by the sum.
///
/// Not in the paper, which hopes for "an orthogonal component" here: p(x, t) is a spline of *observed* space
/// on the motion lattice, with the basis of the control points and without its mean over time,
///
///   p(x, t) = sum_k (w_k(t) - m_k) p_k(x),   m_k = the mean of w_k over [0, 1],
///
/// so that the mean of the raw density stays in the canonical volume, and 0 changes nothing.
template <class T>
SPLINEVOX_INLINE T present(T raw, T presence) {
  return raw + presence;
}

}  // namespace splinevox
