// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "splinevox/core/vec3.hpp"

namespace splinevox {

/// Turns the view-dependent rescale of a voxel's colour into one number, for programs that know no view
/// dependence.
class ViewBake {
 public:
  /// @param spec  "mean": average over the sphere by the Lebedev rule of 26 points, exact to degree 7 (band 0
  /// before the
  ///              sigmoid is not the mean); "none": 1; "dir=x,y,z": the value for rays in that direction.
  /// @param sh_order  of the model; -1: the factor is 1 whatever the spec.
  /// Throws Error (Fault::input) if the spec is malformed.
  ViewBake(const std::string& spec, int sh_order);
  float factor(const float* sh) const;

 private:
  int count_ = 0;               ///< coefficients
  std::vector<float> weights_;  ///< per direction; empty: no view dependence
  std::vector<float> basis_;    ///< [directions * count_]
};

}  // namespace splinevox
