// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "splinevox/core/vec3.hpp"

namespace splinevox {

/// A grid that every frame holds, in the words of UsdVolOpenVDBAsset.
struct UsdField {
  std::string name;       ///< of the grid and of the field
  std::string data_type;  ///< fieldDataType: "float" or "float3"
  std::string role;       ///< vectorDataRoleHint: "None", "Color" or "Vector"
};

/// One object that moves. All have as many files.
struct UsdVolume {
  std::string name;                ///< "" if it is the only one
  std::vector<std::string> files;  ///< names of the frames, in the stage's own folder
};

/// A layer beside the stage that it shows.
struct UsdLayer {
  std::string file, name, type;  ///< in the stage's own folder; of its only prim; of that prim's schema
};

/// What a stage has to know about the sequence beside it.
struct UsdSequence {
  std::vector<int> frames;         ///< time code of each file, in order
  double fps = 24;                 ///< time codes per second
  std::vector<UsdVolume> volumes;  ///< at least one
  std::vector<UsdField> fields;
  std::vector<UsdLayer> layers{};
  Vec3 lo{}, hi{};  ///< a box around everything that is shown, scene units
};

/// The layer with a run's cameras.
inline constexpr const char* kCamerasUsd = "cameras.usda";

/// Text of a .usda stage with one Volume, /splinevox, whose OpenVDBAsset fields name one file per time code
/// (usdVol's schema). Several volumes (/splinevox/cluster_0), or a volume (/splinevox/volume) and
/// layers (/splinevox/mesh), lie below it. Z is up, a scene unit is a metre.
std::string usd_stage(const UsdSequence& sequence);

/// The same stage with the cameras' layer as a layer of its own, or without. @param stage  text of usd_stage
std::string with_cameras(std::string stage, bool shown);

}  // namespace splinevox
