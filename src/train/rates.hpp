// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "field/columns.hpp"
#include "train/lattices.hpp"

/// How the columns of field/columns.hpp are learned: first values, rates, total variation, shrinkage, priors.
namespace splinevox {

/// The numbers of a configuration that a kind of column is learned by. Lengths are in edges of the box.
struct ColumnLearning {
  ColumnKind kind;
  float OptimiserConfig::*rate;
  float LossConfig::*tv;                     ///< total variation
  float LossConfig::*differences = nullptr;  ///< of a curve: squared differences between its points
};
const ColumnLearning& learning_of(ColumnKind kind);

/// The row that radiance begins with, [width].
std::vector<float> first_row(const RadianceField& radiance, const RadianceConfig& config,
                             const PictureStats& stats);

/// Learning rate and total variation of every column, for the lattices as they are, and the groups of motion
/// that shrink. Padding has none.
void set_rates(const Config& config, Lattices& lattices);

/// The configuration's priors on curves for the box as it is. @param halvings  of the curves' spans so far
void set_priors(const Config& config, int halvings, Lattices& lattices);

}  // namespace splinevox
