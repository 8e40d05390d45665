// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "math/emission.hpp"

namespace splinevox {

/// What a step of the march keeps of the light, alpha = 1 - exp(-sigma dt), and what it lets through.
template <class T>
struct Opacity {
  T alpha, passed;
};
/// @param sigma  density, 1 / scene unit. @param step  dt, scene units.
template <class T>
SPLINEVOX_INLINE Opacity<T> opacity_of(T sigma, T step) {
  const T depth = sigma * step;
  return {one_minus_exp_neg(depth), exp_(-depth)};
}

/// One sample of the compositing sum of Eq. 1, front to back: rgb += w c with w = T_i alpha_i and
/// c = base light view. Behind it T_{i+1} = T_i passed_i.
/// @param transmittance  T_i. @returns w
template <class T>
SPLINEVOX_INLINE T composite_sample(const Emission<T>& e, T alpha, T transmittance, Vec3T<T>& rgb) {
  const T w = transmittance * alpha;
  rgb += (w * (e.light * e.view)) * e.base;
  return w;
}

/// Whether a ray ends behind the sample that left this much of it.
template <class T>
SPLINEVOX_INLINE bool ray_ends(T transmittance, T stop) {
  return transmittance < stop;
}

/// A prior on what a ray leaves of the light: lambda T (1 - T), with its derivative by T. A ray ends on
/// something or passes, and fog does neither.
/// @param weight  lambda
template <class T>
SPLINEVOX_INLINE Activated<T> transmittance_prior(T transmittance, T weight) {
  return {weight * transmittance * (T(1) - transmittance), weight * (T(1) - T(2) * transmittance)};
}

/// S behind the last sample of a ray: T_end times d loss / d T_end, by the colour behind it and by the prior.
/// @param d_rgb  d loss / d colour of the pixel. @param prior  weight of transmittance_prior
template <class T>
SPLINEVOX_INLINE T composite_end(T transmittance, const Vec3T<T>& background, const Vec3T<T>& d_rgb,
                                 T prior) {
  return transmittance * (dot(background, d_rgb) + transmittance_prior(transmittance, prior).slope);
}

/// Adjoint of composite_sample, by what the sample gives off; call from the last sample to the first, and
/// emission_vjp behind it.
///
/// Has no division (numerics H9): g_sigma_i = dt (T_{i+1} c_i . G - S), S += w_i c_i . G, S starting at
/// composite_end. The usual S / (1 - alpha_i) is 0 / 0 from an optical depth of 17.3 on, where alpha
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
  d.density = step * (next * factor * along - behind);
  const T wf = w * factor;
  for (int c = 0; c < 3; ++c) d.color[c] = wf * d_rgb[c];
  d.view = w * along * e.light;
  d.light = w * along * e.view;
  return d;
}

/// What a sample adds to S: w c . G.
template <class T>
SPLINEVOX_INLINE T composite_share(const Emission<T>& e, T w, const Vec3T<T>& d_rgb) {
  return w * (e.light * e.view) * dot(e.base, d_rgb);
}

/// One more channel that is composited beside the colour, such as a distance: the same sweep with a value x
/// in place of a colour.
/// @{
/// What a sample adds to S: w x G. @param d_value  d loss / d sum of w x, G
template <class T>
SPLINEVOX_INLINE T channel_share(T w, T x, T d_value) {
  return w * x * d_value;
}
/// What it adds to d loss / d sigma of composite_vjp, whose `behind` holds the shares of all channels.
template <class T>
SPLINEVOX_INLINE T channel_vjp(T next, T step, T x, T d_value) {
  return step * next * x * d_value;
}
/// @}

}  // namespace splinevox
