// SPDX-License-Identifier: Apache-2.0
#include "backend/cuda.hpp"

namespace splinevox::cuda {

void take(int) {}
CudaFound find() { return {false, false, "", "a build without CUDA"}; }
std::unique_ptr<PictureMaker> make_pictures(const VoxelModel&) { return nullptr; }
std::unique_ptr<StepBackend> make_step(bool, Ranks*) { return nullptr; }

}  // namespace splinevox::cuda
