// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "splinevox/core/vec3.hpp"

namespace splinevox {

/// Where a ray through a tracked point sees it.
template <class T>
struct Sighting {
  Vec3T<T> place{};  ///< mean of what the ray shows, in the canonical volume, scene units
  T alpha = 0;       ///< of the ray, 0 to 1; 0: it shows nothing, and no place
};

/// Share of the box's longest edge that a distance is measured in. From there on it counts as it does, and no
/// longer as its square.
inline constexpr double kTrackWidth = 0.01;

/// What two sightings of one point at two moments differ by, and the derivative by the first one's place.
/// That by the other's is the opposite.
template <class T>
struct TrackError {
  T value = 0;
  Vec3T<T> slope{};
};

/// Charbonnier's penalty of their distance (depth_error has its source), times both alphas, which are
/// constants: a track that is wrong pulls no more than one that is nearly right.
/// @param scale  1 / longest edge of the box, 1 / scene unit
template <class T>
SPLINEVOX_INLINE TrackError<T> track_error(const Sighting<T>& a, const Sighting<T>& b, T scale) {
  using std::sqrt;
  const T per_width = scale / T(kTrackWidth), both = a.alpha * b.alpha;
  const Vec3T<T> x = per_width * (a.place - b.place);
  const T root = sqrt(T(1) + dot(x, x));
  return {both * (root - T(1)), (both * per_width / root) * x};
}

}  // namespace splinevox
