// SPDX-License-Identifier: Apache-2.0
#include "run/teller.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cstdio>

namespace splinevox::run {

void Teller::note(const std::string& line) const {
  if (text()) fmt::print("{}\n", line);
  if (talk_ == Talk::json) write_event("note", {{"note", line}});
}

void Teller::warn(const std::string& line) const {
  fmt::print(stderr, "{}\n", line);
  if (talk_ == Talk::json) write_event("warning", {{"warning", line}});
}

void Teller::progress(std::int64_t done, std::int64_t total) {
  constexpr double kEvery = 2;  // seconds between two events
  if (talk_ == Talk::bar)
    fmt::print(stderr, "\r{} of {} {}{}", done, total, things_, done == total ? "\n" : "");
  if (talk_ != Talk::json) return;
  const double now =
      std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  if (now - spoken_ < kEvery && done < total) return;
  spoken_ = now;
  write_event("progress", {{"done", done}, {"total", total}, {"things", things_}});
}

void Teller::interrupted(const std::string& line, const Json& figures) const {
  fmt::print(stderr, "{}\n", line);
  if (talk_ != Talk::json) return;
  Json fields{{"interrupted", true}};
  fields.update(figures);
  write_event("interrupted", fields);
}

void Teller::result(const Json& figures, const std::string& line) const {
  if (text() && !line.empty()) fmt::print("{}\n", line);
  if (talk_ == Talk::json) write_event("result", figures);
}

}  // namespace splinevox::run
