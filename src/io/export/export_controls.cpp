// SPDX-License-Identifier: Apache-2.0
#include "io/export/export_controls.hpp"

#include <utility>

#include "io/export/what_changes.hpp"
#include "io/model/model_grid.hpp"
#include "io/model/model_meta.hpp"
#include "math/rigidity.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox {

void check_controls(const VoxelModel& model) {
  const MotionField& motion = model.motion;
  if (motion.moves()) return;
  const std::string changes = what_changes(motion);
  fail({.where = "--controls",
        .what = "this model has no motion to write",
        .expected = "a model that moves",
        .got = "one " + (changes.empty() ? "that stands still" : "where " + changes),
        .hint = "export without --controls"});
}

FileDigest write_controls(const std::string& path, const VoxelModel& model) {
  check_controls(model);
  const MotionField& motion = model.motion;
  if (motion.levels.size() != 1)
    fail_output({.where = path,
                 .what = "a file of control points holds one motion level",
                 .expected = "collapse(motion) before writing",
                 .got = std::to_string(motion.levels.size()) + " levels"});
  VdbFile file;
  file.meta = {{"creator", std::string("splinevox")}};
  const VdbMeta meta = motion_meta(motion);
  for (Column column : motion_columns(motion)) {
    const bool rigidity = column.kind == ColumnKind::rigidity;
    if (!rigidity && column.kind != ColumnKind::control) continue;
    if (rigidity) {
      column.role = "rigidity: 1 moves, 0 is static";
      column.activation = "linear";
    }
    VdbGrid grid = to_grid(motion.levels[0], column, meta, false);
    if (rigidity) {
      const auto activate = [&](float raw) { return rigidity_of(raw, motion.rigidity_offset).value; };
      for (float& v : grid.values) v = activate(v);
      grid.background.x = activate(grid.background.x);
      grid.meta.erase("rigidity_offset");  // it is in the values
    }
    file.grids.push_back(std::move(grid));
  }
  return write_vdb(path, std::move(file));
}

}  // namespace splinevox
