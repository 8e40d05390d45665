// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "io/export/carried_mesh.hpp"
#include "io/export/carried_points.hpp"

namespace splinevox {

/// When what is carried is shown.
struct UsdPlay {
  std::string name;         ///< of the prim
  std::vector<int> frames;  ///< [frames] their numbers, rising
  double fps = 24;
  float still =
      0;  ///< scene units: what moves by less from its first place is there; by less a frame, stands
};

/// Text of a .usda layer with one Mesh (UsdGeom's schema): faces and colours once, places, velocities and
/// extent at every frame that is not like both beside it. Colours are linear, of the first frame.
std::string usd_mesh(CarriedMesh carried, const UsdPlay& play);

/// The same of Points. Where the way of some is lost at some frame, primvars:folded is 1 there.
/// @param width  of a point, scene units
std::string usd_points(const CarriedPoints& carried, const UsdPlay& play, float width);

}  // namespace splinevox
