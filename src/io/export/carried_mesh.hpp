// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "io/export/carried_points.hpp"
#include "io/export/export_mesh.hpp"
#include "splinevox/field/model.hpp"

namespace splinevox {

/// A surface of one topology that the matter carries along.
struct CarriedMesh {
  ColorMesh mesh;                                     ///< of one frame
  std::vector<std::vector<Vec3>> places, velocities;  ///< [frames][vertices], scene units, and those a second
  double untracked = 0;  ///< share of the places that no way leads to: they go with their neighbours
};

/// Displaces vertices that are not `known` as the mean of their known neighbours, from those outwards; pieces
/// without any stay where they are. @param places  [vertices] of another frame, scene units
void follow_neighbours(const ColorMesh& mesh, const std::vector<bool>& known, std::vector<Vec3>& places);

/// Carries the vertices of a frame's surface to other frames (field/sample.hpp, track). Vertices whose way is
/// not to be trusted follow their neighbours.
/// @param from  model time of the surface  @param frames  without rates no velocities are worked out
CarriedMesh carry_mesh(const VoxelModel& model, ColorMesh mesh, double from, const FrameTimes& frames);

/// How it is played.
struct MeshPlay {
  std::string name;                   ///< of the object
  std::vector<std::string> frames{};  ///< [frames] names
  std::vector<double> seconds{};      ///< [frames] when each is shown, rising
  float still = 0;                    ///< scene units: what moves by less has no target of its own
};

/// The mesh as a glTF 2.0 binary: Y is up, colours are linear and unlit (KHR_materials_unlit), each frame is
/// a morph target that holds only vertices which it displaces, and one animation plays them, straight in
/// between. Throws Error (Fault::input) where it would have more than 4 GiB.
std::string glb_bytes(const CarriedMesh& carried, const MeshPlay& play);

}  // namespace splinevox
