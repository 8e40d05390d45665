// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>

#include "run/events.hpp"
#include "run/progress.hpp"

namespace splinevox::run {

/// What a verb says: to people as text, to programs as events (--json), or nothing (--quiet).
class Teller {
 public:
  /// @param things  that are counted, e.g. "pictures"
  explicit Teller(Talk talk, std::string things = "pictures") : talk_(talk), things_(std::move(things)) {}

  Talk talk() const { return talk_; }
  bool text() const { return talk_ == Talk::bar || talk_ == Talk::lines; }

  /// A line on standard output.
  void note(const std::string& line) const;
  /// A line on standard error, however quiet the rest is: something asked for is not there.
  void warn(const std::string& line) const;
  /// So many of `total` are done: a count that is drawn over itself on a terminal; an event every few
  /// seconds.
  void progress(std::int64_t done, std::int64_t total);
  /// A signal stopped it. @param line  what is there, and how to go on; on standard error
  void interrupted(const std::string& line, const Json& figures) const;
  /// What came of it. @param line  the same for people; may be empty
  void result(const Json& figures, const std::string& line) const;

 private:
  Talk talk_;
  std::string things_;
  double spoken_ = -1e9;  ///< when progress was told, seconds
};

}  // namespace splinevox::run
