// SPDX-License-Identifier: Apache-2.0
#include <cuda_runtime.h>

#include <string>

#include "backend/cuda.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::cuda {
namespace {

/// Only there to ask the driver whether it can run this build's code.
__global__ void probe_kernel() {}

}  // namespace

void take(int local) {
  int count = 0;
  if (cudaGetDeviceCount(&count) == cudaSuccess && count > 1 && local >= count)
    fail({"--device", "there are more processes on this machine than CUDA devices",
          std::to_string(count) + " at most", std::to_string(local + 1) + " or more",
          "fewer processes a machine, or --device cpu"});
  if (count > 1) cudaSetDevice(local);
  cudaGetLastError();  // find() tells
}

CudaFound find() {
  CudaFound found;
  found.built = true;
  int count = 0, own = 0;
  cudaError_t code = cudaGetDeviceCount(&count);
  if (code == cudaSuccess && count == 0) code = cudaErrorNoDevice;
  cudaDeviceProp device{};
  cudaFuncAttributes attributes;
  if (code == cudaSuccess) code = cudaGetDevice(&own);
  if (code == cudaSuccess) code = cudaGetDeviceProperties(&device, own);
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
