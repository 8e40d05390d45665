// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "splinevox/data/synth.hpp"

namespace splinevox::data {

/// Matter that is born at a source, rises, turns about the z axis, thins out and is gone: a sum of puffs,
/// each a ball with soft edges that has an age. Numbers in scene units and in units of the scene's time.
struct Gas {
  std::uint64_t seed;   ///< of the puffs
  int puffs;            ///< that are born evenly from `from` to `until`
  double from, until;   ///< births
  double life;          ///< age at which a puff is gone
  double rise;          ///< way up during a life
  double turn, spread;  ///< radians about the axis, and way from it, during a life
  double source;        ///< radius of the circle that the source goes round on, once in the scene's time
  double narrow, wide;  ///< radius of a puff at birth and at the end
  double density;       ///< of a puff at birth, in its middle; 1 / scene unit
  double detail;        ///< share of the density that finer noise takes away or adds, [0, 1)
  Vec3d colours[4];     ///< display values at age 0, 1/3, 2/3 and 1
};

extern const Gas kSmoke, kFire;

/// The lattice that gas is given on: all of it, at all times, with a border of no density.
SynthVolume gas_lattice();

/// Gas at a time. @param light  gain of its colours
SynthVolume gas_at(const Gas& gas, double time, double light);

/// What a ray gathers on the way.
struct Gathered {
  Vec3d emission{};          ///< of colour, already dimmed by what is before it
  double transmittance = 1;  ///< share of what is behind that still shows
};

/// Absorption and emission as renderers composite them: a piece of length dt with density s and colour c
/// hides 1 - exp(-s dt) of what is behind and shows that much of c.
/// @param until  distance from the ray's origin at which something solid stands
/// @param ray    direction has unit length
Gathered gather_along(const SynthVolume& volume, const Ray& ray, double until);

}  // namespace splinevox::data
