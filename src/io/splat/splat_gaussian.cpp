// SPDX-License-Identifier: Apache-2.0
#include "io/splat/splat_gaussian.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "math/rotation.hpp"
#include "math/sh.hpp"
#include "math/sphere_rule.hpp"
#include "math/splat.hpp"
#include "splinevox/field/lattice.hpp"

namespace splinevox {
namespace {

constexpr double kThinnest = 1 / 8.0;  ///< voxels
constexpr int kMostPoints = 16;        ///< along an edge of a voxel

/// The share of a normal distribution below x standard deviations.
double below(double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); }

/// The first and the last voxel of a brick's axis that a Gaussian reaches, counted in the brick.
struct Span {
  int first, last;
};
Span span_of(const LatticeGaussian& g, Int3 corner, int axis) {
  return {std::max(0, g.lo[axis] - corner[axis]), std::min(kBrick - 1, g.hi[axis] - corner[axis])};
}

std::size_t voxel_of(const int (&at)[3]) { return std::size_t(at[0] << 6 | at[1] << 3 | at[2]); }

void add(const LatticeGaussian& g, double depth, std::size_t voxel, BrickSums& sums) {
  sums.depth[voxel] += depth;
  for (int c = 0; c < 3; ++c) sums.color[voxel][c] += depth * double(g.color[c]);
}

/// A Gaussian along the axes.
void add_product(const LatticeGaussian& g, Int3 corner, BrickSums& sums) {
  double share[3][kBrick];
  Span span[3];
  for (int a = 0; a < 3; ++a) {
    span[a] = span_of(g, corner, a);
    const double sharp = 1 / std::sqrt(g.covariance[a][a]);
    double before = below((corner[a] + span[a].first - 0.5 - g.mean[a]) * sharp);
    for (int i = span[a].first; i <= span[a].last; ++i) {
      const double after = below((corner[a] + i + 0.5 - g.mean[a]) * sharp);
      share[a][i] = after - before;
      before = after;
    }
  }
  int at[3];
  for (at[0] = span[0].first; at[0] <= span[0].last; ++at[0])
    for (at[1] = span[1].first; at[1] <= span[1].last; ++at[1])
      for (at[2] = span[2].first; at[2] <= span[2].last; ++at[2])
        add(g, g.mass * share[0][at[0]] * share[1][at[1]] * share[2][at[2]], voxel_of(at), sums);
}

/// Any Gaussian, as its distribution over two axes times that along the third given these two.
class Columns {
 public:
  explicit Columns(const LatticeGaussian& g) : g_(g) {
    // The third axis is that with the largest entry of the inverse: the variance given the others is
    // smallest.
    double largest = 0;
    for (int a = 0; a < 3; ++a) {
      const int b = (a + 1) % 3, c = (a + 2) % 3;
      const double minor = g.covariance[b][b] * g.covariance[c][c] - g.covariance[b][c] * g.covariance[b][c];
      if (minor <= largest) continue;
      largest = minor;
      a_ = a;
      b_ = b;
      c_ = c;
    }
    const double bb = g.covariance[b_][b_], cc = g.covariance[c_][c_], bc = g.covariance[b_][c_];
    const double ab = g.covariance[a_][b_], ac = g.covariance[a_][c_];
    inverse_bb_ = cc / largest;
    inverse_cc_ = bb / largest;
    inverse_bc_ = -bc / largest;
    by_b_ = ab * inverse_bb_ + ac * inverse_bc_;
    by_c_ = ab * inverse_bc_ + ac * inverse_cc_;
    sharp_ = 1 / std::sqrt(g.covariance[a_][a_] - ab * by_b_ - ac * by_c_);
    scale_ = g.mass / (2 * std::numbers::pi * std::sqrt(largest));
    // Two to the standard deviation of one axis given the other.
    points_b_ = points(1 / std::sqrt(inverse_bb_));
    points_c_ = points(1 / std::sqrt(inverse_cc_));
  }

