// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "fuzz/targets.hpp"

/// Everything that can go wrong with files, tried at length. Each trial gives one line.
namespace splinevox::torture {

struct Options {
  std::string program;  ///< the splinevox binary
  std::string out;      ///< folder for lines, table and what broke
  std::string failing;  ///< the library that makes calls fail
  double seconds = 60;
  std::uint64_t seed = 1;
  std::int64_t soak_steps =
      200'000;  ///< at most, within its share of the time; all of them in an hour or more
  std::uint64_t structure_cases = 100'000;  ///< at most
  bool keep_all = false;                    ///< keep what was read wrongly with a note, or refused, as well
};

struct Line {
  std::string trial{};  ///< "inputs", "structure", "float against double", "kills", "full disk", "links", ...
  std::string what{};   ///< parser, verb or scene
  std::uint64_t tried = 0, crashes = 0, hangs = 0, lost = 0;
  double seconds = 0;
  std::string note{};  ///< figures of this trial alone
};

using Clock = std::chrono::steady_clock;
inline double since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Mutated files of one parser for so many seconds. What crashes it, hangs it (2 s of processor time) or
/// makes it throw anything but an input Error is kept in OUT.
Line try_inputs(const Options& o, const fuzz::Target& target, double seconds);
/// Data sets whose truth is known, with the structure of strangers' files. What is read wrongly and without a
/// note is lost, and kept in OUT.
Line try_structure(const Options& o, double seconds);
/// Micro-scenes with random numbers: the float kernel against the double one.
Line try_float_double(const Options& o, double seconds);
/// The program killed (SIGKILL) or asked to stop (SIGTERM) at random moments, gone on with, and compared with
/// a run that was left alone.
std::vector<Line> try_kills(const Options& o, double seconds);
/// Every verb that writes, with room for so many bytes a file only.
std::vector<Line> try_full_disk(const Options& o, double seconds);
/// Folders that come from somebody else: links out of them in the place of their files. Nothing that they
/// point to may change or be made.
Line try_links(const Options& o, double seconds);
/// Folders that come from somebody else: pipes, folders, endless or ill-typed texts beside what is right.
Line try_siblings(const Options& o, double seconds);
/// One allocation after another fails. Little memory is no fault of a file, and no reason to crash.
Line try_allocations(const Options& o, double seconds);
/// One system call after another fails, for each reason that it may have.
std::vector<Line> try_system_calls(const Options& o, double seconds);
/// Training that is stopped for a while (Ctrl-Z, a scheduler): its budget is not spent asleep.
Line try_suspended(const Options& o, double seconds);
/// Training steps in one process: nothing non-finite, no growing memory.
Line try_soak(const Options& o, double seconds);

/// Runs `work` in a fork, so that the threads it starts and what it breaks stay there, and returns its line.
Line in_fork(const std::function<Line()>& work);

/// A program that was started with limits. Output goes to a file.
class Process {
 public:
  /// @param file_bytes  no file can grow beyond that; negative: any size. @param environment  NAME=VALUE,
  /// besides this program's own.
  Process(std::vector<std::string> words, const std::string& log, std::int64_t file_bytes = -1,
          const std::vector<std::string>& environment = {});
  void send(int signal);
  /// Whether it has; wait() still tells how.
  bool ended();
  /// Exit code, 128 + signal if a signal ended it, -1 if it took more than `seconds` and was killed.
  int wait(double seconds = 300);
  /// Processor seconds that it took, its children's included, once it has ended.
  double processor_seconds() const { return processor_seconds_; }

 private:
  pid_t process_ = -1;
  int status_ = 0;
  bool ended_ = false;
  double processor_seconds_ = 0;
};

std::string table(const std::vector<Line>& lines, const Options& o, const std::string& machine);
std::string to_json(const Line& line);

}  // namespace splinevox::torture
