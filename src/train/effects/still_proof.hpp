// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "splinevox/core/image.hpp"
#include "splinevox/train/effects.hpp"
#include "train/effects/halves.hpp"
#include "train/still/still_cameras.hpp"

namespace splinevox {

/// The evidence of a split, and what it is read from.
struct StillProof {
  std::vector<StillCamera> cameras;
  std::optional<StillEvidence> evidence;  ///< none: no camera stands still

  bool says(StillVerdict verdict) const { return evidence && evidence->verdict == verdict; }
};
/// @param unit  of brightness (train/start.hpp)
StillProof prove(const Split& train, float unit = 1);

/// 1 where a held-out picture differs from its camera's still picture, or is beside such a pixel; 0
/// everywhere in a picture of a camera that does not stand still. Each of the size of its picture, one
/// channel.
std::vector<Image> changing_pixels(const StillProof& proof, const Halves& halves);

}  // namespace splinevox
