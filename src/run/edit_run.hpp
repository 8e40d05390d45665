// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace splinevox::run {

/// An operation of edit_operations() with its value; "" for one that has none.
struct AskedEdit {
  std::string operation, value;
};

/// Writes an edited copy of a run into a folder of its own, with its history and manifest. Returns the
/// folder.
/// @param quiet  say nothing about what the operations did
/// Throws Error: input for no or wrong operations and for a folder that holds something, output.
std::string edit_run(const std::string& run, const std::string& out, const std::vector<AskedEdit>& asked,
                     bool quiet);

}  // namespace splinevox::run
