// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/hd.hpp"

namespace splinevox {

/// Share of a group of parameters that is taken away where its length is not worth a threshold: 1 up to the
/// threshold, then (threshold / length)^2, the shrinkage of the non-negative garrote (Breiman 1995) on
/// groups. Unlike the group lasso's threshold / length it leaves large groups alone, so that what truly moves
/// is not slowed (docs/experiments.md).
template <class T>
SPLINEVOX_HD T garrote_share(T length, T threshold) {
  const T ratio = length <= threshold ? T(1) : threshold / length;
  return ratio * ratio;
}

}  // namespace splinevox
