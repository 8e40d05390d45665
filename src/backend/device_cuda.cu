// SPDX-License-Identifier: Apache-2.0
#include <cuda_runtime.h>

#include <string>

#include "backend/cuda.hpp"

namespace splinevox::cuda {
namespace {

/// Only there to ask the driver whether it can run this build's code.
__global__ void probe_kernel() {}

}  // namespace

CudaFound find() {
  CudaFound found;
  found.built = true;
  int count = 0;
  cudaError_t code = cudaGetDeviceCount(&count);
  if (code == cudaSuccess && count == 0) code = cudaErrorNoDevice;
  cudaDeviceProp device{};
  cudaFuncAttributes attributes;
  if (code == cudaSuccess) code = cudaGetDeviceProperties(&device, 0);
  if (code == cudaSuccess) code = cudaFuncGetAttributes(&attributes, probe_kernel);
  if (code != cudaSuccess) {
    cudaGetLastError();  // or the next call would report it again
    found.reason = cudaGetErrorString(code);
    return found;
  }
  found.usable = true;
  found.name = std::string(device.name) + " (sm_" + std::to_string(10 * device.major + device.minor) + ", " +
               std::to_string(device.totalGlobalMem / 1'000'000'000) + " GB)";
  return found;
}

}  // namespace splinevox::cuda
