// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace splinevox::run {

/// The page of `train --live`: the viewer without a model, and what is beside it. @param name  of the run
std::string live_html(const std::string& name);

/// A file of src/live/assets, as it was when the program was built. @pre it is there.
std::string_view live_asset(std::string_view name);

}  // namespace splinevox::run
