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
    for (int i = 0; i < kSamples && transmittance >= kStop; ++i) {
      const OuterRay::Place place = outer.at((float(i) + 0.5f) / kSamples);
      if (!place.met) continue;
      Vec3 u;
      for (int a = 0; a < 3; ++a) u[a] = view_.coordinate(place.at[a], a);
      const int x = int(u.x), y = int(u.y), z = int(u.z);
      const Cell cell = view_.cell(x, y, z);
      if (cell.interior() && view_.table[cell.slot] == 0) continue;  // pruned: empty
      Sample& s = samples[count++];
      s.cell = cell;
      s.fraction = {u.x - float(x), u.y - float(y), u.z - float(z)};
      const auto raw = gather<Simd<float>::Four>(view_.rows(s.cell), s.fraction, around_.raw.values.data(),
                                                 around_.raw.width, 0)
                           .value;
      s.emission = emission_of<false>(RawSample<float>{raw[0], {raw[1], raw[2], raw[3]}, 0}, 1.0f, shift_);
      const Opacity<float> opacity = opacity_of(s.emission.sigma, 1.0f);
      s.weight = composite_sample(s.emission, opacity.alpha, transmittance, rgb);
      s.next = transmittance *= opacity.passed;
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
  const Surroundings& around_;
  BrickView<float> view_;
  float shift_;
};

}  // namespace splinevox
