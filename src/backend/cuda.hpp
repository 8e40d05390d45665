// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "backend/pictures.hpp"
#include "backend/step.hpp"
#include "splinevox/backend/device.hpp"

/// What the .cu files offer; cuda_none.cpp stands in for them in a build without CUDA.
namespace splinevox::cuda {

/// Makes one of the devices this process sees that of the calling thread: the only one, or the one of that
/// number, if it is there.
void take(int local);
/// The calling thread's device.
CudaFound find();
std::unique_ptr<PictureMaker> make_pictures(const VoxelModel& model);
std::unique_ptr<StepBackend> make_step(bool deterministic, Ranks* ranks);

}  // namespace splinevox::cuda
