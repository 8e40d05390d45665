// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "splinevox/core/file_digest.hpp"
#include "splinevox/field/edit.hpp"
#include "splinevox/io/frame_range.hpp"

namespace splinevox {

/// One of `count` shares of a list that as many processes work through: every count-th piece, from `index`
/// on; 0 <= index < count.
struct Share {
  int index = 0, count = 1;
  bool whole() const { return count == 1; }
  bool holds(std::int64_t piece) const { return piece % count == index; }
};

/// Points that the matter carries through all frames.
struct ExportPoints {
  int chosen = 0;                ///< how many of the first frame's surface; 0: those that follow
  std::vector<Vec3> position;    ///< [points] scene units
  std::vector<double> time;      ///< [points] model time at which it is there; empty: that of the first frame
  std::vector<std::int64_t> id;  ///< [points]; empty: 0, 1, ...

  bool any() const { return chosen > 0 || !position.empty(); }
};

/// Settings of an animated VDB sequence.
struct ExportOptions : FrameRange {
  std::string profile = "blender";  ///< see export_profiles()
  double voxel_size = 0;            ///< scene units; 0: the radiance lattice's own
  bool half = true;                 ///< 16-bit floats
  std::string bake_view =
      "mean";       ///< colour per voxel: "mean" over all directions, "none" (positional), "dir=x,y,z"
  bool sh = false;  ///< the harmonics of the view rescale as grids sh0, sh1, ...; colour is then positional
  bool flame = false;  ///< what a voxel gives off as one number, grid flame
  std::string colorspace =
      "display";            ///< "display": values as in the pictures; "linear": decoded from sRGB per voxel
  double shutter = 0.5;     ///< share of a frame the shutter is open, [0, 2]: how far velocity is padded
  double min_alpha = 1e-3;  ///< voxels below this opacity over one voxel are dropped, (0, 1)
  bool controls = false;    ///< motion.vdb beside the sequence
  bool mesh = false;        ///< a coloured surface
  std::string mesh_format = "auto";  ///< "ply" or "obj": one of every frame beside it; "glb" or "usd": one of
                                     ///< the first frame, which the matter carries through all of them;
                                     ///< "auto": usd in the profile usd, else ply
  ExportPoints points;               ///< points.usda
  double mesh_alpha = 0.25;          ///< it runs where a voxel has this opacity, (min_alpha, 1)
  std::optional<int>
      clusters;  ///< files of their own for each part that moves alike: how many, 2..16, 0 to choose
  int frames_at_once =
      0;        ///< frames in the making at a time; 0: as many as there are threads and memory is free
  Share share;  ///< of the frames; a share ends without a manifest, and an export of the whole takes its
                ///< frames over
  bool resume = true;  ///< keep frames that an earlier export with the same model and settings finished;
                       ///< false: write them again, in place of those of an export with other settings, too
  std::string run;     ///< where the model came from, for the manifest; empty: not said

