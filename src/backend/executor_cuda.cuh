// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cuda_runtime.h>

#include <cstddef>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>

#include "backend/team_cuda.cuh"
#include "splinevox/core/error.hpp"

namespace splinevox {

/// Throws Error where a CUDA call failed. @param what  what was being done
inline void check_cuda(cudaError_t code, const char* what) {
  if (code == cudaSuccess) return;
  const bool memory = code == cudaErrorMemoryAllocation;
  throw Error({"CUDA", std::string(what) + " failed", "", std::string(cudaGetErrorName(code)) + ": " + cudaGetErrorString(code),
               memory ? "a smaller preset, coarser lattices (--set grid...), or --device cpu" : "--device cpu; compute-sanitizer says more"},
              Fault::output);
}

/// One kernel thread per element.
template <class Kernel>
__global__ void __launch_bounds__(256) each_kernel(std::size_t n, const __grid_constant__ Kernel kernel) {
  const std::size_t i = blockIdx.x * std::size_t(blockDim.x) + threadIdx.x;
  if (i < n) kernel(i);
}

inline constexpr int kTeamsPerBlock = 4;

/// One warp per element, each with scratch of its own in shared memory.
template <class Kernel>
__global__ void __launch_bounds__(kTeamsPerBlock * kLanes, 2) team_kernel(int n, const __grid_constant__ Kernel kernel, unsigned scratch_bytes) {
  extern __shared__ __align__(16) char scratch[];
  const int within = int(threadIdx.x) / kLanes, i = int(blockIdx.x) * kTeamsPerBlock + within;
  if (i < n) kernel(i, DeviceTeam(scratch + within * scratch_bytes));
}

struct DestroyGraph {
  void operator()(cudaGraph_t graph) const { cudaGraphDestroy(graph); }
  void operator()(cudaGraphExec_t graph) const { cudaGraphExecDestroy(graph); }
};
using RecordedGraph = std::unique_ptr<std::remove_pointer_t<cudaGraph_t>, DestroyGraph>;
using ReadyGraph = std::unique_ptr<std::remove_pointer_t<cudaGraphExec_t>, DestroyGraph>;

/// HostExecutor's counterpart: a stream of one device. Nothing but download waits.
class CudaExecutor {
 public:
  CudaExecutor() { check_cuda(cudaStreamCreateWithFlags(&stream_, cudaStreamNonBlocking), "making a stream"); }
  ~CudaExecutor() { cudaStreamDestroy(stream_); }
  CudaExecutor(const CudaExecutor&) = delete;
  CudaExecutor& operator=(const CudaExecutor&) = delete;

  template <class T>
  class Buffer {
   public:
    Buffer() = default;
    ~Buffer() { cudaFree(data_); }
    Buffer(Buffer&& other) noexcept : data_(std::exchange(other.data_, nullptr)), size_(std::exchange(other.size_, 0)), room_(std::exchange(other.room_, 0)) {}
    Buffer& operator=(Buffer&& other) noexcept {
      std::swap(data_, other.data_), std::swap(size_, other.size_), std::swap(room_, other.room_);
      return *this;
    }
    T* data() { return data_; }
    const T* data() const { return data_; }
    std::size_t size() const { return size_; }

   private:
    friend CudaExecutor;
    T* data_ = nullptr;
    std::size_t size_ = 0, room_ = 0;
  };

  /// As HostExecutor's. cudaFree waits for the device, so growing is for between steps; shrinking keeps the memory.
  template <class T>
  void resize(Buffer<T>& buffer, std::size_t n) {
    if (n > buffer.room_) {
      check_cuda(cudaStreamSynchronize(stream_), "waiting");
      cudaFree(buffer.data_);
      buffer.data_ = nullptr, buffer.size_ = buffer.room_ = 0;
      check_cuda(cudaMalloc(reinterpret_cast<void**>(&buffer.data_), n * sizeof(T)), "taking memory of the device");
      buffer.room_ = n;
    }
    buffer.size_ = n;
  }
  template <class T>
  void zero(Buffer<T>& buffer) {
    if (buffer.size_ > 0) check_cuda(cudaMemsetAsync(buffer.data_, 0, buffer.size_ * sizeof(T), stream_), "clearing memory");
  }
  /// From pageable memory the copy is staged before this returns, so `from` may change at once.
  template <class T>
  void upload(Buffer<T>& to, const T* from, std::size_t n) {
    resize(to, n);
    if (n > 0) check_cuda(cudaMemcpyAsync(to.data_, from, n * sizeof(T), cudaMemcpyHostToDevice, stream_), "copying to the device");
  }
  template <class T>
  void download(const Buffer<T>& from, T* to) {
    if (from.size_ > 0) check_cuda(cudaMemcpyAsync(to, from.data_, from.size_ * sizeof(T), cudaMemcpyDeviceToHost, stream_), "copying from the device");
    check_cuda(cudaStreamSynchronize(stream_), "a kernel");
  }

  /// What `queue` queues, as one graph with one launch in place of each kernel's own. The graph of the time before is kept and only its
  /// numbers are changed, where the kernels are the same ones. `queue` must neither wait nor take memory.
  template <class Queue>
  void together(Queue&& queue) {
    check_cuda(cudaStreamBeginCapture(stream_, cudaStreamCaptureModeRelaxed), "recording a step");
    cudaGraph_t recorded = nullptr;
    try {
      queue();
    } catch (...) {  // the stream has to be as it was
      cudaStreamEndCapture(stream_, &recorded);
      RecordedGraph{recorded};
      throw;
    }
    check_cuda(cudaStreamEndCapture(stream_, &recorded), "recording a step");
    const RecordedGraph graph(recorded);
    cudaGraphExecUpdateResultInfo why{};
    if (ready_ && cudaGraphExecUpdate(ready_.get(), graph.get(), &why) != cudaSuccess) {
      cudaGetLastError();  // other kernels than before: no error, but a graph to be made anew
      ready_.reset();
    }
    if (!ready_) {
      cudaGraphExec_t made = nullptr;
      check_cuda(cudaGraphInstantiate(&made, graph.get(), 0), "making a step's graph");
      ready_.reset(made);
    }
    check_cuda(cudaGraphLaunch(ready_.get(), stream_), "starting a step");
  }

  template <class Kernel>
  void for_each(const Kernel& kernel) {
    const std::size_t n = kernel.count();
    if (n == 0) return;
    each_kernel<<<unsigned((n + 255) / 256), 256, 0, stream_>>>(n, kernel);
    check_cuda(cudaGetLastError(), "starting a kernel");
  }
  template <class Kernel>
  void for_teams(int n, const Kernel& kernel, std::size_t scratch_bytes) {
    if (n == 0) return;
    scratch_bytes = (scratch_bytes + 15) / 16 * 16;
    const std::size_t shared = kTeamsPerBlock * scratch_bytes;
    if (shared > kSharedByDefault)
      check_cuda(cudaFuncSetAttribute(team_kernel<Kernel>, cudaFuncAttributeMaxDynamicSharedMemorySize, int(shared)),
                 "asking for shared memory (rays with very many samples)");
    team_kernel<<<unsigned((n + kTeamsPerBlock - 1) / kTeamsPerBlock), kTeamsPerBlock * kLanes, shared, stream_>>>(n, kernel, unsigned(scratch_bytes));
    check_cuda(cudaGetLastError(), "starting a kernel");
  }

 private:
  static constexpr std::size_t kSharedByDefault = 48 * 1024;
  cudaStream_t stream_ = nullptr;
  ReadyGraph ready_;
};

}  // namespace splinevox
