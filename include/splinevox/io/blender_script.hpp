// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "splinevox/core/vec3.hpp"

namespace splinevox {

/// What load_in_blender.py has to know about the sequence beside it.
struct BlenderSequence {
  int first = 1, last = 1;  ///< frame numbers
  double fps = 24;
  bool linear = false;       ///< colours are scene-linear; otherwise display values, shown as they are
  bool velocity = true;      ///< the frames hold a velocity grid
  Vec3 background{1, 1, 1};  ///< colour the model was trained before, display values
};

/// Text of a Python script that imports frame_0001.vdb and so on into Blender 3.4 or newer and sets up what makes
/// Cycles show the radiance field itself: emission and absorption, both driven by the density; velocity in units per
/// second; the view transform. Run as `blender -P load_in_blender.py`, or with `-b ... -- --render out.exr --frame 5
/// --camera camera.json`.
std::string blender_script(const BlenderSequence& sequence);

}  // namespace splinevox
