// SPDX-License-Identifier: Apache-2.0
#include "cli/join_ranks.hpp"

#include <string>

#include "core/stopwatch.hpp"
#include "run/shares.hpp"
#include "splinevox/core/error.hpp"

#ifdef SPLINEVOX_MPI
#include <mpi.h>

#include <exception>
#endif

namespace splinevox::cli {

#ifdef SPLINEVOX_MPI
namespace {

/// MPI's own numbers are int: one message carries at most that many floats, far above any gradient that fits
/// a machine's memory.
class MpiRanks final : public Ranks {
 public:
  MpiRanks() {
    int given = 0;
    MPI_Init_thread(nullptr, nullptr, MPI_THREAD_SERIALIZED, &given);
    if (given < MPI_THREAD_SERIALIZED)
      fail({"MPI", "this MPI library cannot be called from a program with threads", "MPI_THREAD_SERIALIZED",
            std::to_string(given), "another MPI library"});
    MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
    MPI_Comm_size(MPI_COMM_WORLD, &count_);
    MPI_Comm machine;
    MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, rank_, MPI_INFO_NULL, &machine);
    MPI_Comm_rank(machine, &local_);
    MPI_Comm_free(&machine);
  }
  ~MpiRanks() override {
    if (std::uncaught_exceptions() == 0) MPI_Finalize();
  }
  int rank() const override { return rank_; }
  int count() const override { return count_; }
  int local() const override { return local_; }

  void merge(std::span<std::uint64_t> words) override {
    timed(words.size_bytes(), [&] {
      return MPI_Allreduce(MPI_IN_PLACE, words.data(), int(words.size()), MPI_UINT64_T, MPI_BOR,
                           MPI_COMM_WORLD);
    });
  }
  std::vector<double> gather(std::span<const double> mine) override {
    std::vector<double> all(mine.size() * std::size_t(count_));
    timed(mine.size_bytes() * std::size_t(count_ - 1), [&] {
      return MPI_Allgather(mine.data(), int(mine.size()), MPI_DOUBLE, all.data(), int(mine.size()),
                           MPI_DOUBLE, MPI_COMM_WORLD);
    });
    return all;
  }
  void exchange(std::span<const float> mine, std::span<const std::size_t> ends,
                std::span<float> got) override {
    const int own = int(got.size()) / count_;
    std::vector<int> sizes, starts, back(std::size_t(count_), own), places;
    pieces(ends, sizes, starts);
    for (int k = 0; k < count_; ++k) places.push_back(k * own);
    timed((mine.size() - std::size_t(own)) * sizeof(float), [&] {
      return MPI_Alltoallv(mine.data(), sizes.data(), starts.data(), MPI_FLOAT, got.data(), back.data(),
                           places.data(), MPI_FLOAT, MPI_COMM_WORLD);
    });
  }
  void collect(std::span<float> all, std::span<const std::size_t> ends) override {
    std::vector<int> sizes, starts;
    pieces(ends, sizes, starts);
    timed(std::size_t(sizes[std::size_t(rank_)]) * sizeof(float) * std::size_t(count_ - 1), [&] {
      return MPI_Allgatherv(MPI_IN_PLACE, 0, MPI_DATATYPE_NULL, all.data(), sizes.data(), starts.data(),
                            MPI_FLOAT, MPI_COMM_WORLD);
    });
  }

 private:
  static void pieces(std::span<const std::size_t> ends, std::vector<int>& sizes, std::vector<int>& starts) {
    for (std::size_t k = 0; k + 1 < ends.size(); ++k) {
      sizes.push_back(int(ends[k + 1] - ends[k]));
      starts.push_back(int(ends[k]));
    }
  }
  template <class Call>
  void timed(std::size_t bytes, Call&& call) {
    const Timer timer;
    call();  // MPI ends the program where it fails: that is its default
    traffic.bytes += std::int64_t(bytes);
    traffic.seconds += timer.seconds();
  }
  int rank_ = 0, count_ = 1, local_ = 0;
};

}  // namespace

std::unique_ptr<Ranks> join_ranks(const char*) {
  if (launched_share().whole()) return nullptr;
  return std::make_unique<MpiRanks>();
}

#else

std::unique_ptr<Ranks> join_ranks(const char* verb) {
  const Share share = launched_share();
  if (!share.whole())
    fail({verb, "there are several processes, and this build cannot let them work together",
          "a build with SPLINEVOX_MPI=ON", std::to_string(share.count) + " processes",
          "one process without mpirun"});
  return nullptr;
}

#endif

}  // namespace splinevox::cli
