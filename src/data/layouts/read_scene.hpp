// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "data/layouts/masks.hpp"
#include "data/layouts/raw_scene.hpp"
#include "splinevox/data/scene.hpp"

namespace splinevox::data {

/// A data set recognised and its cameras read, its pictures not yet looked for.
struct OpenScene {
  std::string format;
  RawScene scene;  ///< the splits that were asked for
  std::optional<RawSplit>
      train;  ///< the train split where it was not asked for but times must be mapped by it
  MaskUse mask_use = {};
  MaskSearch masks = {};
  std::size_t pictures = 0;  ///< of all splits in one list, as RawFrame::order counts them; 0: not known
};

/// Recognises a folder and reads the splits that options ask for. Throws Error (Fault::input).
OpenScene open_scene(const std::filesystem::path& folder, const LoadOptions& options);

}  // namespace splinevox::data
