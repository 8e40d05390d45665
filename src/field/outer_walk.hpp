// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "field/lattice/gather.hpp"
#include "math/composite.hpp"
#include "math/contract.hpp"
#include "splinevox/field/model.hpp"

namespace splinevox {

/// What a ray meets in the surroundings, and the adjoint. One instance per task, reused.
class OuterWalk {
 public:
  static constexpr int kSamples = 32;  ///< between the box and infinity, evenly in contracted space
  static constexpr int kWidth = 8;     ///< of a row: density, colour, and four that nobody reads
  static constexpr float kStop = 1e-3f;

  struct Sample {
    Cell cell;
    Vec3 fraction;
    Emission<float> emission;
    float weight, next;  ///< T alpha, and T behind it
  };
  Sample samples[kSamples];
  int count = 0;            ///< samples of the last ray
  float transmittance = 1;  ///< left at its end

  explicit OuterWalk(const Surroundings& around)
      : around_(around), view_(*around.raw.topology), shift_(around.shift) {}

  /// The colour of a ray that has left the box (Eq. 1). @param background  behind the surroundings
  Vec3 forward(const Ray& ray, const Vec3& background) {
    const OuterRay outer(around_.box, ray);
    count = 0;
    transmittance = 1;
    Vec3 rgb{};
    for (int first = 0; first < kSamples && transmittance >= kStop; first += kChunk) {
      alignas(32) float raw[4][kChunk] = {};  // density, r, g, b
      shade(raw, gather_stored(outer, first, raw), rgb);
    }
    return rgb + transmittance * background;
  }

  /// Adjoint of the last forward: visit(sample, gradient of its raw density and colours), from the last
  /// sample to the first. @param d_rgb  gradient of the colour
  template <class Visit>
  void backward(const Vec3& background, const Vec3& d_rgb, Visit&& visit) const {
    float behind = transmittance * dot(background, d_rgb);
    for (int i = count - 1; i >= 0; --i) {
      const Sample& s = samples[i];
      const EmissionAdjoint<float> d =
          emission_vjp(s.emission, composite_vjp(s.emission, s.weight, s.next, 1.0f, behind, d_rgb));
      visit(s, d);
      behind += composite_share(s.emission, s.weight, d_rgb);
    }
  }

 private:
  static constexpr int kChunk = 8;
  static_assert(kSamples % kChunk == 0);

  /// Places and raw values of those of the samples from `first` that are met and not pruned. Returns how
  /// many.
  int gather_stored(const OuterRay& outer, int first, float (&raw)[4][kChunk]) {
    int n = 0;
    for (int i = first; i < first + kChunk; ++i) {
      const OuterRay::Place place = outer.at((float(i) + 0.5f) / kSamples);
      if (!place.met) continue;
      Vec3 u;
      for (int a = 0; a < 3; ++a) u[a] = view_.coordinate(place.at[a], a);
      const int x = int(u.x), y = int(u.y), z = int(u.z);
      const Cell cell = view_.cell(x, y, z);
      if (cell.interior() && view_.table[cell.slot] == 0) continue;  // pruned: empty
      Sample& s = samples[count + n];
      s.cell = cell;
      s.fraction = {u.x - float(x), u.y - float(y), u.z - float(z)};
      const auto row = gather<Simd<float>::Four>(view_.rows(s.cell), s.fraction, around_.raw.values.data(),
                                                 around_.raw.width, 0)
                           .value;
      for (int c = 0; c < 4; ++c) raw[c][n] = row[c];
      ++n;
    }
    return n;
  }

  /// Activates and composites the n samples after `count`, until the ray is opaque. A loop for each part, as
  /// in RayKernel: the compiler does not turn one for all into vector code.
  void shade(const float (&raw)[4][kChunk], int n, Vec3& rgb) {
    alignas(32) float sigma_slope[kChunk], sigma[kChunk], alpha[kChunk], passed[kChunk], base[3][kChunk],
        base_slope[3][kChunk];
    for (int j = 0; j < kChunk; ++j) {
      const Activated<float> density = density_of(raw[0][j], 1.0f, shift_);
      const Opacity<float> opacity = opacity_of(density.value, 1.0f);
      sigma[j] = density.value;
      sigma_slope[j] = density.slope;
      alpha[j] = opacity.alpha;
      passed[j] = opacity.passed;
    }
    for (int c = 0; c < 3; ++c)
      for (int j = 0; j < kChunk; ++j) {
        const Activated<float> color = color_of(raw[1 + c][j]);
        base[c][j] = color.value;
        base_slope[c][j] = color.slope;
      }
    for (int j = 0; j < n && transmittance >= kStop; ++j) {
      Sample& s = samples[count++];
      s.emission = {sigma[j],
                    sigma_slope[j],
                    {base[0][j], base[1][j], base[2][j]},
                    {base_slope[0][j], base_slope[1][j], base_slope[2][j]}};
      s.weight = composite_sample(s.emission, alpha[j], transmittance, rgb);
      s.next = transmittance *= passed[j];
    }
  }

  const Surroundings& around_;
  BrickView<float> view_;
  float shift_;
};

}  // namespace splinevox
