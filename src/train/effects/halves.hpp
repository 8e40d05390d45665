// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "splinevox/data/scene.hpp"

namespace splinevox {

/// Training frames divided in two: those that the fits train on, and the held-out ones that compare them.
struct Halves {
  Split fitted, held_out;
  std::vector<int> held_out_frames;  ///< of the training split
  /// False where masks leave nothing of one of them.
  bool usable() const { return !fitted.frames.empty() && !held_out.frames.empty(); }
};

/// Frames of a split in order of time, as a sequence of its own: (time - start) / length.
struct Stretch {
  std::vector<int> frames;
  double start = 0, length = 1;
};

/// The middle 80 moments of a long sequence, of more than three times as many, with every picture of them;
/// none of a short one.
std::optional<Stretch> middle_stretch(const Split& train);

/// Every fifth frame is held out, or fewer of a long sequence. The fits train on the frames in between, or on
/// a share of them that is even in time. Of a rig both are of all its cameras in turn, of
/// more than 40 of that many, and three pictures of each are fitted at least. The question is
/// coarse, and every frame costs its hull and occupancy. Pictures are at most 128 pixels wide and high. Those
/// of which masks then leave nothing are left out.
Halves divide(const Split& train, const Stretch& stretch);

/// The same with whole cameras of a rig held out, one in five; not usable where it has fewer than five.
Halves divide_cameras(const Split& train);

/// Frames of a split as the fits take them, at most so many of each camera of a rig, evenly in its order.
Split some_of_each(const Split& train, int cameras, int most);

}  // namespace splinevox
