// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "splinevox/core/camera.hpp"
#include "splinevox/data/scene.hpp"
#include "splinevox/field/model.hpp"
#include "splinevox/io/model_vdb.hpp"
#include "splinevox/train/config.hpp"

namespace splinevox::run {

/// What a run remembers beside its configuration: the [record] table of config.toml.
struct RunRecord {
  std::string version;  ///< of the program that made the run
  std::string compiler;
  std::string dataset;            ///< absolute path
  std::uint64_t fingerprint = 0;  ///< of the training data
  TimeMap time_map;
  DatasetRules rules;  ///< how the data was understood
  /// The largest angle between two training views of the scene, degrees; below kLeastParallax its depth is
  /// not determined. Absent in runs of before.
  std::optional<double> parallax = {};
};

/// A run as eval, render and report read it: the folder that `splinevox train` or `edit` made.
struct Run {
  std::string path;
  Config config;  ///< as it was trained, with what was settled before (train/prepare.hpp)
  RunRecord record;
  VoxelModel model;
  ModelNotes notes;  ///< kept with the model

  Vec3 background() const { return model.background.color; }
};

/// Throws Error (input) if `path` is not the folder of a run with a saved model.
void check_run(const std::string& path);

/// Reads a run. Throws Error (input).
Run open_run(const std::string& path);

/// What the options of a verb may change about a run.
struct Otherwise {
  std::optional<int> downscale;
  std::optional<std::string> background;  ///< "white", "black" or "R,G,B" in 0..1
  std::optional<std::string> masks;       ///< as DatasetRules::masks
  bool any() const { return downscale || background || masks; }
};
/// open_run, changed accordingly. Throws Error (input).
Run open_run(const std::string& path, const Otherwise& otherwise);

/// How much memory the pictures of a verb may take, and where they are if that is not enough.
struct PictureRoom {
  std::string memory;  ///< as "6G"; empty: what the machine or container leaves the process
  std::string cache;   ///< folder; empty: LoadOptions::cache
};

/// Whether the pictures of a split are decoded.
enum class Pixels {
  read,
  left_out  ///< only the headers are read: for who wants cameras and times alone
};

/// The run's own pictures of one split, or those of `dataset` if not empty, with the run's downscale, time
/// map and rules. Masks that are not used otherwise are Frame::inside. Throws Error (input); also if pictures
/// of another split than train were trained on, as where the data set has changed since. Where its own lists
/// have a picture for both there is a note.
Dataset open_split(const Run& run, const std::string& dataset, const std::string& split,
                   const PictureRoom& room = {}, Pixels pixels = Pixels::read);

/// The run's own training pictures, or those of `dataset` if not empty, if they are of one moving camera
/// (train/effects/film.hpp); none if they are not, or if the data set has none. Only then are pixels read.
/// Throws Error (input).
std::optional<Dataset> open_film(const Run& run, const std::string& dataset, const PictureRoom& room = {});

}  // namespace splinevox::run
