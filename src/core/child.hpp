// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace splinevox {

/// What to start, and what to say where it cannot be.
struct ChildWords {
  std::vector<std::string> words;       ///< the program and its arguments
  std::string where;                    ///< how errors name what it was to do
  std::string purpose;                  ///< "films are read with it"
  std::string hint;                     ///< how to install it
  bool errors = false;                  ///< what it prints as errors is read too, else it is dropped
  std::vector<std::string> usual = {};  ///< NAME=VALUE of its environment, where NAME is not set yet
};

/// A program whose output is read here. Without input; it is killed where this object ends before it does.
class Child {
 public:
  /// Throws Error (Fault::input) if it cannot be started.
  explicit Child(const ChildWords& start);
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  ~Child();

  /// Fills the buffer; false if the output ended before, or nothing came for a minute.
  bool read(char* to, std::size_t size);
  /// The next line without its end, however long it takes; false at the end of the output.
  /// @param stop  asked about five times a second; once it says so the program is killed.
  bool read_line(std::string& line, const std::function<bool()>& stop);
  /// Waits for the program's end; whether it ended well by itself.
  bool finish();

 private:
  void kill();
  pid_t process_ = -1;
  int pipe_ = -1;
  std::string ahead_;  ///< what was read and not yet handed out as lines
};

}  // namespace splinevox
