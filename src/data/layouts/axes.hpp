// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>
#include <vector>

#include "data/layouts/raw_scene.hpp"

namespace splinevox::data {

/// Matrices of one file whose last row is 0 0 0 w, the same in all, as those with 0 0 0 1: divided by w where
/// that makes them rigid; as they stand where they are rigid already, since one scale for all positions is a
/// unit. Any other matrices stay as they are. @return a note; empty if nothing was done.
std::string take_last_rows(std::vector<std::array<double, 16>>& matrices);

/// Whether a camera's axes are left-handed.
bool is_mirrored(const std::array<double, 16>& matrix);

/// Which axis of mirrored cameras is the wrong one, as far as all of them together tell: where they look and
/// which way up they are.
std::string mirrored_hint(const RawScene& scene);

}  // namespace splinevox::data
