// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "splinevox/core/vec3.hpp"

namespace splinevox::run {

/// Points of a table with the columns x, y, z and, if present, time and id, in any order, among others that
/// are ignored.
struct PointTable {
  std::vector<Vec3> position;   ///< [rows] scene units
  std::vector<double> time;     ///< [rows] model time, 0 to 1, or empty
  std::vector<std::string> id;  ///< [rows] or empty
};

/// Reads comma-separated values with one line of names first; quotes are not supported. Empty lines and lines
/// that begin with # are passed over. Throws Error (input) naming line and column: a name missing or twice, a
/// field too few, no number, not finite, a time that the model does not have.
PointTable read_points(const std::string& path);

}  // namespace splinevox::run
