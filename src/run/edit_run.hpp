// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "run/support.hpp"

namespace splinevox::run {

/// An operation of edit_operations() with its value; "" for one that has none.
struct AskedEdit {
  std::string operation, value;
};

struct EditedRun {
  std::string folder;
  Json operations;  ///< EditSession::done
};

/// Writes an edited copy of a run into a folder of its own, with its history and manifest.
/// @param say  hears lines about what the operations did
/// Throws Error: input for no or wrong operations and for a folder that holds something, output.
EditedRun edit_run(const std::string& run, const std::string& out, const std::vector<AskedEdit>& asked,
                   const std::function<void(const std::string&)>& say);

}  // namespace splinevox::run
