// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace splinevox::run {

/// A full disk, a file size limit or a closed pipe becomes an error of the write and not a signal.
void ignore_write_signals();

constexpr int kInterrupted = 130;  ///< exit code of a verb that was asked to stop, and saved what it had

/// From now on the first SIGINT, SIGTERM or SIGHUP (a terminal that was closed; unless it is ignored) only
/// asks to stop; a second one of its kind ends the process at once, with exit code 1.
void catch_stop_signals();
/// Whether a signal asked to stop.
bool stop_asked();

}  // namespace splinevox::run
