// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cuda_runtime.h>

#include <algorithm>
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
  cudaGetLastError();  // or the next kernel would report it again
  const bool memory = code == cudaErrorMemoryAllocation;
  throw Error({"CUDA", std::string(what) + " failed", "",
               std::string(cudaGetErrorName(code)) + ": " + cudaGetErrorString(code),
               memory ? "a smaller preset, coarser lattices (--set grid...), or --device cpu"
                      : "--device cpu; compute-sanitizer says more"},
              Fault::output);
}

/// One kernel thread per element.
template <class Kernel>
__global__ void __launch_bounds__(256) each_kernel(std::size_t n, const __grid_constant__ Kernel kernel) {
  const std::size_t i = blockIdx.x * std::size_t(blockDim.x) + threadIdx.x;
  if (i < n) kernel(i);
}

inline constexpr int kTeamsPerBlock = 4;  ///< fewer where their scratch would not fit

/// One warp (a row of the block) per element, each with scratch of its own in shared memory.
template <class Kernel>
__global__ void __launch_bounds__(kTeamsPerBlock* kLanes, 2)
    team_kernel(int n, const __grid_constant__ Kernel kernel, unsigned scratch_bytes) {
  extern __shared__ __align__(16) char scratch[];
  const int i = int(blockIdx.x * blockDim.y + threadIdx.y);
  if (i < n) kernel(i, DeviceTeam(scratch + threadIdx.y * scratch_bytes));
}

struct DestroyGraph {
  void operator()(cudaGraph_t graph) const { cudaGraphDestroy(graph); }
  void operator()(cudaGraphExec_t graph) const { cudaGraphExecDestroy(graph); }
};
using RecordedGraph = std::unique_ptr<std::remove_pointer_t<cudaGraph_t>, DestroyGraph>;
using ReadyGraph = std::unique_ptr<std::remove_pointer_t<cudaGraphExec_t>, DestroyGraph>;

/// HostExecutor's counterpart: a stream of one device. Nothing but wait and download waits.
class CudaExecutor {
 public:
  CudaExecutor() {
    int device = 0, most = 0;
    check_cuda(cudaGetDevice(&device), "finding the device");
    check_cuda(cudaDeviceGetAttribute(&most, cudaDevAttrMaxSharedMemoryPerBlockOptin, device),
               "asking for its shared memory");
    most_shared_ = std::size_t(most);
    check_cuda(cudaStreamCreateWithFlags(&stream_, cudaStreamNonBlocking), "making a stream");
  }
  ~CudaExecutor() { cudaStreamDestroy(stream_); }
  CudaExecutor(const CudaExecutor&) = delete;
  CudaExecutor& operator=(const CudaExecutor&) = delete;

  template <class T>
  class Buffer {
   public:
    Buffer() = default;
    ~Buffer() { cudaFree(data_); }
    Buffer(Buffer&& other) noexcept
        : data_(std::exchange(other.data_, nullptr)),
          size_(std::exchange(other.size_, 0)),
          room_(std::exchange(other.room_, 0)) {}
    Buffer& operator=(Buffer&& other) noexcept {
      std::swap(data_, other.data_);
      std::swap(size_, other.size_);
      std::swap(room_, other.room_);
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

  /// As HostExecutor's. cudaFree waits for the device, so growing is for between steps; shrinking keeps the
  /// memory.
  template <class T>
  void resize(Buffer<T>& buffer, std::size_t n) {
    if (n > buffer.room_) {
      check_cuda(cudaStreamSynchronize(stream_), "waiting");
      cudaFree(buffer.data_);
      buffer.data_ = nullptr;
      buffer.size_ = buffer.room_ = 0;
      check_cuda(cudaMalloc(reinterpret_cast<void**>(&buffer.data_), n * sizeof(T)),
                 "taking memory of the device");
      buffer.room_ = n;
    }
    buffer.size_ = n;
  }
  template <class T>
  void zero(Buffer<T>& buffer) {
    if (buffer.size_ > 0)
      check_cuda(cudaMemsetAsync(buffer.data_, 0, buffer.size_ * sizeof(T), stream_), "clearing memory");
  }
  /// `from` must stay as it is until wait().
  template <class T>
  void upload(Buffer<T>& to, const T* from, std::size_t n) {
    resize(to, n);
    if (n > 0)
      check_cuda(cudaMemcpyAsync(to.data_, from, n * sizeof(T), cudaMemcpyHostToDevice, stream_),
                 "copying to the device");
  }
  /// For all that was queued.
  void wait() { check_cuda(cudaStreamSynchronize(stream_), "a kernel or a copy"); }
  template <class T>
  void download(const Buffer<T>& from, T* to) {
    if (from.size_ > 0)
      check_cuda(cudaMemcpyAsync(to, from.data_, from.size_ * sizeof(T), cudaMemcpyDeviceToHost, stream_),
                 "copying from the device");
    wait();
  }

  /// What `queue` queues, as one graph with one launch in place of each kernel's own. The graph of the time
  /// before is kept and only its numbers are changed, where the kernels are the same ones. `queue` must
  /// neither wait nor take memory.
  template <class Queue>
  void together(Queue&& queue) {
    check_cuda(cudaStreamBeginCapture(stream_, cudaStreamCaptureModeRelaxed), "recording a step");
    cudaGraph_t recorded = nullptr;
    try {
      queue();
    } catch (...) {  // the stream has to be as it was
      cudaStreamEndCapture(stream_, &recorded);
      cudaGetLastError();
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

  cudaStream_t stream() const { return stream_; }

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
    const std::size_t teams = std::min<std::size_t>(kTeamsPerBlock, most_shared_ / scratch_bytes),
                      shared = teams * scratch_bytes;
    if (teams == 0)
      fail({"CUDA", "a ray has too many samples for the shared memory of this device",
            std::to_string(most_shared_) + " bytes", std::to_string(scratch_bytes) + " bytes",
            "a larger sampling.step, or --device cpu"});
    if (shared > kSharedByDefault)
      check_cuda(
          cudaFuncSetAttribute(team_kernel<Kernel>, cudaFuncAttributeMaxDynamicSharedMemorySize, int(shared)),
          "asking for shared memory (rays with very many samples)");
    team_kernel<<<unsigned((n + teams - 1) / teams), dim3(kLanes, unsigned(teams)), shared, stream_>>>(
        n, kernel, unsigned(scratch_bytes));
    check_cuda(cudaGetLastError(), "starting a kernel");
  }

 private:
  static constexpr std::size_t kSharedByDefault = 48 * 1024;
  cudaStream_t stream_ = nullptr;
  std::size_t most_shared_ = 0;  ///< bytes a block can ask for
  ReadyGraph ready_;
};

}  // namespace splinevox
