// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "io/vdb/vdb_file.hpp"

namespace splinevox {

/// Whether NanoVDB's headers were there when this was built.
bool has_nanovdb();

/// Writes the grids as one segment of a .nvdb, atomically: 32-bit floats, not compressed, so that every
/// reader takes it. NanoVDB has no place for metadata other than name, class and transform. The bytes depend
/// on the content only. Throws Error: Fault::output if it cannot be written. @pre has_nanovdb().
FileDigest write_nvdb(const std::string& path, VdbFile file);

}  // namespace splinevox
