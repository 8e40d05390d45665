// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <openvdb/Grid.h>

#include "io/vdb/vdb_file.hpp"

namespace splinevox {

/// The same grid in OpenVDB's own form, name, transform and metadata included: a FloatGrid or a Vec3SGrid.
/// @pre openvdb::initialize() was called.
openvdb::GridBase::Ptr to_openvdb(const VdbGrid& in);

}  // namespace splinevox
