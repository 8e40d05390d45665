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

/// What a stage has to know about the sequence beside it.
struct UsdSequence {
  std::vector<int> frames;         ///< time code of each file, in order
  double fps = 24;                 ///< time codes per second
  std::vector<UsdVolume> volumes;  ///< at least one
  std::vector<UsdField> fields;
  Vec3 lo{}, hi{};  ///< a box around everything that is shown, scene units
};

/// Text of a .usda stage with one Volume, /splinevox, or several below it (/splinevox/cluster_0), whose
/// OpenVDBAsset fields name one file per time code (usdVol's schema). Z is up, a scene unit is a metre.
std::string usd_stage(const UsdSequence& sequence);

}  // namespace splinevox
