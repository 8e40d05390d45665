// SPDX-License-Identifier: Apache-2.0
#include "train/state.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/parallel.hpp"
#include "field/lattice/slice.hpp"
#include "math/activation.hpp"
#include "math/schedule.hpp"
#include "train/effects/effect_table.hpp"
#include "train/ranks.hpp"
#include "train/rates.hpp"

namespace splinevox {
namespace {

/// Share of the occupied cells below which a part on its own does not hold the box open.
constexpr float kSmallPart = 1 / 300.0f;

/// A window of time is for what moves.
SamplingConfig sampling_of(const Config& config) {
  SamplingConfig out = config.sampling;
  if (!config.motion.enabled) out.window = 1;
  return out;
}

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

void check_fits(bool good) {
  if (!good)
    fail({"checkpoint", "the training state does not fit this configuration",
          "a state written by the same version and configuration", "other sizes", ""});
}

}  // namespace

Trainer::State::State(const Config& c, const Split& t, const TimeMap& time_map)
    : shown(look_at(t)),
      unit(brightness(c, shown)),
      config(in_units_of(unit, c)),
      train(t),
      bounds(starting_bounds(c, t, shown)),
      sampler(t, bounds.box, sampling_of(c), c.run.seed, unit) {
  model.box = bounds.box;
  edge = model.box.longest_edge();
  model.background = starting_background(c, t, shown);
  model.time_map = time_map;
  model.radiance.sh_order = order_at(c.radiance, 0);
  MotionField& m = model.motion;
  m.basis = c.motion.basis, m.points = c.motion.points;
  store(effects_of(c), m);
  m.first_point = c.motion.basis == BasisKind::bspline ? FirstPoint::free : c.motion.first_point;
  m.rigidity_offset = c.motion.initial_rigidity;
}

bool Trainer::State::refine(double progress_now) {
  progress = progress_now;
  bool changed = false;
  const int wanted = std::max(0, reached(config.grid.radiance_start, progress));
  const bool changes = splinevox::changes(effects_of(config));
  int wanted_levels = changes ? reached(config.grid.motion_start, progress) + 1 : 0;
  const bool spline = config.motion.basis == BasisKind::bspline;
  const int wanted_elevations =
      changes ? reached(spline ? config.motion.halve_start : config.motion.elevate_start, progress) + 1 : 0;
  const bool elevates = elevations < wanted_elevations;
  const int wanted_emptied = reached(config.grid.empty_start, progress) + 1;
  const bool empties = emptied < wanted_emptied;
  const int wanted_order = order_at(config.radiance, progress);
  const bool joins = model.radiance.sh_order < wanted_order;
  if (joins || stage < wanted || int(levels.size()) < wanted_levels || elevates || empties) bring_home();
  if (empties) {
    if (stage >= 0) changed = empty_unseen();  // before the first stage there is nothing
    emptied = wanted_emptied;
    uploaded = false;
  }
  const bool refines = step > 0 && (stage < wanted || int(levels.size()) < wanted_levels);
  if (refines && stage < wanted && !growing()) tighten_box();
  if (refines || changed) refresh_occupancy();
  std::optional<Offset> offset;
  if (step > 0 && stage < wanted)
    offset = settle(bounds.box.longest_edge() / float(config.grid.radiance[wanted]));
  const bool settled = offset.has_value();
  if (settled)
    wanted_levels = int(
        config.grid.motion
            .size());  // they cost little now, and what rests is told from what moves as finely as they are
  while (stage < wanted) {
    ++stage;
    if (stage == 0)
      start_radiance();
    else
      refine_radiance(config.grid.radiance[stage], std::exchange(offset, {}));
    changed = true;
  }
  if (joins) add_harmonics(wanted_order), changed = true;
  if (changes) {
    while (int(levels.size()) < wanted_levels) {
      add_level(config.grid.motion[levels.size()]);
      changed = true;
    }
    while (elevations < wanted_elevations) {
      MotionField field = model.motion;
      field.levels = std::move(levels);
      const int points = spline ? halved_points(field.points) : config.motion.elevate_points[elevations];
      while (field.points < points) elevate(field);
      levels = std::exchange(field.levels, {});
      model.motion.points = field.points;
      level_learners.clear();
      for (const Channels& level : levels) level_learners.emplace_back(level);
      ++elevations;
      changed = true;
    }
  }
  if (changed) fit_lattices();
  if (settled) refresh_occupancy();
  return changed;
}

void Trainer::State::fit_lattices() {
  uploaded = false;
  set_rates();
  find_awake_rows();
  collapse_levels({});
  find_active();
  const bool moving = !levels.empty();
  if (moving) motion_gradient = Gradient(model.motion.levels[0]);
  if (engine && engine_moves == moving && engine_order == model.radiance.sh_order) return;
  engine_moves = moving, engine_order = model.radiance.sh_order;
  engine = make_engine(engine_order, moving, config.loss.offset > 0 || config.loss.divergence > 0);
}

void Trainer::State::start_radiance() {
  const Lattice lattice = make_lattice(bounds.box, config.grid.radiance[0]);
  model.step = config.sampling.step * lattice.spacing;
  // One step of the first lattice has alpha initial_alpha at raw density 0: softplus(shift) = -log(1 -
  // alpha).
  model.radiance.activation.scale = 1 / model.step;
  model.radiance.activation.shift = float(inverse_softplus(optical_depth(config.radiance.initial_alpha)));
  const std::vector<float> row = first_row(model.radiance, config.radiance, shown);
  model.radiance.raw = make_channels(bricks_near(lattice, bounds.hull), int(row.size()), row.data());
  for (int i = 0; i < kBrickRows; ++i) model.radiance.raw.row(i)[0] = kEmptyDensity;
  radiance = Learner(model.radiance.raw);
  forget_seen();
}

void Trainer::State::tighten_box() {
  if (!config.grid.box.empty()) return;
  collapse_levels({});
  BitGrid kept =
      canonical_occupancy(model, config.sampling.occupancy_cells, config.grid.box_alpha, model.step);
  for (const BitGrid& frame : frame_occupancies(config.grid.box_alpha)) kept |= frame;
  Box box = bounding_box(drop_small_parts(kept, kSmallPart), config.grid.box_margin);
  box.lo = max(box.lo, model.box.lo), box.hi = min(box.hi, model.box.hi);
  const auto volume = [](const Box& b) { return double(b.extent().x) * b.extent().y * b.extent().z; };
  if (volume(box) > 0.9 * volume(model.box)) return;

  const BitGrid old_hull = bounds.hull;
  bounds = {box, BitGrid(box, config.sampling.occupancy_cells)};
  Int3 c;
  for (c.x = 0; c.x < bounds.hull.size.x; ++c.x)
    for (c.y = 0; c.y < bounds.hull.size.y; ++c.y)
      for (c.z = 0; c.z < bounds.hull.size.z; ++c.z)
        if (old_hull.test(old_hull.index(old_hull.cell_of(bounds.hull.center(c)))))
          bounds.hull.set(bounds.hull.index(c));
  model.box = box;
  edge = model.box.longest_edge();
  sampler.set_box(box);
  if (!levels.empty())
    put_on_levels(Channels(model.motion.levels[0]), awake.cells() > 0 ? swept() : dilate(bounds.hull));
}

void Trainer::State::put_on_levels(const Channels& sum, const BitGrid& cells) {
  Channels coarser;
  for (std::size_t l = 0; l < levels.size(); ++l) {
    const TopologyPtr topology = bricks_near(make_lattice(model.box, config.grid.motion[l]), cells);
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
  find_awake_rows();
}

void Trainer::State::add_harmonics(int order) {
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
  radiance.resize(raw);
}

void Trainer::State::refine_radiance(int cells, const std::optional<Offset>& offset) {
  const Lattice lattice = make_lattice(bounds.box, cells);
  const BitGrid matter = growing() ? bounds.hull
                                   : canonical_occupancy(model, config.sampling.occupancy_cells,
                                                         config.grid.prune_alpha, model.step);
  radiance = {};  // not both the old lattice's and the new one's
  if (offset)
    model.radiance.raw = resample(model.radiance.raw, bricks_near(lattice, moved(matter, *offset)),
                                  [&](Vec3 x) { return x + offset->at(x); });
  else
    model.radiance.raw = resample(model.radiance.raw, bricks_near(lattice, matter));
  if (!growing() && config.grid.prune_alpha > 0 && drop_empty(model.radiance.raw))
    model.radiance.raw.values.shrink_to_fit();
  model.step = config.sampling.step * lattice.spacing;
  radiance = Learner(model.radiance.raw);
  forget_seen();
}

void Trainer::State::add_level(int cells) {
  const std::vector<float> zero(model.motion.width(), 0.0f);
  levels.push_back(
      make_channels(bricks_near(make_lattice(bounds.box, cells), swept()), int(zero.size()), zero.data()));
  level_learners.emplace_back(levels.back());
}

void Trainer::State::collapse_levels(const std::vector<RowMask>& rows) {
  // Into the arrays of the last call: every step comes here, and fresh memory would cost more than the sums.
  const auto match = [](const Channels& like, Channels& out) {
    if (out.topology == like.topology && out.width == like.width) return;
    out = like;
  };
  if (levels.empty()) return;
  partial_sums.resize(levels.size() - 1);
  model.motion.levels.resize(1);
  for (std::size_t l = 0; l < levels.size(); ++l) {
    Channels& sum = l + 1 < levels.size() ? partial_sums[l] : model.motion.levels[0];
    match(levels[l], sum);
    const bool finest = l + 1 == levels.size();
    parallel_for(sum.topology->brick_count(), [&](int index) {
      const int b = index + 1;
      const RowMask mask = finest && !rows.empty() ? rows[b] : RowMask::all();
      mask.for_each([&](int i) {
        std::copy_n(levels[l].row(std::size_t(b) * kBrickRows + i), sum.width,
                    sum.row(std::size_t(b) * kBrickRows + i));
      });
      if (l > 0) prolong_brick(partial_sums[l - 1], sum, b, mask);
      if (finest && rows.empty() && !awake_rows.empty())
        (~awake_rows[b]).for_each([&](int i) {
          std::fill_n(sum.row(std::size_t(b) * kBrickRows + i), sum.width, 0.0f);
        });
    });
  }
}

void Trainer::State::set_rates() {
  splinevox::set_rates(model.radiance, config, radiance);
  for (Learner& learner : level_learners)
    splinevox::set_rates(model.motion, config, edge, config.grid.motion[levels.size() - 1], learner);
}

MomentFactors Trainer::State::factors() const {
  const OptimiserConfig& o = config.optimiser;
  return moment_factors(o.kind == OptimiserKind::adam ? o.beta1 : 0.0, o.beta2, o.epsilon, double(step));
}

void Trainer::State::learn_background(double progress_now) {
  if (!model.background.learned()) return;
  BackgroundGradient gradient = background_gradient(model.background, batch, behind);
  if (ranks) sum_over_ranks(*ranks, {&gradient[0].x, 3 * gradient.size()});
  update(model.background, background, gradient, factors(),
         config.optimiser.lr_background * float(cosine_decay(progress_now, config.optimiser.final_radiance)));
}

CurvePrior Trainer::State::curve_prior() const {
  const int halvings = config.motion.basis == BasisKind::bspline ? elevations : 0;
  return splinevox::curve_prior(model.motion, config, edge, halvings);
}

RestPrior Trainer::State::rest_prior() const {
  constexpr float kSoftening = 3e-4f;  // edges of the box: what a step of the optimiser leaves at the end
  return {model.motion.displaces ? config.loss.curve_rest / edge : 0, kSoftening * edge};
}

bool Trainer::State::wild_weights() const {
  const LossConfig& l = config.loss;
  constexpr float kWild = 1e12f;
  const CurvePrior curves = curve_prior();
  const float most = std::max({l.tv_density, l.tv_color, l.tv_sh, l.tv_control / edge, l.tv_rigidity,
                               l.tv_light, curves.heaviest(), rest_prior().weight});
  return !(most / l.tv_share < kWild);
}

void Trainer::State::archive(Archive& a) {
  a(step, stage, elevations, seconds_before, seconds_at_start, phases);
  a(bounds.box, bounds.hull, model.step, model.radiance.activation, model.radiance.raw, radiance.m,
    radiance.v, model.motion.points);
  std::uint64_t count = levels.size(), frames = occupancy.size();
  a(count, frames);
  check_fits(!a.reading() ||
             (count <= config.grid.motion.size() && (frames <= 1 || frames == train.frames.size())));
  levels.resize(count), level_learners.resize(count), occupancy.resize(frames);
  for (std::size_t l = 0; l < count; ++l) {
    a(levels[l]);
    if (a.reading()) level_learners[l] = Learner(levels[l]);
    a(level_learners[l].m, level_learners[l].v);
  }
  for (BitGrid& grid : occupancy) a(grid);
  const int background_order = model.background.order;
  a(model.background, background);
  std::vector<RowMask> seen = radiance.gradient.seen;
  a(model.radiance.sh_order, emptied, rays_shown, seen, awake, moving_share);
  if (!a.reading()) return;
  const auto fits = [](const Channels& c, const Learner& l, int width) {
    return c.width == width && l.m.size() == c.values.size() && l.v.size() == c.values.size();
  };
  bool good = model.background.order == background_order && stage >= 0 &&
              stage < int(config.grid.radiance.size()) && model.motion.points >= kMinPoints &&
              model.motion.points <= kMaxPoints;
  good = good && model.radiance.sh_order >= order_at(config.radiance, 0) &&
         model.radiance.sh_order <= config.radiance.sh_order;
  good = good && fits(model.radiance.raw, radiance, radiance_width(model.radiance.sh_order));
  good = good &&
         seen.size() == (config.grid.empty_start.empty() ? 0 : model.radiance.raw.topology->bricks.size());
  for (std::size_t l = 0; good && l < count; ++l)
    good = fits(levels[l], level_learners[l], model.motion.width());
  check_fits(good);
  model.box = bounds.box;
  edge = model.box.longest_edge();
  sampler.set_box(bounds.box);
  radiance.gradient.seen = std::move(seen);
  radiance.resize(model.radiance.raw);
  fit_lattices();
}

}  // namespace splinevox
