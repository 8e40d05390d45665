// SPDX-License-Identifier: Apache-2.0
#include "train/occupancy.hpp"

#include <algorithm>
#include <cstddef>

#include "core/parallel.hpp"
#include "field/lattice/slice.hpp"
#include "train/by_time.hpp"
#include "train/refine.hpp"
#include "train/start.hpp"
#include "train/volume.hpp"

namespace splinevox {
namespace {

/// At a time not yet trained, matter may be a 16th of the box away from where the nearest trained one has it.
constexpr int kRoom = 16;

/// Share of the occupied cells below which a part on its own does not hold the box open.
constexpr float kSmallPart = 1 / 300.0f;

void find_active(Volume& volume) {
  const std::vector<Channels>& levels = volume.lattices.levels;
  if (levels.empty()) return;
  Occupancy& o = volume.occupancy;
  const Topology& t = *levels.back().topology;
  o.active.rows = rows_near(t, o.ever(), reach_of_vertex(t.lattice));
  for (std::size_t b = 0; b < volume.moving.rows.size(); ++b) o.active.rows[b] &= volume.moving.rows[b];
  o.active.rows[0].set_all();
}

void find_moving_rows(const Setting& setting, Volume& volume) {
  const std::vector<Channels>& levels = volume.lattices.levels;
  MovingPart& moving = volume.moving;
  ActiveRows& active = volume.occupancy.active;
  moving.rows.clear();
  active.reach = {};
  if (moving.cells.cells() == 0 || levels.empty()) return;
  const Topology& t = *levels.back().topology;
  moving.rows = rows_near(t, moving.cells, extent_of_vertex(t.lattice));
  active.reach =
      reach_of(t, moving.rows, BitGrid(volume.lattices.model.box, setting.config.sampling.occupancy_cells));
}

}  // namespace

BitGrid Occupancy::ever() const {
  if (frames.grids.empty()) return hull;
  BitGrid all = frames.grids.front();
  for (const BitGrid& grid : frames.grids) all |= grid;
  return all;
}

BitGrid motion_cells(const Volume& volume, const TimeWindow& window) {
  if (volume.moving.cells.cells() > 0) return dilate(volume.moving.cells);
  const Occupancy& o = volume.occupancy;
  return o.frames.grids.empty() || !window.whole ? o.hull : dilate(o.ever());
}

FrameOccupancy frame_occupancies(const Setting& setting, const Volume& volume, const TimeWindow& window,
                                 float alpha) {
  const VoxelModel& model = volume.lattices.model;
  const SamplingConfig& sampling = setting.config.sampling;
  const std::vector<Frame>& views = setting.train.frames;
  const OccupancyPyramid canonical(model, sampling.occupancy_cells, alpha, model.step,
                                   volume.occupancy.active.reach);
  FrameOccupancy out;
  out.of_frame.resize(views.size());
  if (!model.motion.moves() && !canonical.presence) {
    out.grids.push_back(frame_occupancy(model, {}, canonical));
    return out;
  }
  const auto time_of = [&](int frame) { return volume.cameras.time_of(views[std::size_t(frame)]); };
  std::vector<int> trained(window.frames.begin(), window.frames.end());
  std::stable_sort(trained.begin(), trained.end(),  // of cameras that are late in the order of their moments
                   [&](int a, int b) { return time_of(a) < time_of(b); });
  // Of a long sequence only some times are computed, and a moment between two of them has what either has,
  // and more around it the further apart they are.
  const std::vector<std::size_t> moments = starts_of_moments(trained, time_of);
  const std::size_t looks = std::min(moments.size(), kMostOccupancyLooks);
  const auto rank = [&](std::size_t look) {
    return looks > 1 ? look * (moments.size() - 1) / (looks - 1) : 0;
  };
  const auto put = [&](std::size_t moment, std::size_t grid) {
    const std::size_t end = moment + 1 < moments.size() ? moments[moment + 1] : trained.size();
    for (std::size_t i = moments[moment]; i < end; ++i)
      out.of_frame[std::size_t(trained[i])] = std::int32_t(grid);
  };
  out.grids.resize(looks);
  constexpr std::size_t kShare = 8;  // looks that share the memory of a slice
  parallel_for(int((looks + kShare - 1) / kShare), [&](int group) {
    MotionSlice slice;
    for (std::size_t i = group * kShare; i < std::min(looks, (group + 1) * kShare); ++i) {
      const double time = time_of(trained[moments[rank(i)]]);
      fill_slice(model.motion, stored_weights(model.motion, time), slice, volume.moving.rows);
      out.grids[i] = frame_occupancy(model, slice, canonical);
    }
  });
  for (std::size_t i = 0; i < looks; ++i) {
    put(rank(i), i);
    if (i + 1 == looks || rank(i) + 1 == rank(i + 1)) continue;
    for (std::size_t m = rank(i) + 1; m < rank(i + 1); ++m) put(m, out.grids.size());
    BitGrid between = out.grids[i];
    between |= out.grids[i + 1];
    for (std::size_t gap = rank(i + 1) - rank(i); gap > 1; gap /= 2)
      between = dilate(between);  // what is fast is on its way
    out.grids.push_back(std::move(between));
  }
  if (trained.size() == views.size()) return out;
  // Times yet to be trained: what the nearest one trained holds, with room to move.
  BitGrid before = out.grids.front(), after = out.grids[looks - 1];
  for (int cells = sampling.occupancy_cells / kRoom; cells > 0; --cells) {
    before = dilate(before);
    after = dilate(after);
  }
  std::vector<bool> known(views.size());
  for (const int f : trained) known[std::size_t(f)] = true;
  const double first = time_of(trained.front());
  const auto grids = std::int32_t(out.grids.size());
  for (std::size_t f = 0; f < views.size(); ++f)
    if (!known[f]) out.of_frame[f] = time_of(int(f)) < first ? grids : grids + 1;
  out.grids.push_back(std::move(before));
  out.grids.push_back(std::move(after));
  return out;
}

void refresh_occupancy(const Setting& setting, Volume& volume, const TimeWindow& window) {
  Occupancy& o = volume.occupancy;
  o.frames = frame_occupancies(setting, volume, window, setting.config.sampling.occupancy_alpha);
  // A time at which nothing is left would never be sampled again: start it over from the hull.
  for (BitGrid& grid : o.frames.grids)
    if (grid.count() == 0) grid = o.hull;
  find_active(volume);
}

void fit_motion(const Setting& setting, Volume& volume) {
  find_moving_rows(setting, volume);
  volume.lattices.sum_levels(volume.moving.rows);
  find_active(volume);
}

void tighten_box(const Setting& setting, Volume& volume, const TimeWindow& window) {
  const Config& config = setting.config;
  if (!config.grid.box.empty()) return;
  VoxelModel& model = volume.lattices.model;
  BitGrid kept =
      canonical_occupancy(model, config.sampling.occupancy_cells, config.grid.box_alpha, model.step);
  const FrameOccupancy frames = frame_occupancies(setting, volume, window, config.grid.box_alpha);
  for (const BitGrid& grid : frames.grids) kept |= grid;
  Box box = bounding_box(drop_small_parts(kept, kSmallPart), config.grid.box_margin);
  box.lo = max(box.lo, model.box.lo);
  box.hi = min(box.hi, model.box.hi);
  if (!holds_lattices(box, config.grid) || !tells_places_apart(box, config.grid)) return;
  const auto size = [](const Box& b) { return double(b.extent().x) * b.extent().y * b.extent().z; };
  if (size(box) > 0.9 * size(model.box)) return;

  BitGrid& hull = volume.occupancy.hull;
  const BitGrid old_hull = hull;
  hull = BitGrid(box, config.sampling.occupancy_cells);
  Int3 c;
  for (c.x = 0; c.x < hull.size.x; ++c.x)
    for (c.y = 0; c.y < hull.size.y; ++c.y)
      for (c.z = 0; c.z < hull.size.z; ++c.z)
        if (old_hull.test(old_hull.index(old_hull.cell_of(hull.center(c))))) hull.set(hull.index(c));
  model.box = box;
  if (volume.lattices.levels.empty()) return;
  const BitGrid near = volume.moving.cells.cells() > 0 ? motion_cells(volume, window) : dilate(hull);
  volume.lattices.put_on_levels(config.grid.motion, Channels(model.motion.levels[0]), near);
  fit_motion(setting, volume);
}

void clear_skipped(const Setting& setting, VoxelModel& model) {
  const SamplingConfig& sampling = setting.config.sampling;
  const BitGrid canonical =
      canonical_occupancy(model, sampling.occupancy_cells, sampling.occupancy_alpha, model.step);
  if (canonical.count() == 0) return;
  Channels& raw = model.radiance.raw;
  const Topology& t = *raw.topology;
  parallel_for(t.brick_count(), [&](int index) {
    for (int i = 0; i < kBrickRows; ++i) {
      const Vec3 x = t.position(index + 1, i);
      if (canonical.test(canonical.index(canonical.cell_of(x)))) continue;
      // Beside a large presence it may be emptier still.
      float& density = raw.row(std::size_t(index + 1) * kBrickRows + i)[0];
      density = std::min(density, kEmptyDensity);
    }
  });
  prune_empty(raw);
}

}  // namespace splinevox
