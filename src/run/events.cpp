// SPDX-License-Identifier: Apache-2.0
#include "run/events.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <chrono>
#include <cstdlib>
#include <optional>
#include <random>

#include "run/standard_output.hpp"

namespace splinevox::run {
namespace {

struct Speaker {
  std::string verb, id;
};
std::optional<Speaker> speaker;  ///< of this process; none: events have not begun

std::string now_utc() {
  const auto now = std::chrono::time_point_cast<std::chrono::milliseconds>(std::chrono::system_clock::now());
  const auto count = now.time_since_epoch().count();
  return fmt::format("{:%Y-%m-%dT%H:%M:%S}.{:03}Z", fmt::gmtime(std::time_t(count / 1000)), count % 1000);
}

std::string new_id() {
  if (const char* given = std::getenv("SPLINEVOX_RUN_ID"); given && *given) return given;
  std::random_device random;
  return fmt::format("{:08x}{:08x}", random(), random());
}

const char* name_of(Fault fault) {
  switch (fault) {
    case Fault::input:
      return "input";
    case Fault::output:
      return "output";
    case Fault::numeric:
      return "numeric";
    case Fault::memory:
      return "memory";
  }
  return "";
}

}  // namespace

void begin_events(const std::string& verb) { speaker = Speaker{verb, new_id()}; }

std::string event_line(const char* event, const Json& fields) {
  const Speaker& s = speaker.value();
  Json line{{"event", event}, {"timestamp", now_utc()}, {"run_id", s.id}, {"verb", s.verb}};
  line.update(fields);
  return json_text(line);
}

void write_event(const char* event, const Json& fields) {
  if (!speaker) return;
  print_now(event_line(event, fields) + "\n");
}

void write_error(const Problem& p, Fault fault, int exit_code) noexcept {
  try {
    write_event("error", {{"where", p.where},
                          {"what", p.what},
                          {"expected", p.expected},
                          {"found", p.got},
                          {"try", p.hint},
                          {"fault", name_of(fault)},
                          {"exit_code", exit_code}});
  } catch (...) {  // the message on standard error has been said
  }
}

}  // namespace splinevox::run
