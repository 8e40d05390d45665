// SPDX-License-Identifier: Apache-2.0
// Where matter is, to which rays and motion confine themselves, and where it is for no reason.
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/parallel.hpp"
#include "field/lattice/slice.hpp"
#include "train/state.hpp"

namespace splinevox {
namespace {

/// Rays per pixel of all training pictures after which what none has shown is not there to be seen: what is
/// there is wider than a pixel and in more than one picture.
constexpr double kEnoughRays = 0.05;

/// Times at most whose occupancy is made by looking.
constexpr std::size_t kMostLooks = 256;

/// At a time not yet trained, matter may be a 16th of the box away from where the nearest trained one has it.
constexpr int kRoom = 16;

}  // namespace

BitGrid Trainer::State::occupied_ever() const {
  BitGrid all = occupancy.front();
  for (const BitGrid& frame : occupancy) all |= frame;
  return all;
}

BitGrid Trainer::State::swept() const {
  if (awake.cells() > 0) return dilate(awake);
  return occupancy.empty() || growing() ? bounds.hull : dilate(occupied_ever());
}

void Trainer::State::find_active() {
  if (levels.empty()) return;
  const Topology& t = *levels.back().topology;
  const BitGrid cells = occupancy.empty() ? bounds.hull : occupied_ever();
  active.rows = rows_near(t, cells, reach_of_vertex(t.lattice));
  for (std::size_t b = 0; b < awake_rows.size(); ++b) active.rows[b] &= awake_rows[b];
  active.rows[0].set_all();
}

std::vector<BitGrid> Trainer::State::frame_occupancies(float alpha) const {
  const OccupancyPyramid canonical(
      canonical_occupancy(model, config.sampling.occupancy_cells, alpha, model.step), active.reach);
  if (!model.motion.moves()) return {frame_occupancy(model, {}, canonical)};
  const std::span<const int> trained = sampler.window(progress);
  // Of a long sequence only some times are looked at, and a frame between two of them has what either has.
  const std::size_t looks = std::min(trained.size(), kMostLooks);
  const auto rank = [&](std::size_t look) {
    return looks > 1 ? look * (trained.size() - 1) / (looks - 1) : 0;
  };
  std::vector<BitGrid> seen(looks), out(train.frames.size());
  constexpr std::size_t kShare = 8;  // looks that share the memory of a slice
  parallel_for(int((looks + kShare - 1) / kShare), [&](int group) {
    MotionSlice slice;
    for (std::size_t i = group * kShare; i < std::min(looks, (group + 1) * kShare); ++i) {
      fill_slice(model.motion, stored_weights(model.motion, train.frames[trained[rank(i)]].time), slice,
                 awake_rows);
      seen[i] = frame_occupancy(model, slice, canonical);
    }
  });
  for (std::size_t i = 0; i < looks; ++i) {
    out[trained[rank(i)]] = seen[i];
    for (std::size_t r = rank(i) + 1; i + 1 < looks && r < rank(i + 1); ++r)
      (out[trained[r]] = seen[i]) |= seen[i + 1];
  }
  if (trained.size() == out.size()) return out;
  // Times yet to be trained: what the nearest one trained holds, with room to move.
  BitGrid before = out[trained.front()], after = out[trained.back()];
  for (int cells = config.sampling.occupancy_cells / kRoom; cells > 0; --cells)
    before = dilate(before), after = dilate(after);
  const double first = train.frames[trained.front()].time;
  for (std::size_t f = 0; f < out.size(); ++f)
    if (out[f].bits.empty()) out[f] = train.frames[f].time < first ? before : after;
  return out;
}

void Trainer::State::refresh_occupancy() {
  bring_home();
  collapse_levels({});
  occupancy = frame_occupancies(config.sampling.occupancy_alpha);
  // A time at which nothing is left would never be looked at again: start it over from the hull.
  for (BitGrid& frame : occupancy)
    if (frame.count() == 0) frame = bounds.hull;
  find_active();
  uploaded = false;
}

void Trainer::State::clear_skipped(VoxelModel& out) const {
  if (occupancy.empty()) return;  // nothing was skipped
  const BitGrid canonical =
      canonical_occupancy(out, config.sampling.occupancy_cells, config.sampling.occupancy_alpha, out.step);
  if (canonical.count() == 0) return;
  Channels& raw = out.radiance.raw;
  const Topology& t = *raw.topology;
  parallel_for(t.brick_count(), [&](int index) {
    for (int i = 0; i < kBrickRows; ++i) {
      const Vec3 x = t.position(index + 1, i);
      if (!canonical.test(canonical.index(canonical.cell_of(x))))
        raw.row(std::size_t(index + 1) * kBrickRows + i)[0] = kEmptyDensity;
    }
  });
  drop_empty(raw);
}

bool Trainer::State::drop_empty(Channels& raw, std::initializer_list<AlignedVector<float>*> beside) {
  constexpr float kRounding = 1e-3f;  // of what has been resampled
  const std::vector<std::int32_t> kept = bricks_above(raw, kEmptyDensity + kRounding);
  if (kept.empty() || int(kept.size()) == raw.topology->brick_count()) return false;
  keep_rows(kept, raw.width, raw.values);
  for (AlignedVector<float>* rows : beside) keep_rows(kept, raw.width, *rows);
  raw.topology = keep_bricks(*raw.topology, kept);
  return true;
}

void Trainer::State::forget_seen() {
  if (!config.grid.empty_start.empty())
    radiance.gradient.seen.assign(model.radiance.raw.topology->bricks.size(), {});
  rays_shown = 0;
}

bool Trainer::State::empty_unseen() {
  double pixels = 0;
  for (const Frame& f : train.frames) pixels += double(f.camera.width) * f.camera.height;
  if (growing() || double(rays_shown) < kEnoughRays * pixels) return forget_seen(), false;
  Channels& raw = model.radiance.raw;
  parallel_for(raw.topology->brick_count(), [&](int index) {
    const int brick = index + 1;
    for (int i = 0; i < kBrickRows; ++i) {
      if (radiance.gradient.seen[brick].test(i)) continue;
      const std::size_t density = (std::size_t(brick) * kBrickRows + i) * raw.width;
      raw.values[density] = kEmptyDensity;
      radiance.m[density] = radiance.v[density] = 0;
    }
  });
  const bool dropped = drop_empty(raw, {&radiance.m, &radiance.v});
  if (dropped) {
    for (AlignedVector<float>* rows : {&raw.values, &radiance.m, &radiance.v}) rows->shrink_to_fit();
    radiance.resize(raw);
  }
  forget_seen();
  return dropped;
}

}  // namespace splinevox
