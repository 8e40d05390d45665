// SPDX-License-Identifier: Apache-2.0
#include "data/layouts/transforms_write.hpp"

#include <fmt/format.h>

namespace splinevox::data {

using Json = nlohmann::ordered_json;

Json lens_json(const Camera& c) {
  Json j{{"w", c.width}, {"h", c.height}, {"fl_x", c.fx}, {"fl_y", c.fy}, {"cx", c.cx}, {"cy", c.cy}};
  if (c.lens.kind == Distortion::Kind::none) return j;
  const bool fisheye = c.lens.kind == Distortion::Kind::fisheye;
  j["camera_model"] = fisheye ? "OPENCV_FISHEYE" : "OPENCV";
  for (std::size_t i = 0; i < 4; ++i) j[fmt::format("k{}", i + 1)] = c.lens.k[i];
  if (!fisheye) {
    j["p1"] = c.lens.p[0];
    j["p2"] = c.lens.p[1];
  }
  return j;
}

Json matrix_json(const std::array<double, 16>& m, const Vec3d& shift, double scale) {
  const double add[4] = {shift.x, shift.y, shift.z, 0}, times[4] = {scale, scale, scale, 1};
  Json matrix = Json::array();
  for (std::size_t row = 0; row < 4; ++row)
    matrix.push_back({m[4 * row], m[4 * row + 1], m[4 * row + 2], times[row] * (m[4 * row + 3] + add[row])});
  return matrix;
}

}  // namespace splinevox::data
