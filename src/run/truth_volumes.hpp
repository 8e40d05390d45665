// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "splinevox/core/camera.hpp"
#include "splinevox/core/vec3.hpp"
#include "splinevox/data/synth.hpp"

namespace splinevox::run {

/// True densities of a scene over time, on one lattice: voxel ijk is at origin + spacing * ijk and has its
/// value there. Outside of the voxels is nothing.
struct TruthVolumes {
  struct Moment {
    std::string file;
    double time = 0;  ///< of the model, [0, 1]
  };
  std::string folder;
  std::string grid = "density";  ///< in a .vdb
  Vec3d origin{};                ///< of voxel 0, scene units
  double spacing = 0;            ///< between voxels, scene units
  Int3 size{};                   ///< voxels per axis
  std::vector<Moment> moments;   ///< by time
  std::vector<std::string> notes;

  /// The box that the voxels fill: half a voxel around the outermost.
  Vec3d lo() const { return origin - 0.5 * spacing * Vec3d{1, 1, 1}; }
  Vec3d hi() const { return lo() + spacing * cast<double>(size); }
  std::size_t voxels() const { return std::size_t(size.x) * size.y * size.z; }
};

/// Finds what a folder has: truth.json and the volumes that it names; or else .vdb files, or .npz files with
/// arrays `density` [x, y, z], `voxel` (edge) and `origin` (place of voxel 0). Those without truth.json are
/// in the order of their names and spread evenly over all time, which a note says; the lattice is that of the
/// first, as large as all need.
/// @param time_map  from the times of truth.json to the model's
/// @param part      the model is of a part of the time: volumes outside it are left out, which a note says
/// Throws Error (Fault::input): no such folder, nothing in it, a field that is absent or wrong, a time
/// outside the model's, of all where it is of a part.
TruthVolumes open_truth_volumes(const std::string& folder, const TimeMap& time_map, bool part = false);

/// A moment's densities on the lattice [x][y][z], extinction per scene unit: as stored, or interpolated
/// trilinearly where the file has another lattice. Throws Error (Fault::input): no such grid, a number that
/// is negative or not finite.
std::vector<float> read_truth_volume(const TruthVolumes& truth, std::size_t moment);

/// The volumes of a built-in scene with gas: `folder`/volume_0001.vdb and so on, and truth.json, last.
/// @param times  in [0, 1]. Throws Error (Fault::output). @pre scene.has_gas()
void write_truth_volumes(const std::string& folder, const SynthScene& scene,
                         const std::vector<double>& times);

}  // namespace splinevox::run
