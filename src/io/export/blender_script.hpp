// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "splinevox/core/vec3.hpp"

namespace splinevox {

/// What load_in_blender.py has to know about the sequence beside it.
struct BlenderSequence {
  int first = 1, last = 1;  ///< frame numbers
  double fps = 24;
  bool linear = false;       ///< colours are scene-linear; otherwise display values, shown as they are
  bool velocity = true;      ///< the frames hold a velocity grid
  Vec3 background{1, 1, 1};  ///< colour the model was trained before, display values
  std::vector<std::string> prefixes{""};  ///< of the frames' names, one for each object
  int sh_order = -1;                      ///< the frames hold sh0, sh1, ... up to this order; -1: they do not
};

/// Text of a Python script that imports frame_0001.vdb and so on, one object per prefix, into Blender 3.4 or
/// newer and sets up what makes Cycles show the radiance field itself: emission and absorption, both driven
/// by the density; velocity in units per second; the view transform; with harmonics, nodes that evaluate them
/// for the direction of sight. Run as `blender -P load_in_blender.py`, or with `-b ... -- --render out.exr
/// --frame 5 --camera camera.json`.
std::string blender_script(const BlenderSequence& sequence);

/// A file of src/io/export/hosts, as it was when the program was built. @pre it is there.
std::string_view host_script(std::string_view name);

}  // namespace splinevox
