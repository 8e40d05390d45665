// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "math/photometric.hpp"

namespace splinevox {

/// A camera shows a colour C of the scene as g C, with a gain g per channel: its exposure and its white
/// balance. The model stays neutral: the targets of its rays are what the camera shows, divided by g.
///
/// Where picture and background together reach 1 the picture is cut off, and the target is a bound.
/// @param display  the pixel over the ray's background. @param shown  of it the pixel: its value times alpha
/// @param clipped  whether pictures are cut off
template <class T>
SPLINEVOX_HD inline T neutral_target(T display, T shown, T gain, bool clipped = true) {
  const T target = display + shown * (1 / gain - 1);
  return clipped && display >= T(1) ? at_least(target) : target;
}

/// One ray's share in the least squares for its camera's gain: sum (g C - shown)^2 is least at g = sum along
/// / sum square.
template <class T>
struct GainTerm {
  T along, square;
};
/// @param shown  value of the pixel times its alpha. @param error  of the ray against its neutral target
/// @param bound  the target is one: met, it says nothing of g
template <class T>
SPLINEVOX_HD inline GainTerm<T> gain_term(T shown, T error, T gain, bool bound) {
  if (bound && error == T(0)) return {T(0), T(0)};
  const T c = shown / gain + error;
  return {c * shown, c * c};
}

}  // namespace splinevox
