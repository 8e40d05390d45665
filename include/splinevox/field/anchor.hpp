// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "splinevox/field/edit_motion.hpp"

namespace splinevox {

/// Makes the first moment canonical: Delta(x, t = 0) = 0, and the scene looks as before at every time.
///
/// Subtracting the first displacement from every curve would do the first alone: the canonical volume has to
/// come along. It becomes what is shown at time 0, C'(y) = C(W_0(y)), and the curves lead to where that is,
/// W_0(x + Delta'(x, t)) = W_t(x), which is solved at many moments by inverting W_0 and fitted in the same
/// basis; then Delta'(x, 0), next to nothing, is taken off every curve. Without motion at time 0 this is the
/// subtraction. The light stays: its gain is that of a place in observed space.
/// @pre at most one motion level, model.motion.moves()
/// @return the distance between W_0(x + Delta') and W_t(x), which includes places whose canonical matter is
/// not shown at time 0
MotionDifference anchor_first(VoxelModel& model);

}  // namespace splinevox
