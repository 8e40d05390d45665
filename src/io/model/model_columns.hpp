// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "splinevox/field/model.hpp"

namespace splinevox {

inline constexpr const char* kDensityActivation = "softplus";

/// Which columns of a row a grid of model.vdb holds.
struct ModelColumn {
  std::string grid;                   ///< name of the grid
  int first = 0;                      ///< column of its (first) component
  int width = 1;                      ///< 1: float, 3: Vec3s
  std::string role;                   ///< for people who open the file elsewhere
  std::string activation = "linear";  ///< what makes a value of what is stored; so is this
};

/// The one list of grids, for saving and loading alike.
std::vector<ModelColumn> radiance_columns(const RadianceField& radiance);
std::vector<ModelColumn> motion_columns(const MotionField& motion);

/// Floats per row that these columns need, rounded up to whole registers of 8.
int padded_width(const std::vector<ModelColumn>& columns);

}  // namespace splinevox
