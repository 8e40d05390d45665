// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "backend/executor_cuda.cuh"
#include "core/ranks.hpp"

#if __has_include(<nccl.h>)
#include <dlfcn.h>
#include <nccl.h>

#include <cstring>
#include <exception>
#include <vector>
#endif

namespace splinevox {

#if __has_include(<nccl.h>)

/// NCCL, found when it is needed: it is two hundred megabytes that a single process does without.
struct Nccl {
  decltype(&ncclGetUniqueId) get_unique_id;
  decltype(&ncclCommInitRank) init;
  decltype(&ncclCommDestroy) destroy;
  decltype(&ncclAllReduce) all_reduce;
  decltype(&ncclAllGather) all_gather;
  decltype(&ncclGetErrorString) error;

  static const Nccl& library() {
    static const Nccl found;
    return found;
  }
  void check(ncclResult_t code, const char* what) const {
    if (code != ncclSuccess)
      throw Error(
          {"NCCL", std::string(what) + " failed", "", error(code), "NCCL_DEBUG=INFO says more; --device cpu"},
          Fault::output);
  }

 private:
  Nccl() {
    void* const library = dlopen("libnccl.so.2", RTLD_NOW | RTLD_LOCAL);
    if (!library)
      fail({"--device", "processes on several CUDA devices need NCCL, which is not there",
            "libnccl.so.2 where the loader finds it", dlerror(), "LD_LIBRARY_PATH, or --device cpu"});
    const auto take = [&](auto& function, const char* name) {
      void* const found = dlsym(library, name);
      if (!found)
        fail({"libnccl.so.2", "this library has not all that is needed", name, "nothing of that name",
              "NCCL 2.9 or newer"});
      std::memcpy(&function, &found, sizeof found);  // an object pointer is no function pointer, except here
    };
    take(get_unique_id, "ncclGetUniqueId");
    take(init, "ncclCommInitRank");
    take(destroy, "ncclCommDestroy");
    take(all_reduce, "ncclAllReduce");
    take(all_gather, "ncclAllGather");
    take(error, "ncclGetErrorString");
  }
};

/// Masks of all ranks, one after the other, into one.
struct UniteMasksKernel {
  const std::uint64_t* all;
  std::uint64_t* to;
  std::size_t words;
  int ranks;
  SPLINEVOX_HD std::size_t count() const { return words; }
  SPLINEVOX_HD void operator()(std::size_t i) const {
    std::uint64_t united = 0;
    for (int k = 0; k < ranks; ++k) united |= all[std::size_t(k) * words + i];
    to[i] = united;
  }
};

/// The ranks of a CudaExecutor's step: their devices send each other what they have, in the order of the
/// stream, and the hosts do not wait. A sum is made once and sent to all, so it has the same bits everywhere,
/// which is what keeps ranks from parting. (NCCL's algorithms do that between devices of one kind.)
class CudaPeers {
 public:
  explicit CudaPeers(Ranks& ranks) : ranks_(ranks) {
    refuse_shared_devices();
    ncclUniqueId id{};
    static_assert(sizeof id % sizeof(std::uint64_t) == 0);
    std::uint64_t words[sizeof id / sizeof(std::uint64_t)] = {};
    if (ranks.first()) {
      nccl_.check(nccl_.get_unique_id(&id), "making an address for all");
      std::memcpy(words, &id, sizeof id);
    }
    ranks.merge(words);  // the others gave zeros
    std::memcpy(&id, words, sizeof id);
    nccl_.check(nccl_.init(&all_, ranks.count(), id, ranks.rank()), "meeting the other devices");
  }
  /// After an error the others may be anywhere, and parting would wait for them; the end of the process does
  /// not.
  ~CudaPeers() {
    if (std::uncaught_exceptions() == 0) nccl_.destroy(all_);
  }
  CudaPeers(const CudaPeers&) = delete;
  CudaPeers& operator=(const CudaPeers&) = delete;

  void sum(CudaExecutor& run, CudaExecutor::Buffer<float>& numbers) {
    reduce(run, numbers.data(), numbers.size(), ncclFloat);
  }
  void sum(CudaExecutor& run, CudaExecutor::Buffer<std::int64_t>& numbers) {
    reduce(run, numbers.data(), numbers.size(), ncclInt64);
  }
  void merge(CudaExecutor& run, CudaExecutor::Buffer<std::uint64_t>& masks) {
    const int count = ranks_.count();
    run.resize(masks_, masks.size() * std::size_t(count));
    nccl_.check(nccl_.all_gather(masks.data(), masks_.data(), masks.size(), ncclUint64, all_, run.stream()),
                "gathering masks");
    run.for_each(UniteMasksKernel{masks_.data(), masks.data(), masks.size(), count});
    ranks_.traffic.bytes += std::int64_t(masks.size() * sizeof(std::uint64_t)) * (count - 1);
  }

 private:
  /// Two ranks cannot meet on one device: NCCL may wait for ever.
  void refuse_shared_devices() {
    int own = 0;
    cudaDeviceProp device{};
    check_cuda(cudaGetDevice(&own), "finding the device");
    check_cuda(cudaGetDeviceProperties(&device, own), "asking what the device is");
    double name[2];  // 16 bytes that no other device has, as whole numbers of 32 bits
    std::uint32_t words[4];
    static_assert(sizeof words == sizeof device.uuid);
    std::memcpy(words, &device.uuid, sizeof words);
    for (int i = 0; i < 2; ++i) name[i] = double(words[2 * i]) * 0x1p21 + double(words[2 * i + 1] >> 11);
    const std::vector<double> all = ranks_.gather(name);
    for (int a = 0; a < ranks_.count(); ++a)
      for (int b = 0; b < a; ++b)
        if (all[2 * a] == all[2 * b] && all[2 * a + 1] == all[2 * b + 1])
          fail({"--device", "two processes have the same CUDA device", "a device for each",
                "processes " + std::to_string(b) + " and " + std::to_string(a) + " share one",
                "fewer processes a machine, or --device cpu"});
  }
  void reduce(CudaExecutor& run, void* numbers, std::size_t n, ncclDataType_t type) {
    nccl_.check(nccl_.all_reduce(numbers, numbers, n, type, ncclSum, all_, run.stream()),
                "adding up gradients");
    ranks_.traffic.bytes += std::int64_t(2 * (ranks_.count() - 1) * n *
                                         (type == ncclFloat ? sizeof(float) : sizeof(std::int64_t)) /
                                         std::size_t(ranks_.count()));
  }
  const Nccl& nccl_ = Nccl::library();
  Ranks& ranks_;
  ncclComm_t all_ = nullptr;
  CudaExecutor::Buffer<std::uint64_t> masks_;
};

#else

/// A build without NCCL: its devices cannot meet.
class CudaPeers {
 public:
  explicit CudaPeers(Ranks&) {
    fail({"--device", "this build cannot let several CUDA devices train together",
          "a build made where nccl.h is (docs/cuda.md)", "none", "one process, or --device cpu"});
  }
  template <class T>
  void sum(CudaExecutor&, CudaExecutor::Buffer<T>&) {}
  void merge(CudaExecutor&, CudaExecutor::Buffer<std::uint64_t>&) {}
};

#endif

}  // namespace splinevox
