// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "math/activation.hpp"
#include "math/view_factor.hpp"
#include "splinevox/core/vec3.hpp"

namespace splinevox {

/// What a row of the radiance lattice says, interpolated: columns 0 to 3, and the sum of the harmonics
/// q = sum_j sh_j Y_j(d).
template <class T>
struct RawSample {
  T density{};
  Vec3T<T> color{};
  T view{};
};

/// What a sample gives off, activated: density sigma, colour base * view * light; each with its derivative by
/// what it was made of. A factor that is off is 1, with derivative 0.
template <class T>
struct Emission {
  T sigma{}, sigma_slope{};  ///< 1 / scene unit
  Vec3T<T> base{}, base_slope{};
  T view = 1, view_slope = 0, light = 1, light_slope = 0;
};

/// d loss / d what Emission holds; after emission_vjp, d loss / d the raw values.
template <class T>
struct EmissionAdjoint {
  T density, view, light;
  Vec3T<T> color;
};

/// Density, 1 / scene unit, of a raw one (DensityActivation).
template <class T>
SPLINEVOX_INLINE Activated<T> density_of(T raw, T scale, T shift) {
  const Activated<T> s = softplus(raw + shift);
  return {scale * s.value, scale * s.slope};
}

/// Colour before the factors of view and light, of a raw one.
template <class T>
SPLINEVOX_INLINE Activated<T> color_of(T raw) {
  return sigmoid(raw);
}

/// From raw values to what is given off; the light comes with the motion (math/warp.hpp).
/// @tparam Viewed  whether the colour depends on the direction.
template <bool Viewed, class T>
SPLINEVOX_INLINE Emission<T> emission_of(const RawSample<T>& raw, T scale, T shift) {
  Emission<T> e;
  const Activated<T> density = density_of(raw.density, scale, shift);
  e.sigma = density.value;
  e.sigma_slope = density.slope;
  SPLINEVOX_UNROLL for (int c = 0; c < 3; ++c) {
    const Activated<T> color = color_of(raw.color[c]);
    e.base[c] = color.value;
    e.base_slope[c] = color.slope;
  }
  if constexpr (Viewed) {
    const Activated<T> view = view_factor(raw.view);
    e.view = view.value;
    e.view_slope = view.slope;
  }
  return e;
}

/// Adjoint of emission_of and of light_gain: from d loss / d what is given off to d loss / d raw values.
template <class T>
SPLINEVOX_INLINE EmissionAdjoint<T> emission_vjp(const Emission<T>& e, EmissionAdjoint<T> d) {
  d.density *= e.sigma_slope;
  SPLINEVOX_UNROLL for (int c = 0; c < 3; ++c) d.color[c] *= e.base_slope[c];
  d.view *= e.view_slope;
  d.light *= e.light_slope;
  return d;
}

/// Adjoint of reading a row: its gradient in the columns of one register. @param harmonics  Y_j(d) in those
/// columns, 0 where a column is no coefficient. @param first  whether it is the first register, of density,
/// colour and four coefficients (or fewer)
template <class V, class T>
SPLINEVOX_INLINE V row_vjp(const EmissionAdjoint<T>& d, const V& harmonics, bool first) {
  V g = d.view * harmonics;
  if (first) {
    g[0] = d.density;
    SPLINEVOX_UNROLL for (int c = 0; c < 3; ++c) g[1 + c] = d.color[c];
  }
  return g;
}

}  // namespace splinevox
