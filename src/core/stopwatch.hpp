// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>

namespace splinevox {

/// A clock that stands still while the process is suspended (Ctrl-Z, a scheduler that freezes it): a budget
/// of seconds must not run out meanwhile. The two clocks it is made of are given, so that it can be tested.
class RunningClock {
 public:
  /// @param wall, processor  seconds so far, by the clock and by the process. @return seconds that it ran.
  double operator()(double wall, double processor) {
    const double gap = wall - wall_, worked = processor - processor_;
    if (begun_ && gap > kLongest && worked < kIdle * gap) suspended_ += gap - worked;
    begun_ = true;
    wall_ = wall;
    processor_ = processor;
    return wall - suspended_;
  }

 private:
  static constexpr double kLongest = 1;  ///< seconds between two looks that need no explanation
  static constexpr double kIdle = 0.02;  ///< share of them that a process on a busy machine still gets
  bool begun_ = false;
  double wall_ = 0, processor_ = 0, suspended_ = 0;
};

/// Seconds that this process was not suspended, as far as calls tell; from any thread.
double running_seconds();

/// Seconds by the clock on the wall, since it was made.
class Timer {
 public:
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// The running clock in laps.
class Stopwatch {
 public:
  /// Seconds since the last lap, or since the watch was made.
  double lap() {
    const double now = running_seconds(), seconds = now - last_;
    last_ = now;
    return seconds;
  }

 private:
  double last_ = running_seconds();
};

}  // namespace splinevox
