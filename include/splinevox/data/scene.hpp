// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "splinevox/core/camera.hpp"
#include "splinevox/core/image.hpp"
#include "splinevox/core/vec3.hpp"

namespace splinevox {

/// One posed picture. `time` is mapped by the train split's TimeMap: in [0, 1] on the train split,
/// possibly outside on others.
struct Frame {
  std::string name;  ///< file name without folder and extension, as reports show it
  Camera camera;
  double time = 0;
  Picture image;
};

struct Split {
  std::string name;  ///< "train", "val" or "test"
  std::vector<Frame> frames;
};

/// A data set, read and validated once; const from there on.
struct Dataset {
  std::string path;
  std::vector<Split> splits;  ///< those that exist on disk, train first
  TimeMap time_map;
  bool has_alpha = false;  ///< any training pixel with alpha < 1 (any pixel read, if train was not)
  int downscale = 1;
  std::uint64_t fingerprint = 0;  ///< hash of lenses, poses, times and pixels of train; 0 if not read
  std::vector<std::string>
      notes;           ///< what is odd about it or was guessed, one line each, for `info` and the log
  std::string format;  ///< the layout it was recognised as: a name of dataset_formats()
  std::optional<Box> box =
      {};  ///< where the scene lies, from its points or depth bounds, if the data says; scene units

  const Split* find(const std::string& split) const {
    for (const Split& s : splits)
      if (s.name == split) return &s;
    return nullptr;
  }
};

struct LoadOptions {
  int downscale = 1;                       ///< KxK blocks of the stored straight RGBA are averaged, >= 1
  std::vector<std::string> splits = {};    ///< which to read; empty = all that exist
  std::vector<std::string> if_there = {};  ///< which to read beside them where they exist
  std::optional<TimeMap> time_map = {};    ///< the run's map; absent = take it from the train split
  bool films = true;  ///< false: frames of films are measured, not decoded; they have no picture
};

/// The layouts that are recognised, in the order in which a folder is tried.
std::vector<std::string> dataset_formats();

/// Reads a data set folder of any layout of docs/data.md, recognised by what lies in it, checked once and
/// completely; nothing is returned of a set with a fault. Where the data names no test split, every eighth
/// picture is one.
///
/// Times: a train split within [0, 1] is taken as it is, any other has its range mapped to [0, 1], and the
/// same map serves every split. A split without any 'time' gets index / (n - 1). If train is not asked for
/// and options give no map, its times are read for the map, its pictures are not. Throws Error (Fault::input)
/// naming file, frame and field; of several bad pictures always the first.
Dataset load_dataset(const std::string& path, const LoadOptions& options = {});

/// Called after every finished picture, from one thread.
using ConvertProgress = std::function<void(int done, int total)>;

/// Writes a data set of any layout as a D-NeRF folder: transforms_{train,val,test}.json and pictures, which
/// are copied byte for byte where they are files. What D-NeRF's own files cannot say stands in further fields
/// that load_dataset reads: lenses per frame, distortion, the box. Times and cameras are those of the source
/// to the last bit of a double.
///
/// The transforms files are written last. Throws Error: Fault::input as load_dataset, or if `folder` exists
/// and is not empty; Fault::output.
/// @param shift  added to every position, scene units: models hold positions as floats, so a scene in
/// coordinates of a map must come nearer
///               to the origin first (numerics H14). Stands in the files as `shift`.
void convert_dataset(const std::string& path, const std::string& folder, const ConvertProgress& progress = {},
                     const Vec3d& shift = {});

}  // namespace splinevox
