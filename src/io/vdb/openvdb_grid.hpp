// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <openvdb/openvdb.h>

#include "io/vdb/vdb_file.hpp"

// The library holds these classes. Without the words each of our files would compile every virtual function
// of them again, for most of its time.
extern template class openvdb::tree::Tree<openvdb::FloatTree::RootNodeType>;
extern template class openvdb::tree::Tree<openvdb::Vec3STree::RootNodeType>;
extern template class openvdb::Grid<openvdb::FloatTree>;
extern template class openvdb::Grid<openvdb::Vec3STree>;

namespace splinevox {

/// The same grid in OpenVDB's own form, name, transform and metadata included: a FloatGrid or a Vec3SGrid.
/// @pre openvdb::initialize() was called.
openvdb::GridBase::Ptr to_openvdb(const VdbGrid& in);

}  // namespace splinevox
