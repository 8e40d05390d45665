// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "splinevox/field/model.hpp"

namespace splinevox {

/// How much matter there is when there is least, as a share of that when there is most, in [0, 1], where a
/// model changes: in cells, 48 along the longest edge of its box, whose alpha differs by more than a half
/// between two of twelve moments. What moves is elsewhere and no less; what enters or leaves is not. Means
/// over three moments in a row count, because one moment of a short fit is noise. 1 where nothing changes.
double least_matter(const VoxelModel& model);

}  // namespace splinevox
