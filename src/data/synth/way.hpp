// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <random>

#include "splinevox/core/camera.hpp"

namespace splinevox::data {

/// 53 random bits as a number in [0, 1); the same on every standard library.
double draw_unit(std::mt19937_64& rng);

/// A smooth random course of a number over time: a few sines of drawn phases, slow ones the largest. Mean 0
/// and mean square 1 over all draws.
class Wander {
 public:
  explicit Wander(std::mt19937_64& rng);
  double at(double time) const;

 private:
  static constexpr int kSines = 6;  ///< one to six swings between time 0 and 1
  std::array<double, kSines> swings_, phase_;
};

/// How the hand that holds a camera trembles and walks.
class Hand {
 public:
  /// @param shake  share of the distance by which each axis of the position wanders; radians by which the
  /// direction turns about each axis
  Hand(double shake, std::mt19937_64& rng);
  /// @param distance  of the camera from what it looks at, scene units
  Camera hold(Camera camera, double distance, double time) const;

 private:
  double shake_;
  std::array<Wander, 3> position_, turn_;
};

}  // namespace splinevox::data
