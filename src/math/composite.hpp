// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "splinevox/core/vec3.hpp"

namespace splinevox {

/// What a sample gives off, activated: colour base * view * light; each factor with its derivative. A factor
/// that is off is 1, with derivative 0.
template <class T>
struct Emission {
  Vec3T<T> base, base_slope;
  T view, view_slope, light, light_slope;
  T sigma_slope;  ///< d sigma / d raw density
};

/// d loss / d raw values of a sample.
template <class T>
struct EmissionAdjoint {
  T density, view, light;
  Vec3T<T> color;
};

/// Adjoint of one sample of the compositing sum of Eq. 1; call from the last sample to the first.
///
/// Has no division (numerics H9): g_sigma_i = dt (T_{i+1} c_i . G - S), S += w_i c_i . G, S starting at
/// T_end background . G. The usual S / (1 - alpha_i) is 0 / 0 from an optical depth of 17.3 on, where alpha
/// rounds to 1, and S as "total minus what came before" keeps the rounding of the total behind a wall, where
/// the gradient should be 0.
///
/// @param w       share of the sample in the pixel, T_i alpha_i.   @param next  T_{i+1}.   @param step  dt,
/// scene units.
/// @param behind  S of the samples behind this one.   @param d_rgb  d loss / d colour of the pixel, G.
template <class T>
SPLINEVOX_INLINE EmissionAdjoint<T> composite_vjp(const Emission<T>& e, T w, T next, T step, T behind,
                                                  const Vec3T<T>& d_rgb) {
  const T along = dot(e.base, d_rgb);
  const T factor = e.light * e.view;
  EmissionAdjoint<T> d;
  const T d_sigma = step * (next * factor * along - behind);
  d.density = d_sigma * e.sigma_slope;
  const T wf = w * factor;
  for (int c = 0; c < 3; ++c) d.color[c] = wf * d_rgb[c] * e.base_slope[c];
  d.view = w * along * e.light * e.view_slope;
  d.light = w * along * e.view * e.light_slope;
  return d;
}

/// What a sample adds to S: w c . G.
template <class T>
SPLINEVOX_INLINE T composite_share(const Emission<T>& e, T w, const Vec3T<T>& d_rgb) {
  return w * (e.light * e.view) * dot(e.base, d_rgb);
}

}  // namespace splinevox
