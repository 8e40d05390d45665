// SPDX-License-Identifier: Apache-2.0
#include "run/exit_code.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <new>
#include <system_error>

#include "core/printable.hpp"
#include "run/events.hpp"
#include "run/signals.hpp"
#include "run/standard_output.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::run {
namespace {

constexpr int kReaderGone = -1;  ///< who read what is printed wants no more of it, nor a message

/// The message for people, and the same as an event where a program listens.
/// stdio and not fmt::print: these lines must come out even where memory or the terminal is gone, and must
/// not throw.
int say(const char* program, const char* text, const Problem& problem, Fault fault) {
  const int code = fault == Fault::input ? 2 : 1;
  std::fprintf(stderr, "%s: %s\n", program, text);
  write_error(problem, fault, code);
  return code;
}

int say_other(const char* program, const std::exception& error) {
  const std::string text = all_printable(error.what());
  return say(program, text.c_str(), {program, text}, Fault::output);
}

int run(const char* program, const std::function<int()>& work) {
  try {
    return work();
  } catch (const Error& error) {
    return say(program, error.what(), error.problem, error.fault);
  } catch (const std::bad_alloc&) {
    return say(program,
               "out of memory\n  try:      in training --downscale 2, or fewer cells: --set "
               "grid.radiance=40,64,96 --set grid.radiance_start=0,.15,.5; of exports a larger --voxel-size",
               {program, "out of memory"}, Fault::memory);
  } catch (const std::system_error& error) {
    if (error.code() == std::errc::broken_pipe) return kReaderGone;
    return say_other(program, error);
  } catch (const std::exception& error) {
    return say_other(program, error);
  }
}

}  // namespace

int exit_code_of(const char* program, const std::function<int()>& work) {
  ignore_write_signals();
  const int code = run(program, work);
  if (code == kReaderGone) return 1;
  flush_output();
  const int failure = output_failure();
  if (failure == 0 || failure == EPIPE || failure == EBADF) return code;
  std::fprintf(stderr, "%s: standard output: could not be written: %s\n", program, std::strerror(failure));
  return code == 0 ? 1 : code;
}

}  // namespace splinevox::run
