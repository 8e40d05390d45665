// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "splinevox/field/model.hpp"

/// Smaller models that look alike.
namespace splinevox::run {

/// A vertex counted from the ring of absent bricks around a lattice, as BrickView does: its brick there, and
/// the row inside.
struct RingVertex {
  Int3 brick;
  int row;
};
inline RingVertex ring_vertex(Int3 v) {
  return {{v.x >> 3, v.y >> 3, v.z >> 3}, (v.x & 7) << 6 | (v.y & 7) << 3 | (v.z & 7)};
}
/// Where the table has a brick of the ring.
inline std::size_t ring_slot(const Topology& t, Int3 brick) {
  return (std::size_t(brick.x) * t.dims.y + brick.y) * t.dims.z + brick.z;
}

/// The field on every second vertex, weighted 1/4, 1/2, 1/4 along each axis.
RadianceField halved(const RadianceField& field);

/// The field with the mean over all directions in place of the view rescale, Eq. 5: the colour a matt surface
/// would have.
RadianceField without_view(const RadianceField& field);

}  // namespace splinevox::run
