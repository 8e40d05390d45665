// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "splinevox/core/vec3.hpp"
#include "splinevox/data/scene.hpp"

namespace splinevox {

/// True surface points that one test picture shows, at pixels away from silhouettes.
struct SurfaceFrame {
  double time = 0;             ///< model time of the picture
  std::vector<Vec3> position;  ///< [points] where the surface point is now, scene units
  std::vector<Vec3> rest;      ///< [points] where it is at rest: the same for one surface point at all times
};

/// Reads the motion ground truth of a data set: `truth/FRAME_0000.exr` beside the pictures of a split, with
/// layers `position` and `rest` (three channels each, 0 where nothing is hit), one point sample per pixel.
/// Pixels with an empty neighbour, or with one more than `jump` (scene units) away now or at rest, are left
/// out: renderers blend both sides of an edge. Throws Error (Fault::input) naming the file that is absent,
/// damaged, lacks a layer, or whose points the view's camera sees elsewhere than at their pixels: splits
/// often name their pictures alike, and truth is kept for one of them.
std::vector<SurfaceFrame> read_truth(const std::string& dataset, const Split& split, float jump);

}  // namespace splinevox
