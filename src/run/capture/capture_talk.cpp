// SPDX-License-Identifier: Apache-2.0
#include "run/capture/capture_talk.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cstdio>

#include "core/printable.hpp"
#include "run/events.hpp"

namespace splinevox::run {
namespace {

constexpr double kTold = 5;  // seconds of a stage, from which the rest can be told

/// Seconds between two lines of a stage.
double lines_every(Talk talk) { return talk == Talk::bar ? 0.1 : talk == Talk::json ? 5 : 30; }

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
  done_ = 0;
  began_ = now();
  spoken_ = talk_ == Talk::lines ? began_ : 0;
  if (talk_ == Talk::lines) std::fputs(fmt::format("[{}/{}] {}\n", number, kStages, name).c_str(), stderr);
  if (talk_ == Talk::bar) progress(0, 0);
}

void CaptureTalk::progress(int done, int total) {
  if (stop_asked()) throw CaptureStopped{};
  const bool last = total > 0 && done == total;
  const double time = now();
  if (done < done_) began_ = time;  // the stage counts once more
  const bool again = last && done == done_;
  done_ = done;
  if (talk_ == Talk::quiet || again || (!last && time - spoken_ < lines_every(talk_))) return;
  spoken_ = time;
  if (talk_ == Talk::json) {
    write_event("progress",
                {{"stage", name_}, {"number", number_}, {"of", kStages}, {"done", done}, {"total", total}});
    return;
  }
  const double took = time - began_;
  const std::string count = total > 0 ? fmt::format(": {} of {}", done, total) : "",
                    left = !last && done > 0 && done < total && took > kTold
                               ? fmt::format(", about {} left", duration(took * (total - done) / done))
                               : "";
  std::fputs(fmt::format("{}[{}/{}] {}{}{}{}", talk_ == Talk::bar ? "\r\x1b[K" : "", number_, kStages, name_,
                         count, left, talk_ == Talk::bar ? "" : "\n")
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
    write_event("note", {{"note", text}});
    return;
  }
  end_line();
  std::fputs((all_printable(text) + "\n").c_str(), stderr);
}

}  // namespace splinevox::run
