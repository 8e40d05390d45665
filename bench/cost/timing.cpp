// SPDX-License-Identifier: Apache-2.0
#include "timing.hpp"

#include <linux/perf_event.h>
#include <sys/ioctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <random>

#include "core/stopwatch.hpp"
#include "math/median.hpp"

namespace splinevox::cost {
namespace {

/// Counts instructions of this process and its threads to come; 0 where that is not allowed.
class InstructionCounter {
 public:
  InstructionCounter() {
    perf_event_attr attributes{};
    attributes.type = PERF_TYPE_HARDWARE;
    attributes.size = sizeof attributes;
    attributes.config = PERF_COUNT_HW_INSTRUCTIONS;
    attributes.disabled = 1;
    attributes.inherit = 1;
    attributes.exclude_kernel = 1;
    attributes.exclude_hv = 1;
    file_ = int(syscall(SYS_perf_event_open, &attributes, 0, -1, -1, 0));
  }
  ~InstructionCounter() {
    if (file_ >= 0) close(file_);
  }
  void start() {
    if (file_ >= 0) {
      ioctl(file_, PERF_EVENT_IOC_RESET, 0);
      ioctl(file_, PERF_EVENT_IOC_ENABLE, 0);
    }
  }
  double stop() {
    std::uint64_t count = 0;
    if (file_ < 0) return 0;
    ioctl(file_, PERF_EVENT_IOC_DISABLE, 0);
    return read(file_, &count, sizeof count) == sizeof count ? double(count) : 0;
  }

 private:
  int file_;
};

}  // namespace

Figure median_of(std::vector<double> values) {
  if (values.empty()) return {};
  std::mt19937 random(1);
  std::uniform_int_distribution<std::size_t> pick(0, values.size() - 1);
  std::vector<double> medians(2000), draw(values.size());
  for (double& m : medians) {
    for (double& d : draw) d = values[pick(random)];
    m = median(draw);
  }
  std::sort(medians.begin(), medians.end());
  return {median(values), medians[50], medians[1949]};
}

std::vector<Timed> interleave(const std::vector<Candidate>& candidates, int rounds) {
  const std::size_t n = candidates.size();
  std::vector<std::vector<double>> seconds(n), ratio(n), instructions(n);
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), std::size_t(0));
  std::mt19937 random(7);
  InstructionCounter counter;
  for (const Candidate& c : candidates)
    c.run();  // memory and caches of the first time are not what is measured
  for (int r = 0; r < rounds; ++r) {
    std::shuffle(order.begin(), order.end(), random);
    for (const std::size_t i : order) {
      counter.start();
      const Timer timer;
      candidates[i].run();
      seconds[i].push_back(timer.seconds());
      instructions[i].push_back(counter.stop());
    }
    for (std::size_t i = 0; i < n; ++i) ratio[i].push_back(seconds[i].back() / seconds[0].back());
  }
  std::vector<Timed> out;
  for (std::size_t i = 0; i < n; ++i)
    out.push_back({median_of(seconds[i]), median_of(ratio[i]), median(instructions[i])});
  return out;
}

}  // namespace splinevox::cost