  void add_to(Int3 corner, BrickSums& sums) const {
    const Span along = span_of(g_, corner, a_), second = span_of(g_, corner, b_),
               third = span_of(g_, corner, c_);
    int at[3];
    for (at[b_] = second.first; at[b_] <= second.last; ++at[b_])
      for (at[c_] = third.first; at[c_] <= third.last; ++at[c_])
        for (int p = 0; p < points_b_ * points_c_; ++p) {
          const double y = offset(corner[b_] + at[b_], p / points_c_, points_b_) - g_.mean[b_];
          const double z = offset(corner[c_] + at[c_], p % points_c_, points_c_) - g_.mean[c_];
          const double square = inverse_bb_ * y * y + 2 * inverse_bc_ * y * z + inverse_cc_ * z * z;
          if (square > 2 * kGaussianReach * kGaussianReach) continue;
          const double height = scale_ * std::exp(-square / 2) / (points_b_ * points_c_);
          const double middle = g_.mean[a_] + by_b_ * y + by_c_ * z;
          double before = below((corner[a_] + along.first - 0.5 - middle) * sharp_);
          for (at[a_] = along.first; at[a_] <= along.last; ++at[a_]) {
            const double after = below((corner[a_] + at[a_] + 0.5 - middle) * sharp_);
            add(g_, height * (after - before), voxel_of(at), sums);
            before = after;
          }
        }
  }

 private:
  static int points(double deviation) { return std::clamp(int(std::ceil(2 / deviation)), 2, kMostPoints); }
  static double offset(int voxel, int point, int points) { return voxel - 0.5 + (point + 0.5) / points; }

  const LatticeGaussian& g_;
  int a_ = 0, b_ = 1, c_ = 2;
  double inverse_bb_, inverse_cc_, inverse_bc_;  ///< of the covariance of the two axes
  double by_b_, by_c_;                           ///< how the mean of the third follows them
  double sharp_, scale_;
  int points_b_, points_c_;
};

}  // namespace

Vec3d mean_color(const Splat& splat) {
  Vec3d sum{};
  int order = 0;
  while ((order + 1) * (order + 1) < splat.harmonics) ++order;
  for (const SpherePoint& point : sphere_rule()) {
    double y[kMaxShCount];
    sh_basis(order, point.direction, y);
    Vec3d color{0.5, 0.5, 0.5};
    for (int j = 0; j < splat.harmonics; ++j) color += splat_harmonic_sign(j) * y[j] * splat.color[j];
    for (int c = 0; c < 3; ++c) sum[c] += point.weight * std::max(0.0, color[c]);
    if (order == 0) return {std::max(0.0, color.x), std::max(0.0, color.y), std::max(0.0, color.z)};
  }
  return sum;
}

LatticeGaussian on_lattice(const Splat& splat, const Vec3d& color, double spacing) {
  LatticeGaussian g;
  g.color = cast<float>(color);
  const std::array<Vec3d, 3> axes = axes_of(splat.rotation);
  double size[3] = {splat.size.x / spacing, splat.size.y / spacing, splat.size.z / spacing};
  double sorted[3] = {size[0], size[1], size[2]};
  std::sort(std::begin(sorted), std::end(sorted));
  g.mass = splat_cross_section(std::min(splat.opacity, kMostOpacity), sorted[2], sorted[1]);
  for (int a = 0; a < 3; ++a) {
    g.mean[a] = splat.place[a] / spacing;
    for (int b = 0; b < 3; ++b)
      for (int k = 0; k < 3; ++k)
        g.covariance[a][b] += axes[std::size_t(k)][a] * axes[std::size_t(k)][b] * size[k] * size[k];
    g.covariance[a][a] += kThinnest * kThinnest;
  }
  for (int a = 0; a < 3; ++a) {
    const double reach = kGaussianReach * std::sqrt(g.covariance[a][a]);
    const auto voxel = [](double v) { return int(std::clamp(std::round(v), -1e9, 1e9)); };
    g.lo[a] = voxel(g.mean[a] - reach);
    g.hi[a] = voxel(g.mean[a] + reach);
  }
  return g;
}

void add_to_brick(const LatticeGaussian& g, Int3 corner, BrickSums& sums) {
  const double largest = std::max({g.covariance[0][0], g.covariance[1][1], g.covariance[2][2]});
  const double aside =
      std::max({std::abs(g.covariance[0][1]), std::abs(g.covariance[0][2]), std::abs(g.covariance[1][2])});
  if (aside < 1e-6 * largest)
    add_product(g, corner, sums);
  else
    Columns(g).add_to(corner, sums);
}

}  // namespace splinevox
