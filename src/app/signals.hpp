// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace splinevox::app {

/// A full disk, a file size limit or a closed pipe becomes an error of the write and not a signal.
void ignore_write_signals();

/// From now on the first SIGINT or SIGTERM only asks to stop; a second one ends the process at once.
void catch_stop_signals();
/// The signal that asked to stop, 0 if none did.
int stop_signal();

}  // namespace splinevox::app
