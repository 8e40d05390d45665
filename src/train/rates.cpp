// SPDX-License-Identifier: Apache-2.0
#include "train/rates.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace splinevox {
namespace {

constexpr ColumnLearning kLearning[] = {
    {ColumnKind::density, &OptimiserConfig::lr_density, &LossConfig::tv_density},
    {ColumnKind::color, &OptimiserConfig::lr_color, &LossConfig::tv_color},
    {ColumnKind::sh, &OptimiserConfig::lr_sh, &LossConfig::tv_sh},
    {ColumnKind::control, &OptimiserConfig::lr_control, &LossConfig::tv_control, &LossConfig::curve_length},
    {ColumnKind::rigidity, &OptimiserConfig::lr_rigidity, &LossConfig::tv_rigidity},
    {ColumnKind::light, &OptimiserConfig::lr_light, &LossConfig::tv_light, &LossConfig::curve_light},
};
static_assert(std::size(kLearning) == std::size(kColumns));

void set_rate(const Column& c, float rate, float tv, Learner& learner) {
  std::fill_n(learner.rate.begin() + c.first, c.width, rate);
  std::fill_n(learner.tv.begin() + c.first, c.width, tv);
}

/// What the step of control points is multiplied by. As a run goes on rigidity takes displacements, and so
/// their steps, to a tenth of what they began with and less (docs/experiments.md, "Without rigidity");
/// without it a step is a fiftieth of a cell of the finest lattice, where lr_control is 0.01.
float control_share(const MotionField& m, int cells) { return m.rigidity ? 1 : 2.0f / float(cells); }

}  // namespace

const ColumnLearning& learning_of(ColumnKind kind) { return kLearning[int(kind)]; }

std::vector<float> first_row(const RadianceField& radiance, const RadianceConfig& config,
                             const Shown& shown) {
  std::vector<float> row(radiance_width(radiance.sh_order), 0.0f);
  const std::vector<Column> columns = radiance_columns(radiance);
  for (const Column& c : columns) std::fill_n(row.begin() + c.first, c.width, facts_of(c.kind).first);
  const Vec3 color = starting_color(config, shown);
  std::copy_n(&color.x, 3, row.begin() + first_column(ColumnKind::color));
  if (radiance.sh_order >= 0) row[first_column(ColumnKind::sh)] = config.initial_sh;
  return row;
}

void set_rates(const RadianceField& radiance, const Config& config, Learner& learner) {
  for (const Column& c : radiance_columns(radiance)) {
    const ColumnLearning& by = learning_of(c.kind);
    set_rate(c, config.optimiser.*by.rate, config.loss.*by.tv, learner);
  }
}

/// The curves of a kind shrink as one. A step moves every column by its rate at most, so lengths are measured
/// in rates times the root of the number of columns.
void set_rates(const MotionField& motion, const Config& config, float edge, int cells, Learner& learner) {
  learner.shrink.clear();
  const std::vector<Column> columns = motion_columns(motion);
  for (const ColumnFacts& facts : kColumns) {
    if (!facts.of_motion() || !(motion.*facts.stored)) continue;
    const ColumnLearning& by = learning_of(facts.kind);
    const float unit = facts.length ? edge : 1, share = facts.length ? control_share(motion, cells) : 1;
    const float rate = config.optimiser.*by.rate;
    Shrink group{std::vector<float>(motion.width(), 0.0f), 0};
    for (const Column& c : columns) {
      if (c.kind != facts.kind) continue;
      set_rate(c, rate * unit * share, config.loss.*by.tv / unit, learner);
      std::fill_n(group.member.begin() + c.first, c.width, 1.0f);
    }
    if (facts.repeat != Repeat::point || config.optimiser.shrink == 0) continue;
    group.threshold = config.optimiser.shrink * rate * unit * share *
                      std::sqrt(float(facts.width) * float(motion.stored_points()));
    learner.shrink.push_back(std::move(group));
  }
}

CurvePrior curve_prior(const MotionField& motion, const Config& config, float edge, int halvings) {
  constexpr float kSoftening = 3e-5f;  // edges of the box: a hundredth of a voxel
  static_assert(kScalars <= CurvePrior::kScalars);
  const LossConfig& l = config.loss;
  const MotionLayout layout(motion);
  CurvePrior prior;
  if (motion.displaces) {
    prior.length = l.*learning_of(ColumnKind::control).differences / (edge * edge);
    prior.knots = l.curve_knots / edge;
  }
  for (const ColumnFacts& facts : kColumns) {
    if (!is_scalar(facts) || !(motion.*facts.stored)) continue;
    const int i = facts.slice - kSliceScalars;
    prior.scalar[i] = l.*learning_of(facts.kind).differences;
    prior.lane[i] = layout.scalar[i];
  }
  prior.spacing = 1 << halvings;
  prior.softening = kSoftening * edge;
  return prior;
}

}  // namespace splinevox
