// SPDX-License-Identifier: Apache-2.0
#include "backend/cuda.hpp"
#include "backend/executor_cuda.cuh"
#include "backend/pictures_impl.hpp"

namespace splinevox::cuda {

std::unique_ptr<PictureMaker> make_pictures(const VoxelModel& model) {
  return std::make_unique<Pictures<CudaExecutor>>(model);
}

}  // namespace splinevox::cuda
