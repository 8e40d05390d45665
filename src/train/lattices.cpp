// SPDX-License-Identifier: Apache-2.0
#include "train/lattices.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "backend/host/level_sums.hpp"
#include "core/parallel.hpp"
#include "field/lattice/levels.hpp"
#include "math/activation.hpp"
#include "train/effects/effect_table.hpp"
#include "train/learn_background.hpp"
#include "train/learn_surroundings.hpp"
#include "train/rates.hpp"
#include "train/refine.hpp"

namespace splinevox {
namespace {

/// The cells whose centres the offset leads to one of a grid. Matter that is a cell wide with its margin
/// loses no more than some of that.
BitGrid moved(const BitGrid& grid, const Offset& offset) {
  BitGrid out = grid;
  std::fill(out.bits.begin(), out.bits.end(), 0u);
  for (std::size_t i = 0; i < grid.cells(); ++i) {
    const Vec3 x = grid.center(grid.cell_at(i));
    if (grid.test(grid.index(grid.cell_of(x + offset.at(x))))) out.set(i);
  }
  return out;
}

/// Density stays as it is, and so many times as much of it lies between raw values as far apart as before.
/// What is empty stays that (kEmptyDensity).
void steepen(RadianceField& radiance, float by) {
  DensityActivation& activation = radiance.activation;
  parallel_for(int(radiance.raw.topology->bricks.size()), [&](int b) {
    for (int i = 0; i < kBrickRows; ++i) {
      float& raw = radiance.raw.row(std::size_t(b) * kBrickRows + i)[0];
      raw = raw > kEmptyDensity ? std::max(kEmptyDensity, float(raw_at_scale(raw, activation.shift, by)))
                                : kEmptyDensity;
    }
  });
  activation.scale *= by;
}

}  // namespace

Lattices::Lattices(const Setting& setting, const TimeMap& time_map, const Box& box) {
  const Config& c = setting.config;
  model.box = box;
  model.background = starting_background(c, setting.train, setting.stats, setting.unit);
  model.surroundings = starting_surroundings(c, box, model.background, setting.stats, setting.unit);
  model.time_map = time_map;
  model.radiance.sh_order = order_at(c.radiance, 0);
  MotionField& m = model.motion;
  m.basis = c.motion.basis;
  m.points = c.motion.points;
  store(effects_of(c), m);
  m.first_point = basis_of(c.motion.basis).pinnable ? c.motion.first_point : FirstPoint::free;
  m.rigidity_offset = c.motion.initial_rigidity;
}

void Lattices::start_radiance(const Setting& setting, const BitGrid& cells) {
  const Config& c = setting.config;
  const Lattice lattice = make_lattice(model.box, c.grid.radiance[0]);
  model.step = c.sampling.step * lattice.spacing;
  // One step of the first lattice has alpha initial_alpha at raw density 0: softplus(shift) = -log(1 -
  // alpha).
  model.radiance.activation.scale = 1 / model.step;
  model.radiance.activation.shift = float(inverse_softplus(optical_depth(initial_alpha(c, setting.stats))));
  const std::vector<float> row = first_row(model.radiance, c.radiance, setting.stats);
  model.radiance.raw = make_channels(bricks_near(lattice, cells), int(row.size()), row.data());
  for (int i = 0; i < kBrickRows; ++i) model.radiance.raw.row(i)[0] = kEmptyDensity;
  radiance = Learner(model.radiance.raw);
  forget_visible(setting);
}

void Lattices::refine_radiance(const Setting& setting, int cells, const BitGrid& matter,
                               const std::optional<Offset>& offset, bool prune) {
  const Lattice lattice = make_lattice(model.box, cells);
  Channels& raw = model.radiance.raw;
  radiance = {};  // not both the old lattice's and the new one's
  if (offset)
    raw = resample(raw, bricks_near(lattice, moved(matter, *offset)),
                   [&](Vec3 x) { return x + offset->at(x); });
  else
    raw = resample(raw, bricks_near(lattice, matter));
  if (prune && prune_empty(raw)) raw.values.shrink_to_fit();
  const float step = setting.config.sampling.step * lattice.spacing, power = setting.config.radiance.steepen;
  // Presence is added to raw values, and would become something else.
  if (power > 0 && !model.motion.presence) steepen(model.radiance, std::pow(model.step / step, power));
  model.step = step;
  radiance = Learner(raw);
  forget_visible(setting);
}

void Lattices::add_harmonics(int order) {
  model.radiance.sh_order = order;
  Channels& raw = model.radiance.raw;
  const int from = raw.width, to = radiance_width(order);
  if (from == to) return;  // they have room
  for (AlignedVector<float>* rows : {&raw.values, &radiance.m, &radiance.v}) {
    AlignedVector<float> wide(raw.topology->rows() * to, 0.0f);
    for (std::size_t r = 0; r < raw.topology->rows(); ++r)
      std::copy_n(rows->data() + r * from, from, wide.data() + r * to);
    *rows = std::move(wide);
  }
  raw.width = to;
}

void Lattices::add_level(int cells, const BitGrid& near) {
  const std::vector<float> zero(model.motion.width(), 0.0f);
  levels.push_back(
      make_channels(bricks_near(make_lattice(model.box, cells), near), int(zero.size()), zero.data()));
  level_learners.emplace_back(levels.back());
}

void Lattices::put_on_levels(const std::vector<int>& cells, const Channels& sum, const BitGrid& near) {
  Channels coarser;
  for (std::size_t l = 0; l < levels.size(); ++l) {
    const TopologyPtr topology = bricks_near(make_lattice(model.box, cells[l]), near);
    const Channels target = resample(sum, topology);
    levels[l] = target;
    if (l > 0) {
      Channels known = make_channels(topology, target.width, std::vector<float>(target.width, 0.0f).data());
      for (int b = 1; b <= topology->brick_count(); ++b) prolong_brick(coarser, known, b, RowMask::all());
      for (std::size_t i = std::size_t(kBrickRows) * target.width; i < target.values.size(); ++i)
        levels[l].values[i] -= known.values[i];
    }
    coarser = target;
    level_learners[l] = Learner(levels[l]);
  }
}

void Lattices::refine_curves(int points) {
  MotionField field = model.motion;
  field.levels = std::move(levels);
  while (field.points < points) elevate(field);
  levels = std::exchange(field.levels, {});
  model.motion.points = field.points;
  level_learners.clear();
  for (const Channels& level : levels) level_learners.emplace_back(level);
}

void Lattices::sum_levels(std::span<const RowMask> moving) {
  if (levels.empty()) return;
  std::vector<const Channels*> all;
  for (const Channels& level : levels) all.push_back(&level);
  LevelSums sums;
  model.motion.levels.resize(1);
  Channels& sum = model.motion.levels[0];
  sum = sums.make(all, {});
  if (moving.empty()) return;
  parallel_for(sum.topology->brick_count(), [&](int index) {
    const int b = index + 1;
    (~moving[b]).for_each([&](int i) {
      std::fill_n(sum.row(std::size_t(b) * kBrickRows + i), sum.width, 0.0f);
    });
  });
}

void Lattices::forget_visible(const Setting& setting) {
  visible = {};
  if (!setting.config.grid.empty_start.empty())
    visible.rows.assign(model.radiance.raw.topology->bricks.size(), {});
}

}  // namespace splinevox
