// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Cholesky>

namespace splinevox {

/// The point with the smallest sum of squared distances to lines: the x of sum (I - d d^T) x = sum (I - d
/// d^T) p. Nearly singular where all lines are nearly parallel.
struct NearestPoint {
  Eigen::Matrix3d across = Eigen::Matrix3d::Zero();
  Eigen::Vector3d through = Eigen::Vector3d::Zero();

  /// @param direction  d, of length 1 @param position  p, of any point of the line @param weight  of its
  /// squared distance
  void add(const Eigen::Vector3d& direction, const Eigen::Vector3d& position, double weight = 1) {
    const Eigen::Matrix3d off = weight * (Eigen::Matrix3d::Identity() - direction * direction.transpose());
    across += off;
    through += off * position;
  }
  /// Adds weight |x - position|^2 to the sum. A small weight makes it the answer where no line tells another.
  void hold(const Eigen::Vector3d& position, double weight) {
    across += weight * Eigen::Matrix3d::Identity();
    through += weight * position;
  }
  Eigen::Vector3d solve() const { return across.ldlt().solve(through); }
};

}  // namespace splinevox
