// SPDX-License-Identifier: Apache-2.0
#include "data/layouts/axes.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "data/message_text.hpp"
#include "math/nearest_point.hpp"

namespace splinevox::data {
namespace {

using Matrix = std::array<double, 16>;

Eigen::Matrix3d turn_of_matrix(const Matrix& m) {
  Eigen::Matrix3d turn;
  turn << m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10];
  return turn;
}

/// The factor of a matrix that is a rotation times a factor.
double scale_of(const Matrix& m) { return std::cbrt(std::abs(turn_of_matrix(m).determinant())); }

/// The share of cameras that look towards the point nearest to all their axes with the third axis backwards;
/// nothing if there is no such point.
std::optional<double> looking_backwards(const std::vector<Matrix>& cameras) {
  NearestPoint nearest;
  for (const Matrix& m : cameras) nearest.add(turn_of_matrix(m).col(2).normalized(), {m[3], m[7], m[11]});
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(nearest.across);
  constexpr double kParallel = 0.01;
  if (cameras.size() < 3 || !(solver.eigenvalues()[0] > kParallel * double(cameras.size()))) return {};
  const Eigen::Vector3d middle = nearest.solve();
  std::size_t backwards = 0;
  for (const Matrix& m : cameras)
    backwards += (Eigen::Vector3d(m[3], m[7], m[11]) - middle).dot(turn_of_matrix(m).col(2)) > 0 ? 1 : 0;
  return double(backwards) / double(cameras.size());
}

/// Whether the second axes point along a positive axis of the world, on the whole; nothing if they do
/// neither.
std::optional<bool> upright(const std::vector<Matrix>& cameras) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Matrix& m : cameras) mean += turn_of_matrix(m).col(1) / double(cameras.size());
  Eigen::Index axis = 0;
  constexpr double kSome = 0.3;
  if (!(mean.cwiseAbs().maxCoeff(&axis) > kSome)) return {};
  return mean[axis] > 0;
}

}  // namespace

std::string take_last_rows(std::vector<Matrix>& matrices) {
  constexpr double kTolerance = 1e-3;
  if (matrices.empty()) return {};
  const double w = matrices[0][15];
  if (!(w > 0 && w < 1e12) || std::abs(w - 1) <= 1e-6) return {};
  bool as_they_stand = true, divided = true;
  for (const Matrix& m : matrices) {
    const bool same = m[12] == 0 && m[13] == 0 && m[14] == 0 && std::abs(m[15] - w) <= 1e-6 * w;
    const double scale = scale_of(m);
    as_they_stand &= same && std::abs(scale - 1) <= kTolerance;
    divided &= same && std::abs(scale / w - 1) <= kTolerance;
  }
  if (!as_they_stand && !divided) return {};
  for (Matrix& m : matrices) {
    if (divided)
      for (std::size_t i = 0; i < 12; ++i) m[i] /= w;
    m[15] = 1;
  }
  return "the last row of every matrix is 0 0 0 " + number(w) +
         (divided ? ": all were divided by it" : ": it is not read, positions are taken as they stand");
}

bool is_mirrored(const Matrix& matrix) { return turn_of_matrix(matrix).determinant() < 0; }

std::string mirrored_hint(const RawScene& scene) {
  std::vector<Matrix> cameras;
  for (const RawSplit& split : scene.splits)
    for (const RawFrame& frame : split.frames)
      if (is_mirrored(frame.matrix)) cameras.push_back(frame.matrix);
  const std::string wanted = "x must point right, y up, z backwards (OpenGL)";
  const std::optional<double> backwards = looking_backwards(cameras);
  const std::optional<bool> up = upright(cameras);
  if (!backwards || !up || (*backwards > 0.1 && *backwards < 0.9))
    return "flip one axis: " + wanted + "; these cameras do not tell which";
  const bool forwards = *backwards <= 0.1;
  if (forwards && *up) return "the third column seems to point forwards: negate it; " + wanted;
  if (!forwards && !*up) return "the second column seems to point down: negate it; " + wanted;
  if (forwards)
    return "the columns seem to point down and forwards (OpenCV) in a left-handed world: negate the second "
           "and "
           "third column, then one row of all matrices; " +
           wanted;
  return "the world seems to be left-handed (Unity, Unreal): negate one row of all matrices, such as the "
         "third; "
         "or, if it is not, the first column points left: negate it; " +
         wanted;
}

}  // namespace splinevox::data
