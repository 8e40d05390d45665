// SPDX-License-Identifier: Apache-2.0
#include "backend/cuda.hpp"
#include "backend/executor_cuda.cuh"
#include "backend/peers_cuda.cuh"
#include "backend/step_impl.hpp"

namespace splinevox::cuda {

std::unique_ptr<StepBackend> make_step(bool deterministic, Ranks* ranks) {
  return std::make_unique<Steps<CudaExecutor, CudaPeers>>(deterministic, ranks);
}

}  // namespace splinevox::cuda
