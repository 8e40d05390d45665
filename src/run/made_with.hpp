// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

/// What figures were made with and on, for whoever compares them.
namespace splinevox::run {

/// Of this program's sources, with "-dirty" where they were changed; "" of sources that are not git's.
std::string source_commit();

}  // namespace splinevox::run
