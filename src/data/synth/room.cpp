// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "data/synth/paint.hpp"
#include "data/synth/scene.hpp"

namespace splinevox::data {
namespace {

constexpr double kSkirting = 0.12;  ///< height of the board along the walls

Vec3d tiles(double u, double v, const Vec3d& m) {
  const double gap = std::max(bands(u, 0.5, 0.03), bands(v, 0.5, 0.03));
  const Vec3d tile =
      mix(mix(rgb(0x9a8f7d), rgb(0x6f7f86), checks(u / 0.5, v / 0.5)), rgb(0x5a534a), 0.5 * cloud(5.0 * m));
  return mix(tile, rgb(0x3c3a36), gap);
}

/// Stripes of a paper with a border on the walls, tiles on the floor, plaster on the ceiling.
Vec3d wallpaper(const Vec3d& m) {
  const Vec3d& half = kRoomHalf;
  const double up = m.z + half.z;
  if (half.z + m.z < 1e-4) return tiles(m.x, m.y, m);
  if (half.z - m.z < 1e-4) return mix(rgb(0xc9c4b8), rgb(0xb0aba0), cloud(3.0 * m));
  const bool along_x = half.y - std::abs(m.y) < half.x - std::abs(m.x);
  const double u = along_x ? m.x : m.y;
  const Vec3d ground = along_x ? rgb(m.y > 0 ? 0x7d8f69 : 0xa37b5c) : rgb(m.x > 0 ? 0x6c7fa0 : 0xa08a4e);
  Vec3d c = mix(ground, 0.72 * ground, bands(u, 0.46, 0.4));
  c = mix(c, rgb(0xe2d8c0), 0.8 * dots(u / 0.46, up / 0.4, 0.16));
  c = mix(c, rgb(0x54402f), edge(kSkirting - up));
  return mix(c, 0.8 * c, cloud(6.0 * m));
}

Vec3d planks(const Vec3d& m) {
  const Vec3d wood = mix(rgb(0xa9824f), rgb(0x7c5a32), cloud({4 * m.x, 4 * m.y, 18 * m.z}));
  return mix(wood, rgb(0x39291a), bands(m.z, 0.125, 0.1));
}

Vec3d marble(const Vec3d& m) {
  const Vec3d c = mix(rgb(0xc4c8cc), rgb(0x7d8790), cloud(7.0 * m));
  return mix(c, rgb(0x9d4b3a), bands(m.z, 0.6, 0.15));
}

}  // namespace

void add_room(Bodies& bodies) {
  const double floor = kRoomMiddle.z - kRoomHalf.z;
  bodies.push_back({make_room(kRoomHalf), still(shift(0, 0, kRoomMiddle.z)), wallpaper});
  bodies.push_back({make_box({0.26, 0.22, 0.25}, 0.02),
                    still(shift(1.5, 1.1, floor + 0.25) * rotate(turn_z(0.5))), planks});
  bodies.push_back({make_box({0.2, 0.3, 0.2}, 0.02),
                    still(shift(-1.6, -0.9, floor + 0.2) * rotate(turn_z(-0.3))), planks});
  bodies.push_back({make_disc(0.22, kRoomHalf.z, 0.02), still(shift(-2.3, 2.3, kRoomMiddle.z)), marble});
}

}  // namespace splinevox::data
