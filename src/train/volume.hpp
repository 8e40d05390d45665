// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "splinevox/train/cameras.hpp"
#include "train/archive.hpp"
#include "train/lattices.hpp"
#include "train/occupancy.hpp"

namespace splinevox {

/// Where motion is learned. The rest is frozen: it has none (bounds/freeze.hpp).
struct MovingPart {
  BitGrid cells;        ///< of the box; no cells: everywhere
  bool proved = false;  ///< cameras that stand still have settled them before the first step
  double share = 1;     ///< of what is visible, when motion was last frozen
  std::vector<RowMask>
      rows;  ///< rows of the finest level within reach of the cells, [bricks + 1]; empty: all
};

/// What is learned, and where it is looked for.
struct Volume {
  Lattices lattices;
  Occupancy occupancy;
  MovingPart moving;
  CameraFits cameras = {};  ///< of a rig of which something is learned

  /// Saves or restores it. Throws Error (input) where a restored one does not fit the setting; of one that
  /// does, rates, priors and the sum of the levels are still to be made.
  void archive(Archive& a, const Setting& setting);
};

/// Throws Error (input): a state of another configuration.
void check_fits(bool good);

}  // namespace splinevox
