// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace splinevox {

/// Rigidity below which nothing moves, and dividing a displacement by it would only raise noise.
inline constexpr float kLeastRigidity = 0.02f;

}  // namespace splinevox
