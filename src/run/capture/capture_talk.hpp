// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "run/progress.hpp"

namespace splinevox::run {

/// Thrown where somebody asked to stop; what is done stays done.
struct CaptureStopped {};

/// What `capture` says while it works: a line per stage with the time left, drawn over itself on a terminal;
/// elsewhere again every half minute.
class CaptureTalk {
 public:
  /// @param stop  whether somebody asked to stop
  CaptureTalk(Talk talk, std::function<bool()> stop) : talk_(talk), stop_(std::move(stop)) {}

  /// Stage `number` of kStages begins.
  void stage(int number, const std::string& name);
  /// So many of `total` are done; throws CaptureStopped if asked to.
  void progress(int done, int total);
  /// A line of its own; collected too.
  void note(const std::string& text);
  const std::vector<std::string>& notes() const { return notes_; }
  bool stop_asked() const { return stop_ && stop_(); }

  static constexpr int kStages = 5;

 private:
  void end_line();
  Talk talk_;
  std::function<bool()> stop_;
  std::vector<std::string> notes_;
  std::string name_;
  int number_ = 0, done_ = 0;
  double spoken_ = 0, began_ = 0;  ///< when the last line was printed, and the count began; seconds
  bool drawn_ = false;
};

}  // namespace splinevox::run
