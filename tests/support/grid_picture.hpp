// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "io/vdb/vdb_file.hpp"
#include "splinevox/core/camera.hpp"
#include "splinevox/core/image.hpp"
#include "splinevox/field/lattice.hpp"

namespace splinevox::test {

/// A grid's voxels in one block of memory, to be read in between.
class DenseGrid {
 public:
  explicit DenseGrid(const VdbGrid& grid) : grid_(grid) {
    if (grid.leaves.empty()) return;
    lo_ = hi_ = grid.leaves[0];
    for (const Int3& leaf : grid.leaves)
      for (int a = 0; a < 3; ++a) {
        lo_[a] = std::min(lo_[a], leaf[a]);
        hi_[a] = std::max(hi_[a], leaf[a] + kBrick);
      }
    values_.resize(index({hi_.x - 1, hi_.y - 1, hi_.z - 1}) + std::size_t(grid.width), 0.0f);
    for (std::size_t l = 0; l < grid.leaves.size(); ++l)
      for (int i = 0; i < kBrickRows; ++i)
        std::copy_n(grid.values.data() + (l * kBrickRows + std::size_t(i)) * std::size_t(grid.width),
                    grid.width, values_.data() + index(grid.leaves[l] + Int3{i >> 6, i >> 3 & 7, i & 7}));
  }
  void at(const Vec3d& x, double* out) const {
    std::fill_n(out, grid_.width, 0.0);
    const Vec3d u = (1 / grid_.spacing) * (x - grid_.origin);
    const Int3 v{int(std::floor(u.x)), int(std::floor(u.y)), int(std::floor(u.z))};
    for (int k = 0; k < 8; ++k) {
      const Int3 corner = v + Int3{k >> 2, k >> 1 & 1, k & 1};
      double weight = 1;
      bool inside = true;
      for (int a = 0; a < 3; ++a) {
        weight *= 1 - std::abs(u[a] - corner[a]);
        inside = inside && corner[a] >= lo_[a] && corner[a] < hi_[a];
      }
      for (int c = 0; inside && c < grid_.width; ++c)
        out[c] += weight * double(values_[index(corner) + std::size_t(c)]);
    }
  }
  /// Where a ray is inside of the leaves' box. @return false: nowhere
  bool clip(const Ray& ray, double& near, double& far) const {
    for (int a = 0; a < 3; ++a) {
      const double s = grid_.origin[a] + grid_.spacing * (lo_[a] - 1),
                   e = grid_.origin[a] + grid_.spacing * hi_[a];
      const double first = (s - ray.origin[a]) / ray.direction[a],
                   last = (e - ray.origin[a]) / ray.direction[a];
      near = std::max(near, std::min(first, last));
      far = std::min(far, std::max(first, last));
    }
    return near < far;
  }

 private:
  std::size_t index(Int3 v) const {
    const Int3 at = v - lo_, n = hi_ - lo_;
    return ((std::size_t(at.x) * std::size_t(n.y) + std::size_t(at.y)) * std::size_t(n.z) +
            std::size_t(at.z)) *
           std::size_t(grid_.width);
  }
  const VdbGrid& grid_;
  Int3 lo_{}, hi_{};
  std::vector<float> values_;
};

/// What a ray marcher shows of grids density and color, before white: four samples a voxel.
inline Image grid_picture(const VdbFile& file, const Camera& camera) {
  const DenseGrid density(file.grids[0]), color(file.grids[1]);
  const double step = file.grids[0].spacing / 4;
  Image out(camera.width, camera.height, 3);
  for (int j = 0; j < camera.height; ++j)
    for (int i = 0; i < camera.width; ++i) {
      const double x = (i + 0.5 - camera.cx) / camera.fx, y = (j + 0.5 - camera.cy) / camera.fy;
      const Ray ray{camera.position, normalize(x * camera.axes[0] - y * camera.axes[1] - camera.axes[2])};
      float* pixel = out.data.data() + 3 * (std::size_t(j) * std::size_t(camera.width) + std::size_t(i));
      double through = 1, near = 0, far = 1e9;
      if (density.clip(ray, near, far))
        for (double s = near; s < far && through > 1e-4; s += step) {
          double sigma = 0, rgb[3];
          const Vec3d place = ray.origin + s * ray.direction;
          density.at(place, &sigma);
          if (sigma <= 0) continue;
          color.at(place, rgb);
          const double alpha = 1 - std::exp(-sigma * step);
          for (int c = 0; c < 3; ++c) pixel[c] += float(through * alpha * rgb[c]);
          through *= 1 - alpha;
        }
      for (int c = 0; c < 3; ++c) pixel[c] += float(through);
    }
  return out;
}

}  // namespace splinevox::test
