// SPDX-License-Identifier: Apache-2.0
#include "run/capture/capture_talk.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cstdio>

#include "core/printable.hpp"

namespace splinevox::run {
namespace {

constexpr double kLinesEvery = 5;  // seconds between two plain lines of a stage

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

void CaptureTalk::end_line() {
  if (drawn_) std::fputs("\n", stderr);
  drawn_ = false;
}

void CaptureTalk::stage(int number, const std::string& name) {
  end_line();
  number_ = number;
  name_ = name;
  spoken_ = 0;
  if (talk_ == Talk::lines) std::fputs(fmt::format("[{}/{}] {}\n", number, kStages, name).c_str(), stderr);
  if (talk_ == Talk::bar) progress(0, 0);
}

void CaptureTalk::progress(int done, int total) {
  if (stop_asked()) throw CaptureStopped{};
  const bool last = total > 0 && done == total;
  const double time = now();
  if (talk_ == Talk::quiet || (!last && time - spoken_ < (talk_ == Talk::bar ? 0.1 : kLinesEvery))) return;
  spoken_ = time;
  if (talk_ == Talk::json) {
    std::fputs(
        (json_text(
             {{"stage", name_}, {"number", number_}, {"of", kStages}, {"done", done}, {"total", total}}) +
         "\n")
            .c_str(),
        stdout);
    std::fflush(stdout);
    return;
  }
  const std::string count = total > 0 ? fmt::format(": {} of {}", done, total) : "";
  std::fputs(fmt::format("{}[{}/{}] {}{}{}", talk_ == Talk::bar ? "\r\x1b[K" : "", number_, kStages, name_,
                         count, talk_ == Talk::bar ? "" : "\n")
                 .c_str(),
             stderr);
  std::fflush(stderr);
  drawn_ = talk_ == Talk::bar;
  if (last) end_line();
}

void CaptureTalk::note(const std::string& text) {
  notes_.push_back(text);
  if (talk_ == Talk::quiet) return;
  if (talk_ == Talk::json) {
    std::fputs((json_text({{"note", text}}) + "\n").c_str(), stdout);
    return;
  }
  end_line();
  std::fputs((all_printable(text) + "\n").c_str(), stderr);
}

}  // namespace splinevox::run
