// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "field/columns.hpp"
#include "train/optimiser.hpp"
#include "train/start.hpp"

/// How the columns of field/columns.hpp are learned: first values, rates, total variation, shrinkage, priors.
namespace splinevox {

/// The numbers of a configuration that a kind of column is learned by.
struct ColumnLearning {
  ColumnKind kind;
  float OptimiserConfig::*rate;              ///< of a length: in edges of the box
  float LossConfig::*tv;                     ///< total variation; of a length: per edge of the box
  float LossConfig::*differences = nullptr;  ///< of a curve: squared differences between its points
};
const ColumnLearning& learning_of(ColumnKind kind);

/// The row that radiance begins with, [width].
std::vector<float> first_row(const RadianceField& radiance, const RadianceConfig& config, const Shown& shown);

/// Rate and total variation weight of every column. Padding has none.
void set_rates(const RadianceField& radiance, const Config& config, Learner& learner);
/// The same of one level of motion, and its groups that shrink.
/// @param edge   longest edge of the box, scene units
/// @param cells  along it, of the finest level that is learned now
void set_rates(const MotionField& motion, const Config& config, float edge, int cells, Learner& learner);

/// The priors on a model's curves, whose lengths are edges of the box in the configuration, in scene units.
/// @param halvings  that its control points have been through
CurvePrior curve_prior(const MotionField& motion, const Config& config, float edge, int halvings);

}  // namespace splinevox