  std::string mesh_kind() const {
    return mesh_format != "auto" ? mesh_format : profile == "usd" ? "usd" : "ply";
  }
  bool mesh_carried() const { return mesh && (mesh_kind() == "glb" || mesh_kind() == "usd"); }
  bool mesh_per_frame() const { return mesh && !mesh_carried(); }
};

/// One file that a manifest vouches for.
struct ManifestFile {
  std::string name;  ///< relative to the manifest's folder, '/' between parts, never upwards
  FileDigest digest;
  std::map<std::string, double> figures;  ///< anything countable about it: active voxels, time, frame
};

/// One written (or kept) frame.
struct ExportedFrame {
  int frame = 0;
  double time = 0;    ///< model time
  ManifestFile file;  ///< name, size, hash, and figures: density_voxels, velocity_voxels, max_speed, ...
  std::vector<ManifestFile> beside;         ///< what else belongs to the frame: meshes, the other clusters
  bool kept = false;                        ///< it was there already
  double seconds = 0, seconds_writing = 0;  ///< wall time of the frame, and of that for writing its files
  double cpu_writing = 0;  ///< processor time for writing them: OpenVDB's trees and writer, checksums
};

/// Called after every frame, in their order, with how many are done. Return false to stop: no more frames are
/// begun, those in the making are ended and reported; what is written stays and is kept by a later run.
using ExportProgress = std::function<bool(const ExportedFrame& frame, int done, int total)>;

struct ExportResult {
  std::vector<ExportedFrame> frames;
  std::vector<MotionClusters::Cluster> clusters;  ///< if the options ask for them
  std::vector<ManifestFile>
      carried;  ///< moving meshes and points, with figures: frames, vertices or points, untracked_share, ...
  std::vector<int> in_folder;  ///< numbers of all frames of the sequence, those of earlier exports included
  std::vector<std::string>
      others;  ///< names of frames in the folder that an earlier export left and this sequence does not have
  bool finished = false;  ///< all frames of the share are written, and of the whole the manifest
};

/// Names of the profiles, for help texts and messages.
std::vector<std::string> export_profiles();

/// Throws Error (Fault::input) naming the option, its range and what was given.
void validate(const ExportOptions& options);

/// Writes `folder`/frame_0001.vdb and so on, then load_in_blender.py (profile blender) or sequence.usda (usd)
/// and, last, manifest.json.
///
/// Each frame holds, on one lattice and with one transform,
///   density   sigma(x + Delta(x, t)): extinction per scene unit;
///   color     Vec3s, display-referred unless told otherwise, one voxel beyond the density so that
///   interpolation at the rim
///             does not darken;
///   velocity  Vec3s, scene units per second, v = -(I + grad Delta)^-1 dDelta/dt (math/velocity.hpp),
///   continued beyond the
///             density, from each place by |v| * shutter / (2 fps) there plus a voxel, at most 64 voxels,
///             because a renderer asks for it where the ray is; absent if the model does not move, and for
///             unreal;
/// with background 0, under the profile's names; with `mesh`, beside it mesh_0001.ply and so on: the surface
/// where density is -log(1 - mesh_alpha) / voxel size, in scene units (no profile shifts it), with the colour
/// there.
///  Frame f shows model time (f - at) / (fps * seconds), in [0, 1]; see FrameRange.
///  A folder holds one sequence: frames of the same settings (FrameRange's first and last are none) are added
///  to those that are there, and an export with others is refused unless `resume` is off; then it removes
///  what those had beside their frames and it does not write. An export that would overwrite a file which no
///  export lists is refused as well. In the folder of an export a .vdb is ours without a list if its metadata
///  name splinevox as the creator, and files of other kinds are: one that was killed may have just finished
///  them.
/// With `flame`, a float grid flame on the density's voxels: the luminance of the colour beside it (0.2126 r
/// + 0.7152 g + 0.0722 b, of display values unless told otherwise) times density, per scene unit. With `sh`,
/// color is the positional colour and sh0, sh1, ... hold three coefficients each of q = sum_j sh_j Y_j(d)
/// (math/sh.hpp): what is seen along d is color * (1 - sigmoid(q) / 2). With `clusters`,
/// cluster_0_frame_0001.vdb and so on instead: the density of one part each. They add up to the whole, voxel
/// by voxel, because what is split is the frame that was baked. With `controls`, motion.vdb holds the model's
/// control points and rigidity as grids, in no profile's names. With a `share` of the frames only these are
/// written, by as many processes as like side by side into one folder, each with a list of its own
/// (partial_manifests); then one export of the whole keeps what they wrote, writes what is missing, and the
/// rest. The same model and options give the same bytes for any number of threads, of shares and of frames at
/// once. Every file is written atomically. Throws Error: Fault::input for bad options, Fault::output if a
/// file cannot be written.
ExportResult export_vdb(const VoxelModel& model, const std::string& folder, const ExportOptions& options,
                        const ExportProgress& progress = {});

}  // namespace splinevox
