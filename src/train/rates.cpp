// SPDX-License-Identifier: Apache-2.0
#include "train/rates.hpp"

#include <algorithm>
#include <cmath>

#include "train/config/loss_terms.hpp"

namespace splinevox {
namespace {

/// What the step of control points is multiplied by. As a run goes on rigidity takes displacements, and so
/// their steps, to a tenth of what they began with and less (docs/experiments.md, "Without rigidity");
/// without it a step is a fiftieth of a cell of the finest lattice, where lr_control is 0.01. @param cells
/// along the longest edge, of that lattice
float control_share(const MotionField& m, int cells) { return m.rigidity ? 1 : 2.0f / float(cells); }

/// Motion and light of a vertex shrink each as one. A step moves every column by its rate at most, so lengths
/// are measured in rates times the root of the number of columns.
std::vector<Shrink> shrink_groups(const MotionField& m, const OptimiserConfig& o, float edge, float share) {
  if (o.shrink == 0) return {};
  Shrink motion{std::vector<float>(m.width(), 0.0f), 0}, light = motion;
  for (int c = 0; c < m.rigidity_column(); ++c)
    (m.displaces && c % m.stride() < 3 ? motion : light).member[c] = 1;
  motion.threshold = o.shrink * o.lr_control * edge * share * std::sqrt(3.0f * float(m.stored_points()));
  light.threshold = o.shrink * o.lr_light * std::sqrt(float(m.stored_points()));
  std::vector<Shrink> groups;
  if (m.displaces) groups.push_back(motion);
  if (m.light) groups.push_back(light);
  return groups;
}

}  // namespace

void set_rates(const Config& config, Lattices& lattices) {
  const OptimiserConfig& o = config.optimiser;
  const LossConfig& l = config.loss;
  Learner& radiance = lattices.radiance;
  radiance.rate.assign(lattices.model.radiance.raw.width, 0.0f);
  radiance.tv = radiance.rate;
  for (int c = 0; c < 4 + lattices.model.radiance.sh_count(); ++c) {
    radiance.rate[c] = c == 0 ? o.lr_density : c < 4 ? o.lr_color : o.lr_sh;
    radiance.tv[c] = c == 0 ? l.tv_density : c < 4 ? l.tv_color : l.tv_sh;
  }
  const MotionField& m = lattices.model.motion;
  const float edge = lattices.edge();
  const int rigidity = m.rigidity_column();
  const float share =
      lattices.levels.empty() ? 1 : control_share(m, config.grid.motion[lattices.levels.size() - 1]);
  for (Learner& learner : lattices.level_learners) {
    std::fill_n(learner.rate.begin(), rigidity, o.lr_control * edge * share);
    std::fill_n(learner.tv.begin(), rigidity, l.tv_control / edge);
    if (m.light)
      for (int c = m.light_lane(); c < rigidity; c += m.stride()) {
        learner.rate[c] = o.lr_light;
        learner.tv[c] = l.tv_light;
      }
    learner.shrink = shrink_groups(m, o, edge, share);
    if (!m.rigidity) continue;
    learner.rate[rigidity] = o.lr_rigidity;
    learner.tv[rigidity] = l.tv_rigidity;
  }
}

void set_priors(const Config& config, int halvings, Lattices& lattices) {
  constexpr float kKnotSoftening = 3e-5f;  // edges of the box: a hundredth of a voxel
  constexpr float kRestSoftening = 3e-4f;  // the same: what a step of the optimiser leaves at the end
  const float edge = lattices.edge();
  const LossConfig loss = in_scene_units(config.loss, edge);
  const MotionField& m = lattices.model.motion;
  CurvePrior curves;
  if (m.displaces) {
    curves.length = loss.curve_length;
    curves.knots = loss.curve_knots;
  }
  if (m.light) {
    curves.light = loss.curve_light;
    curves.light_lane = m.light_lane();
  }
  curves.spacing = 1 << halvings;
  curves.softening = kKnotSoftening * edge;
  lattices.curves = curves;
  lattices.rest = {m.displaces ? loss.curve_rest : 0, kRestSoftening * edge};
  lattices.may_spoil = can_spoil_gradients(loss);
}

}  // namespace splinevox
