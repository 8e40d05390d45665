// SPDX-License-Identifier: Apache-2.0
#include "io/splat/voxel_splats.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/parallel.hpp"
#include "io/model/exact_text.hpp"
#include "io/splat/spz.hpp"
#include "math/sh.hpp"
#include "math/sphere_rule.hpp"
#include "math/splat.hpp"
#include "math/view_factor.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/field/lattice.hpp"

namespace splinevox {
namespace {

/// Where a voxel of one grid is in another of the same transform.
class LeafFinder {
 public:
  explicit LeafFinder(const VdbGrid& grid) : grid_(grid) {
    for (std::size_t l = 0; l < grid.leaves.size(); ++l) order_.push_back(l);
    std::sort(order_.begin(), order_.end(),
              [&](std::size_t a, std::size_t b) { return before(grid.leaves[a], grid.leaves[b]); });
  }
  /// The values of a leaf, or null.
  const float* leaf(Int3 at) const {
    const auto found = std::lower_bound(order_.begin(), order_.end(), at, [&](std::size_t l, const Int3& v) {
      return before(grid_.leaves[l], v);
    });
    if (found == order_.end() || !(grid_.leaves[*found] == at)) return nullptr;
    return grid_.values.data() + *found * std::size_t(kBrickRows * grid_.width);
  }

 private:
  static bool before(const Int3& a, const Int3& b) {
    return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z;
  }
  const VdbGrid& grid_;
  std::vector<std::size_t> order_;
};

/// From the frame's axes to those asked for.
template <class T>
Vec3T<T> turned(const Vec3T<T>& v, SplatAxes axes) {
  return axes == SplatAxes::scene ? v : Vec3T<T>{v.x, v.z, -v.y};
}

/// Harmonics of the view rescale 1 - sigmoid(sum_j sh_j Y_j(d)) / 2 itself, up to the same order, in the axes
/// asked for.
class RescaleHarmonics {
 public:
  RescaleHarmonics(int order, SplatAxes axes) : count_((order + 1) * (order + 1)) {
    for (const SpherePoint& point : sphere_rule()) {
      double y[kMaxShCount];
      sh_basis(order, point.direction, y);
      weights_.push_back(4 * std::numbers::pi * point.weight);
      basis_.insert(basis_.end(), y, y + count_);
      sh_basis(order, turned(point.direction, axes), y);
      turned_.insert(turned_.end(), y, y + count_);
    }
  }
  void of(const float* sh, double* out) const {
    std::fill_n(out, count_, 0.0);
    for (std::size_t p = 0; p < weights_.size(); ++p) {
      const double* y = basis_.data() + p * std::size_t(count_);
      double q = 0;
      for (int j = 0; j < count_; ++j) q += double(sh[j]) * y[j];
      const double factor = weights_[p] * view_factor(q).value;
      const double* to = turned_.data() + p * std::size_t(count_);
      for (int j = 0; j < count_; ++j) out[j] += factor * to[j];
    }
  }

 private:
  int count_;
  std::vector<double> weights_, basis_, turned_;
};

/// Colours of a voxel's splat.
void put_harmonics(const float* color, const double* rescale, int count, float* out) {
  for (int c = 0; c < 3; ++c) {
    for (int j = 0; j < count; ++j)
      out[3 * j + c] = float(splat_harmonic_sign(j) * double(color[c]) * rescale[j]);
    out[c] -= float(0.5 / kSh0);
  }
}

}  // namespace

void check_spz_size(double spacing) {
  if (const double size = kSplatSize * spacing; !spz_has(size))
    fail({.where = "--profile spz",
          .what = "the format has no splats of the size of these voxels",
          .expected = "a size from 4.6e-5 to 370",
          .got = exact_text<double>({size}),
          .hint = "--profile splats, or a data set in another unit (convert --scale)"});
}

VoxelSplats voxel_splats(const VdbFile& frame, int sh_order, SplatAxes axes) {
  const VdbGrid &density = frame.grids[0], &color = frame.grids[1];
  VoxelSplats out;
  const double size = kSplatSize * density.spacing;
  out.size = spz_scale(size);
  if (axes == SplatAxes::upright) check_spz_size(density.spacing);
  if (!spz_has(size)) out.size = size;  // none is so small or so large: a PLY has it all the same
  out.degree = std::max(0, sh_order);
  const LeafFinder colors(color);
  std::vector<LeafFinder> sh;
  const RescaleHarmonics harmonics(out.degree, axes);
  const int count = out.count();
  if (sh_order >= 0)
    for (std::size_t k = 0; k < std::size_t(count + 2) / 3; ++k) sh.emplace_back(frame.grids[2 + k]);

  const std::size_t leaves = density.leaves.size();
  std::vector<VoxelSplats> of_leaf(leaves);
  parallel_for(int(leaves), [&](int leaf) {
    const auto l = std::size_t(leaf);
    const Int3 corner = density.leaves[l];
    const float* rgb = colors.leaf(corner);
    std::vector<const float*> coefficients;
    for (const LeafFinder& grid : sh) coefficients.push_back(grid.leaf(corner));
    for (int i = 0; i < kBrickRows; ++i) {
      if (!(density.active[l * 8 + std::size_t(i >> 6)] >> (i & 63) & 1)) continue;
      const double sigma = double(density.values[l * kBrickRows + std::size_t(i)]);
      const double opacity = voxel_splat_opacity(sigma, density.spacing, out.size);
      if (opacity < kLeastOpacity) continue;
      const Int3 v = corner + Int3{i >> 6, i >> 3 & 7, i & 7};
      const Vec3d place = density.origin + density.spacing * cast<double>(v);
      of_leaf[l].places.push_back(cast<float>(turned(place, axes)));
      of_leaf[l].opacities.push_back(float(opacity));
      double rescale[kMaxShCount] = {1 / kSh0};  // of a rescale that is 1 everywhere
      if (sh_order >= 0) {
        float q[kMaxShCount];
        for (int j = 0; j < count; ++j) q[j] = coefficients[std::size_t(j / 3)][3 * i + j % 3];
        harmonics.of(q, rescale);
      }
      auto& values = of_leaf[l].harmonics;
      values.resize(values.size() + std::size_t(3 * count));
      put_harmonics(rgb + 3 * i, rescale, count, values.data() + values.size() - std::size_t(3 * count));
    }
  });
  const auto append = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
  for (const VoxelSplats& part : of_leaf) {
    append(out.places, part.places);
    append(out.opacities, part.opacities);
    append(out.harmonics, part.harmonics);
  }
  return out;
}

}  // namespace splinevox
