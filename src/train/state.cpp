// SPDX-License-Identifier: Apache-2.0
#include "state.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "splinevox/core/parallel.hpp"
#include "splinevox/field/slice.hpp"

namespace splinevox {
namespace {

/// Raw density of what is absent: an alpha of about 1e-6 a step, low enough to be nothing and near enough to learn back from.
constexpr float kEmptyDensity = -10;

bool any_alpha(const Split& train) {
  for (const Frame& f : train.frames)
    for (std::size_t i = 3; i < f.image.rgba.size(); i += 4)
      if (f.image.rgba[i] != 65535) return true;
  return false;
}

SceneBounds bounds_of(const Config& config, const Split& train) {
  const std::vector<float>& b = config.grid.box;
  if (b.size() == 6) {
    const Box box{{b[0], b[1], b[2]}, {b[3], b[4], b[5]}};
    BitGrid all(box, config.sampling.occupancy_cells);
    std::fill(all.bits.begin(), all.bits.end(), ~0u);
    return {box, all};
  }
  return find_bounds(train, any_alpha(train), config.sampling.occupancy_cells, config.grid.box_margin);
}

Vec3 background_of(const Config& config) {
  const std::vector<float>& b = config.run.background;
  return {b[0], b[1], b[2]};
}

/// Index of the last start that progress has reached.
int reached(const std::vector<float>& starts, double progress) {
  int i = -1;
  while (i + 1 < int(starts.size()) && progress >= starts[i + 1]) ++i;
  return i;
}

}  // namespace

Trainer::State::State(const Config& c, const Split& t, const TimeMap& time_map)
    : config(c), train(t), bounds(bounds_of(c, t)), edge(std::max({bounds.box.extent().x, bounds.box.extent().y, bounds.box.extent().z})),
      sampler(t, bounds.box, c.sampling, background_of(c), c.run.seed),
      engine(make_engine(c.radiance.sh_order, c.loss.offset > 0 || c.loss.divergence > 0)) {
  model.box = bounds.box;
  model.background = background_of(c);
  model.time_map = time_map;
  model.radiance.sh_order = c.radiance.sh_order;
  MotionField& m = model.motion;
  m.basis = c.motion.basis, m.points = c.motion.points, m.rigidity = c.motion.rigidity;
  m.first_point = c.motion.basis == BasisKind::bspline ? FirstPoint::free : c.motion.first_point;
  m.rigidity_offset = c.motion.initial_rigidity;
}

bool Trainer::State::refine(double progress) {
  bool changed = false;
  const int wanted = std::max(0, reached(config.grid.radiance_start, progress));
  while (stage < wanted) {
    ++stage;
    if (stage == 0) start_radiance();
    else refine_radiance(config.grid.radiance[stage]);
    changed = true;
  }
  if (config.motion.enabled) {
    const int active = reached(config.grid.motion_start, progress) + 1;
    while (int(levels.size()) < active) {
      add_level(config.grid.motion[levels.size()]);
      changed = true;
    }
    while (elevations <= reached(config.motion.elevate_start, progress)) {
      MotionField field = model.motion;
      field.levels = std::move(levels);
      while (field.points < config.motion.elevate_points[elevations]) elevate(field);
      levels = std::exchange(field.levels, {});
      model.motion.points = field.points;
      level_learners.clear();
      for (const Channels& level : levels) level_learners.emplace_back(level);
      ++elevations;
      changed = true;
    }
  }
  if (changed) {
    set_rates();
    collapse_levels();
    if (!levels.empty()) motion_gradient = Gradient(model.motion.levels[0]);
    if (step > 0) refresh_occupancy();
  }
  return changed;
}

void Trainer::State::start_radiance() {
  const Lattice lattice = make_lattice(bounds.box, config.grid.radiance[0]);
  model.step = config.sampling.step * lattice.spacing;
  // One step of the first lattice has alpha initial_alpha at raw density 0: softplus(shift) = -log(1 - alpha).
  model.radiance.activation.scale = 1 / model.step;
  model.radiance.activation.shift = float(std::log(std::expm1(-std::log1p(-double(config.radiance.initial_alpha)))));
  const int width = radiance_width(config.radiance.sh_order);
  std::vector<float> row(width, 0.0f);
  if (config.radiance.sh_order >= 0) row[4] = config.radiance.initial_sh;
  model.radiance.raw = make_channels(bricks_near(lattice, bounds.hull), width, row.data());
  for (int i = 0; i < kBrickRows; ++i) model.radiance.raw.row(i)[0] = kEmptyDensity;
  radiance = Learner(model.radiance.raw);
}

void Trainer::State::refine_radiance(int cells) {
  const Lattice lattice = make_lattice(bounds.box, cells);
  BitGrid matter = canonical_occupancy(model, config.sampling.occupancy_cells, config.grid.prune_alpha, model.step);
  model.radiance.raw = resample(model.radiance.raw, bricks_near(lattice, matter));
  model.step = config.sampling.step * lattice.spacing;
  radiance = Learner(model.radiance.raw);
}

BitGrid Trainer::State::swept() const {
  if (occupancy.empty()) return bounds.hull;
  BitGrid all = occupancy.front();
  for (const BitGrid& frame : occupancy)
    for (std::size_t w = 0; w < all.bits.size(); ++w) all.bits[w] |= frame.bits[w];
  return dilate(all);
}

void Trainer::State::add_level(int cells) {
  if (step > 0) refresh_occupancy();
  const std::vector<float> zero(motion_width(model.motion), 0.0f);
  levels.push_back(make_channels(bricks_near(make_lattice(bounds.box, cells), swept()), int(zero.size()), zero.data()));
  level_learners.emplace_back(levels.back());
}

void Trainer::State::collapse_levels() {
  if (levels.empty()) return;
  if (levels.size() == 1) {
    model.motion.levels.assign(1, levels[0]);
    return;
  }
  Channels sum = levels[0];
  for (std::size_t l = 1; l < levels.size(); ++l) {
    Channels fine = levels[l];
    parallel_for(fine.topology->brick_count(), [&](int b) { prolong_brick(sum, fine, b + 1); });
    sum = std::move(fine);
  }
  model.motion.levels.resize(1);
  model.motion.levels[0] = std::move(sum);
}

void Trainer::State::refresh_occupancy() {
  collapse_levels();
  const SamplingConfig& s = config.sampling;
  const BitGrid canonical = canonical_occupancy(model, s.occupancy_cells, s.occupancy_alpha, model.step);
  const int frames = levels.empty() ? 1 : int(train.frames.size());
  occupancy.resize(frames);
  parallel_for(frames, [&](int f) {
    const MotionSlice slice = make_slice(model.motion, stored_weights(model.motion, train.frames[f].time));
    occupancy[f] = frame_occupancy(model, slice, canonical, nullptr);
  });
}

void Trainer::State::set_rates() {
  const OptimiserConfig& o = config.optimiser;
  const LossConfig& l = config.loss;
  for (int c = 0; c < 4 + model.radiance.sh_count(); ++c) {
    radiance.rate[c] = c == 0 ? o.lr_density : c < 4 ? o.lr_color : o.lr_sh;
    radiance.tv[c] = c == 0 ? l.tv_density : c < 4 ? l.tv_color : l.tv_sh;
  }
  const int rigidity = model.motion.rigidity_column();
  for (Learner& learner : level_learners) {
    std::fill_n(learner.rate.begin(), rigidity, o.lr_control * edge);
    std::fill_n(learner.tv.begin(), rigidity, l.tv_control / edge);
    if (!model.motion.rigidity) continue;
    learner.rate[rigidity] = o.lr_rigidity;
    learner.tv[rigidity] = l.tv_rigidity;
  }
}

void Trainer::State::archive(Archive& a) {
  a(step, stage, elevations, seconds_before, phases);
  a(bounds.box, bounds.hull, model.step, model.radiance.activation, model.radiance.raw, radiance.m, radiance.v, model.motion.points);
  std::uint64_t count = levels.size(), frames = occupancy.size();
  a(count, frames);
  levels.resize(count), level_learners.resize(count), occupancy.resize(frames);
  for (std::size_t l = 0; l < count; ++l) {
    a(levels[l]);
    if (a.reading()) level_learners[l] = Learner(levels[l]);
    a(level_learners[l].m, level_learners[l].v);
  }
  for (BitGrid& grid : occupancy) a(grid);
  if (!a.reading()) return;
  radiance.gradient = Gradient(model.radiance.raw);
  radiance.rate.assign(model.radiance.raw.width, 0.0f);
  radiance.tv.assign(model.radiance.raw.width, 0.0f);
  set_rates();
  collapse_levels();
  if (!levels.empty()) motion_gradient = Gradient(model.motion.levels[0]);
}

}  // namespace splinevox
