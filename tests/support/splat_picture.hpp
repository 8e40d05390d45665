// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "io/splat/splat_file.hpp"
#include "math/rotation.hpp"
#include "math/sh.hpp"
#include "math/splat.hpp"
#include "splinevox/core/camera.hpp"
#include "splinevox/core/image.hpp"

namespace splinevox::test {

/// A square pinhole camera that looks at a place, z upwards.
inline Camera looking_at(const Vec3d& from, const Vec3d& at, int width, double focal) {
  Camera c;
  c.width = c.height = width;
  c.fx = c.fy = focal * width;
  c.cx = c.cy = 0.5 * width;
  const Vec3d back = normalize(from - at);
  const Vec3d right = normalize(cross(Vec3d{0, 0, 1}, back));
  c.axes = {right, cross(back, right), back};
  c.position = from;
  return c;
}

/// Splats as their renderers draw them (EWA splatting, sorted by depth), before white. Splats that are
/// smaller than a pixel are not blown up.
inline Image splat_picture(const SplatFile& file, const Camera& camera) {
  struct Drawn {
    double depth, x, y, inverse[3], opacity;
    Vec3d color;
    double reach;
  };
  std::vector<Drawn> all;
  for (std::size_t i = 0; i < file.size(); ++i) {
    Splat s;
    if (!file.read(i, s)) continue;
    const Vec3d seen = s.place - camera.position;
    const double x = dot(seen, camera.axes[0]), y = -dot(seen, camera.axes[1]),
                 z = -dot(seen, camera.axes[2]);
    if (z <= 1e-3) continue;
    const auto axes = axes_of(s.rotation);
    double cov[3] = {};
    for (int k = 0; k < 3; ++k) {
      const Vec3d axis = s.size[k] * axes[std::size_t(k)];
      const double ax = dot(axis, camera.axes[0]), ay = -dot(axis, camera.axes[1]),
                   az = -dot(axis, camera.axes[2]);
      const double u = camera.fx * (ax / z - x * az / (z * z)), v = camera.fy * (ay / z - y * az / (z * z));
      cov[0] += u * u;
      cov[1] += u * v;
      cov[2] += v * v;
    }
    const double det = cov[0] * cov[2] - cov[1] * cov[1];
    double basis[kMaxShCount];
    int order = 0;
    while ((order + 1) * (order + 1) < s.harmonics) ++order;
    sh_basis(order, normalize(seen), basis);
    Vec3d color{0.5, 0.5, 0.5};
    for (int j = 0; j < s.harmonics; ++j) color += splat_harmonic_sign(j) * basis[j] * s.color[j];
    for (int c = 0; c < 3; ++c) color[c] = std::max(0.0, color[c]);
    all.push_back({z,
                   camera.cx + camera.fx * x / z,
                   camera.cy + camera.fy * y / z,
                   {cov[2] / det, -cov[1] / det, cov[0] / det},
                   s.opacity,
                   color,
                   3.5 * std::sqrt(std::max(cov[0], cov[2]))});
  }
  std::stable_sort(all.begin(), all.end(), [](const Drawn& a, const Drawn& b) { return a.depth < b.depth; });
  Image out(camera.width, camera.height, 3);
  std::vector<double> through(out.pixels(), 1.0);
  for (const Drawn& d : all)
    for (int j = std::max(0, int(d.y - d.reach)); j <= std::min(camera.height - 1, int(d.y + d.reach)); ++j)
      for (int i = std::max(0, int(d.x - d.reach)); i <= std::min(camera.width - 1, int(d.x + d.reach));
           ++i) {
        const double u = i + 0.5 - d.x, v = j + 0.5 - d.y;
        const double square = d.inverse[0] * u * u + 2 * d.inverse[1] * u * v + d.inverse[2] * v * v;
        const double alpha = std::min(kMostOpacity, d.opacity * std::exp(-square / 2));
        if (alpha < kLeastOpacity) continue;
        const std::size_t pixel = std::size_t(j) * std::size_t(camera.width) + std::size_t(i);
        for (std::size_t c = 0; c < 3; ++c)
          out.data[3 * pixel + c] += float(through[pixel] * alpha * d.color[int(c)]);
        through[pixel] *= 1 - alpha;
      }
  for (std::size_t p = 0; p < through.size(); ++p)
    for (std::size_t c = 0; c < 3; ++c) out.data[3 * p + c] += float(through[p]);
  return out;
}

}  // namespace splinevox::test
