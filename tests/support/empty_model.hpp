// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "splinevox/field/model.hpp"

namespace splinevox::test {

inline constexpr float kEmpty = -14;  ///< raw density of nothing

/// A static model of nothing in the box from -1 to 1, with storage everywhere.
inline VoxelModel empty_model(int cells, DensityActivation activation, int sh_order) {
  VoxelModel m;
  m.box = {{-1, -1, -1}, {1, 1, 1}};
  const Lattice lattice = make_lattice(m.box, cells);
  m.step = 0.5f * lattice.spacing;
  m.radiance.activation = activation;
  m.radiance.sh_order = sh_order;
  std::vector<float> background(std::size_t(padded_width(4 + m.radiance.sh_count())), 0.0f);
  background[0] = kEmpty;
  m.radiance.raw = make_channels(make_dense_topology(lattice), int(background.size()), background.data());
  return m;
}

/// Gives it one motion level of so many cells, stored everywhere and zero. @pre the motion says what a row
/// holds
inline Channels& add_level(VoxelModel& m, int cells) {
  const std::vector<float> zero(std::size_t(m.motion.width()), 0.0f);
  m.motion.levels = {
      make_channels(make_dense_topology(make_lattice(m.box, cells)), int(zero.size()), zero.data())};
  return m.motion.levels[0];
}

}  // namespace splinevox::test
