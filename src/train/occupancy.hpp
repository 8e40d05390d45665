// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "render/active_rows.hpp"
#include "render/occupancy.hpp"
#include "train/setting.hpp"

namespace splinevox {

struct Volume;

/// Where matter is in each training frame. Frames of one moment share a grid, and where nothing moves all do.
struct FrameOccupancy {
  std::vector<BitGrid> grids;          ///< none: nothing is known yet
  std::vector<std::int32_t> of_frame;  ///< which of them, [frames]
};

/// Where matter is, to which rays and motion confine themselves.
struct Occupancy {
  BitGrid hull;           ///< over the box: where the scene can be at all
  FrameOccupancy frames;  ///< without grids the hull is all
  ActiveRows active;      ///< rows of the finest motion level

  /// What rays look into.
  std::span<const BitGrid> grids() const {
    return frames.grids.empty() ? std::span<const BitGrid>(&hull, 1) : frames.grids;
  }
  /// Which of them in a training frame.
  int grid_of(int frame) const { return frames.grids.empty() ? 0 : frames.of_frame[std::size_t(frame)]; }
  /// Cells that are occupied at any time.
  BitGrid ever() const;
};

/// The times that are trained (SamplingConfig::window). Until that is all of them nothing may be taken to be
/// empty for good.
struct TimeWindow {
  std::span<const int> frames;  ///< in order of time
  bool whole;                   ///< all times are
};

/// Of a long sequence this many moments are looked at, evenly.
inline constexpr std::size_t kMostOccupancyLooks = 256;
/// Grids that a sequence of so many frames has at most: of each look, between two of them, and of the times
/// before and after those that are trained.
inline std::size_t most_occupancies(std::size_t frames) {
  return (frames > kMostOccupancyLooks ? 2 * kMostOccupancyLooks - 1 : frames) + 2;
}

/// The occupancies of the training frames for the volume as it is.
FrameOccupancy frame_occupancies(const Setting& setting, const Volume& volume, const TimeWindow& window,
                                 float alpha);
/// Makes the occupancy anew, and what follows from it.
void refresh_occupancy(const Setting& setting, Volume& volume, const TimeWindow& window);
/// The cells near which motion is stored.
BitGrid motion_cells(const Volume& volume, const TimeWindow& window);
/// What follows from the finest level's lattice: the rows that move, the sum of the levels, the active rows.
void fit_motion(const Setting& setting, Volume& volume);

/// Shrinks the box, and every lattice with it, to where the model has matter at some training time. The
/// occupancy must be refreshed after it.
void tighten_box(const Setting& setting, Volume& volume, const TimeWindow& window);

/// Empties the canonical cells of a model that the occupancy calls empty, or would: training never samples
/// what it skips, be it outside the hull, so leftovers of the first fog would be visible in a picture. Bricks
/// in which nothing is left are pruned.
void clear_skipped(const Setting& setting, VoxelModel& model);

}  // namespace splinevox
