// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>

#include "io/export/export_profiles.hpp"
#include "io/vdb/vdb_file.hpp"

namespace splinevox {

/// Writes the grids of a frame as the profile has it, atomically.
/// @param sh_order  of the harmonics among the grids; -1: none
/// @param figures  gets what can be counted of the file beside its grids: splats
/// Throws Error: Fault::output if it cannot be written.
FileDigest write_frame(const ExportProfile& profile, const std::string& path, VdbFile grids, int sh_order,
                       std::map<std::string, double>& figures);

/// Whether a .vdb names splinevox as its creator, as all that we write do. Only its head is read; what cannot
/// be read or is no .vdb does not.
bool made_by_us(const std::string& path);

}  // namespace splinevox
