// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "splinevox/io/export_vdb.hpp"

namespace splinevox::test {

/// Frames up to `last` for Houdini, values in full.   @param voxel_size  0: the model's own
inline ExportOptions houdini_options(int last, double voxel_size = 0) {
  ExportOptions o;
  o.profile = "houdini";
  o.last = last;
  o.half = false;
  o.voxel_size = voxel_size;
  return o;
}

}  // namespace splinevox::test
