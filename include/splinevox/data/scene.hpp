// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "splinevox/core/camera.hpp"
#include "splinevox/core/image.hpp"

namespace splinevox {

/// One posed picture. `time` is mapped by the train split's TimeMap: in [0, 1] on the train split,
/// possibly outside on others.
struct Frame {
  std::string name;  ///< file name without folder and extension, as reports show it
  Camera camera;
  double time = 0;
  Image16 image;
};

struct Split {
  std::string name;  ///< "train", "val" or "test"
  std::vector<Frame> frames;
};

/// A data set, read and validated once; const from there on.
struct Dataset {
  std::string path;
  std::vector<Split> splits;         ///< those that exist on disk, train first
  TimeMap time_map;
  bool has_alpha = false;            ///< any training pixel with alpha < 1
  int downscale = 1;
  std::uint64_t fingerprint = 0;     ///< hash of poses, times and pixels of the train split
  std::vector<std::string> notes;    ///< what is odd about it, one line each, for `info` and the log

  const Split* find(const std::string& split) const {
    for (const Split& s : splits)
      if (s.name == split) return &s;
    return nullptr;
  }
};

struct LoadOptions {
  int downscale = 1;                      ///< KxK blocks of the stored straight RGBA are averaged, >= 1
  std::vector<std::string> splits;        ///< which to read; empty = all that exist
  std::optional<TimeMap> time_map;        ///< the run's map; absent = take it from the train split
};

/// Reads a data set folder. The format is recognised by looking at it.
/// Throws Error (Fault::input) naming file, frame and field.
Dataset load_dataset(const std::string& path, const LoadOptions& options = {});

}  // namespace splinevox
