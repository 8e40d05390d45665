// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace splinevox {

/// Processor time of this process so far, all its threads together; seconds. Unlike wall time it does not grow while others have the cores.
double processor_seconds();
/// The most memory this process has had in use at once, bytes.
double peak_memory();

}  // namespace splinevox
