// SPDX-License-Identifier: Apache-2.0
#include "io/model/model_columns.hpp"

#include <algorithm>

namespace splinevox {

std::vector<ModelColumn> radiance_columns(const RadianceField& radiance) {
  std::vector<ModelColumn> columns{{"density", 0, 1, "density before its activation", kDensityActivation},
                                   {"rgb", 1, 3, "colour before the sigmoid", "sigmoid"}};
  for (int j = 0; j < radiance.sh_count(); ++j)
    columns.push_back(
        {"sh" + std::to_string(j), 4 + j, 1, "spherical-harmonic coefficient of the view rescale"});
  return columns;
}

std::vector<ModelColumn> motion_columns(const MotionField& motion) {
  std::vector<ModelColumn> columns;
  const int skipped = motion.points - motion.stored_points();
  for (int k = 0; motion.displaces && k < motion.stored_points(); ++k)
    columns.push_back({"control_" + std::to_string(k + skipped), motion.stride() * k, 3,
                       "control point of the displacement to canonical, scene units"});
  if (motion.rigidity)
    columns.push_back({"rigidity", motion.rigidity_column(), 1,
                       "rigidity before the sigmoid: 1 moves, 0 is static", "sigmoid"});
  if (motion.light)
    for (int k = 0; k < motion.stored_points(); ++k)
      columns.push_back({"light_" + std::to_string(k + skipped), motion.stride() * k + motion.light_lane(), 1,
                         "control point of the light before its gain 2 sigmoid", "2 sigmoid"});
  return columns;
}

int padded_width(const std::vector<ModelColumn>& columns) {
  int width = 0;
  for (const ModelColumn& column : columns) width = std::max(width, column.first + column.width);
  return padded_width(width);
}

}  // namespace splinevox
