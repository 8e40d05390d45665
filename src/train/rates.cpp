// SPDX-License-Identifier: Apache-2.0
#include "train/rates.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "train/config/loss_terms.hpp"

namespace splinevox {
namespace {

constexpr ColumnLearning kLearning[] = {
    {ColumnKind::density, &OptimiserConfig::lr_density, &LossConfig::tv_density},
    {ColumnKind::color, &OptimiserConfig::lr_color, &LossConfig::tv_color},
    {ColumnKind::sh, &OptimiserConfig::lr_sh, &LossConfig::tv_sh},
    {ColumnKind::control, &OptimiserConfig::lr_control, &LossConfig::tv_control, &LossConfig::curve_length},
    {ColumnKind::rigidity, &OptimiserConfig::lr_rigidity, &LossConfig::tv_rigidity},
    {ColumnKind::light, &OptimiserConfig::lr_light, &LossConfig::tv_light, &LossConfig::curve_light},
    {ColumnKind::presence, &OptimiserConfig::lr_presence, &LossConfig::tv_presence,
     &LossConfig::curve_presence},
};
static_assert(std::size(kLearning) == std::size(kColumns));

/// What the step of control points is multiplied by. As a run goes on rigidity takes displacements, and so
/// their steps, to a tenth of what they began with and less (docs/experiments/motion.md);
/// without it a step is a fiftieth of a cell of the finest lattice, where lr_control is 0.01. @param cells
/// along the longest edge, of that lattice
float control_share(const MotionField& m, int cells) { return m.rigidity ? 1 : 2.0f / float(cells); }

void set_rate(const Column& c, float rate, float tv, Learner& learner) {
  std::fill_n(learner.rate.begin() + c.first, c.width, rate);
  std::fill_n(learner.tv.begin() + c.first, c.width, tv);
}

/// Of one level of motion. The curves of a kind shrink as one. A step moves every column by its rate at most,
/// so lengths are measured in rates times the root of the number of columns.
void set_motion_rates(const MotionField& motion, const OptimiserConfig& optimiser, const LossConfig& loss,
                      float edge, float share, Learner& learner) {
  const std::vector<Column> columns = motion_columns(motion);
  learner.shrink.clear();
  for (const ColumnFacts& facts : kColumns) {
    if (!facts.of_motion() || !(motion.*facts.stored)) continue;
    const ColumnLearning& by = learning_of(facts.kind);
    const float scale = facts.length ? edge : 1, slowed = facts.length ? share : 1;
    Shrink group{std::vector<float>(motion.width(), 0.0f), 0};
    for (const Column& c : columns) {
      if (c.kind != facts.kind) continue;
      set_rate(c, optimiser.*by.rate * scale * slowed, loss.*by.tv, learner);
      std::fill_n(group.member.begin() + c.first, c.width, 1.0f);
    }
    if (facts.repeat != Repeat::point || optimiser.shrink == 0) continue;
    group.threshold = optimiser.shrink * optimiser.*by.rate * scale * slowed *
                      std::sqrt(float(facts.width) * float(motion.stored_points()));
    learner.shrink.push_back(std::move(group));
  }
}

}  // namespace

const ColumnLearning& learning_of(ColumnKind kind) { return kLearning[int(kind)]; }

std::vector<float> first_row(const RadianceField& radiance, const RadianceConfig& config,
                             const PictureStats& stats) {
  std::vector<float> row(radiance_width(radiance.sh_order), 0.0f);
  for (const Column& c : radiance_columns(radiance))
    std::fill_n(row.begin() + c.first, c.width, facts_of(c.kind).first);
  const Vec3 color = starting_color(config, stats);
  for (int a = 0; a < 3; ++a) row[first_column(ColumnKind::color) + a] = color[a];
  if (radiance.sh_order >= 0) row[first_column(ColumnKind::sh)] = config.initial_sh;
  return row;
}

void set_rates(const Config& config, Lattices& lattices) {
  const LossConfig loss = in_scene_units(config.loss, lattices.edge());
  Learner& radiance = lattices.radiance;
  radiance.rate.assign(lattices.model.radiance.raw.width, 0.0f);
  radiance.tv = radiance.rate;
  for (const Column& c : radiance_columns(lattices.model.radiance)) {
    const ColumnLearning& by = learning_of(c.kind);
    set_rate(c, config.optimiser.*by.rate, loss.*by.tv, radiance);
  }
  if (lattices.levels.empty()) return;
  const MotionField& motion = lattices.model.motion;
  const float share = control_share(motion, config.grid.motion[lattices.levels.size() - 1]);
  for (Learner& learner : lattices.level_learners)
    set_motion_rates(motion, config.optimiser, loss, lattices.edge(), share, learner);
}

void set_priors(const Config& config, int halvings, Lattices& lattices) {
  constexpr float kKnotSoftening = 3e-5f;    // edges of the box: a hundredth of a voxel
  constexpr float kStaticSoftening = 3e-4f;  // the same: what a step of the optimiser leaves at the end
  static_assert(kScalars <= CurvePrior::kScalars);
  const float edge = lattices.edge();
  const LossConfig loss = in_scene_units(config.loss, edge);
  const MotionField& motion = lattices.model.motion;
  const MotionLayout layout(motion);
  CurvePrior curves;
  if (motion.displaces) {
    curves.length = loss.*learning_of(ColumnKind::control).differences;
    curves.knots = loss.curve_knots;
  }
  for (const ColumnFacts& facts : kColumns) {
    if (!is_scalar(facts) || !(motion.*facts.stored)) continue;
    const int i = scalar_index(facts.kind);
    curves.scalar[i] = loss.*learning_of(facts.kind).differences;
    curves.lane[i] = layout.scalar[i];
  }
  curves.spacing = 1 << halvings;
  curves.softening = kKnotSoftening * edge;
  lattices.curves = curves;
  lattices.static_prior = {motion.displaces ? loss.curve_rest : 0, kStaticSoftening * edge};
  lattices.may_spoil = can_spoil_gradients(loss);
}

}  // namespace splinevox
