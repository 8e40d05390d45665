// SPDX-License-Identifier: Apache-2.0
#include <memory>

#include "app/command.hpp"
#include "app/evaluate.hpp"
#include "splinevox/io/export_vdb.hpp"

namespace splinevox::app {}
