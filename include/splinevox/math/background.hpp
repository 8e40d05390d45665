// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "splinevox/core/vec3.hpp"
#include "splinevox/math/sh.hpp"

namespace splinevox {

/// What is behind everything: one colour, or where pictures are opaque a learned one for every direction. It
/// has no place, so it neither comes nearer nor moves: what is far away.
struct Background {
  Vec3 color{1, 1,
             1};  ///< display values in [0, 1]; of a learned one its band 0, for who can show only one colour
  int order = -1;  ///< of the harmonics, at most kMaxShOrder; -1: `color` everywhere
  Vec3 raw[kMaxShCount] = {};

  bool learned() const { return order >= 0; }
  int count() const { return (order + 1) * (order + 1); }
  /// @param direction  unit length
  Vec3 towards(const Vec3& direction) const;
  friend bool operator==(const Background&, const Background&) = default;
};

}  // namespace splinevox
