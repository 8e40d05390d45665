// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "field/lattice/brick_view.hpp"
#include "field/lattice/slice.hpp"

namespace splinevox {

/// What one sample adds to the eight rows around it: corner c receives w_c g, and with Jet also sum_j (d w_c
/// / d f_j) h[j]. Rays write records in their own order; scatter.hpp sums them per brick. N is the row width.
template <class Real, int N, bool Jet = false>
struct Record {
  Cell cell;
  Vec3T<Real> fraction;
  Real g[N];
  Real h[Jet ? 3 : 0][N];
};

/// Everything the rays of one task leave behind.
template <class Real, int Width, bool Jet>
struct RayRecords {
  std::vector<Record<Real, Width>> radiance;
  std::vector<Record<Real, kSliceWidth, Jet>> motion;
  void clear() {
    radiance.clear();
    motion.clear();
  }
};

}  // namespace splinevox
