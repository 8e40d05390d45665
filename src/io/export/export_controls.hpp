// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "core/atomic_file.hpp"
#include "splinevox/field/model.hpp"

namespace splinevox {

/// Writes the motion as grids that a rig can be built on: `control_1`, ... (Vec3s, scene units; `control_0`
/// only where the first point is free, otherwise it is 0) and, where the model has it, `rigidity` in [0, 1],
/// float, on the motion lattice. The matter at x and time t is what the canonical volume holds at x +
/// rigidity(x) sum_k B_k(t) control_k(x), with B the basis that the grids' metadata names; a `time_curve`
/// there gives the parameter for t. Throws Error: see check_controls; Fault::output if the file cannot be
/// written.
FileDigest write_controls(const std::string& path, const VoxelModel& model);

/// Throws Error (Fault::input) naming --controls if nothing moves.
void check_controls(const VoxelModel& model);

}  // namespace splinevox
