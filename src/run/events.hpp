// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "run/support.hpp"
#include "splinevox/core/error.hpp"

/// What a program prints with --json: one JSON object a line on standard output. docs/formats.md has the
/// table of events. This is the one place that makes such lines.
namespace splinevox::run {

/// From now on this process writes its events. @param verb  of the command line; "": none
void begin_events(const std::string& verb);

/// One line, without its end: event, timestamp (UTC), run_id, verb, and then `fields`.
/// run_id is the same in all lines of one call: SPLINEVOX_RUN_ID of the environment, or else a new one.
std::string event_line(const char* event, const Json& fields);

/// Prints that line at once; nothing before begin_events.
void write_event(const char* event, const Json& fields = Json::object());

/// The event "error": where, what, expected, found, try, fault, exit_code; all there, though some are "".
/// Never throws: it is what is left to do when memory or the disk is gone.
void write_error(const Problem& problem, Fault fault, int exit_code) noexcept;

}  // namespace splinevox::run
