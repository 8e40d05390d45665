// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "io/check_option.hpp"
#include "io/export/export_profiles.hpp"
#include "io/export/view_bake.hpp"
#include "io/vdb/nvdb_write.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/io/export_vdb.hpp"

namespace splinevox {

void validate(const ExportOptions& o) {
  validate(static_cast<const FrameRange&>(o));
  if (find_profile(o.profile).format == FrameFormat::nvdb && !has_nanovdb())
    fail({.where = "--profile",
          .what = "nanovdb is not in this build",
          .expected = "a build made where NanoVDB's headers are",
          .got = "a build without them",
          .hint = "install libnanovdb-dev, configure and build again, or choose another profile"});
  check_option(o.share.count >= 1 && o.share.index >= 0 && o.share.index < o.share.count, "--share",
               "K/N, 1 <= K <= N", std::to_string(o.share.index + 1) + "/" + std::to_string(o.share.count));
  check_option(o.voxel_size >= 0 && std::isfinite(o.voxel_size), "--voxel-size",
               "a number > 0, or 0 for the model's own", option_text(o.voxel_size));
  check_option(o.shutter >= 0 && o.shutter <= 2, "--shutter", "a number in [0, 2]", option_text(o.shutter));
  check_option(o.min_alpha > 0 && o.min_alpha < 1, "--min-alpha", "a number in (0, 1)",
               option_text(o.min_alpha));
  check_option(!(o.mesh || o.points.chosen > 0) || (o.mesh_alpha > o.min_alpha && o.mesh_alpha < 1),
               "--mesh-alpha", "a number between --min-alpha and 1", option_text(o.mesh_alpha));
  check_option(o.colorspace == "display" || o.colorspace == "linear", "--colorspace", "display or linear",
               "'" + o.colorspace + "'");
  ViewBake(o.bake_view, 0);
  const auto formats = {"auto", "ply", "obj", "glb", "usd"};
  check_option(std::find(formats.begin(), formats.end(), o.mesh_format) != formats.end(), "--mesh-format",
               "auto, ply, obj, glb or usd", "'" + o.mesh_format + "'");
  check_option(o.mesh || o.mesh_format == "auto", "--mesh-format", "--mesh beside it", "no --mesh");
  const ExportPoints& p = o.points;
  check_option(p.time.empty() || p.time.size() == p.position.size(), "--points",
               "a time of each point, or none",
               std::to_string(p.time.size()) + " of " + std::to_string(p.position.size()));
  check_option(p.id.empty() || p.id.size() == p.position.size(), "--points", "an id of each point, or none",
               std::to_string(p.id.size()) + " of " + std::to_string(p.position.size()));
  check_option(p.chosen == 0 || p.position.empty(), "--points", "a number of points or the points themselves",
               "both");
  check_option(o.points.chosen >= 0, "--points", "a number of points, or a table of them",
               std::to_string(o.points.chosen));
  check_option(!o.sh || o.bake_view == "mean" || o.bake_view == "none", "--bake-view",
               "no direction beside --sh, which leaves the view to the renderer", "'" + o.bake_view + "'");
  check_option(!o.sh || o.colorspace == "display", "--colorspace",
               "display beside --sh: the harmonics scale display values", "'" + o.colorspace + "'");
  if (o.sh && o.profile == "unreal")
    fail({.where = "--sh",
          .what = "a Sparse Volume Texture has no room for harmonics",
          .expected = "another profile",
          .got = "unreal",
          .hint = "leave --sh away"});
  if (o.flame && !find_profile(o.profile).flame)
    fail({.where = "--flame",
          .what = "frames of this profile have no room for it",
          .expected = "another profile",
          .got = o.profile,
          .hint = "leave --flame away"});
  check_option(o.colorspace == "display" || !holds_splats(find_profile(o.profile).format), "--colorspace",
               "display: renderers of splats take display values", "'" + o.colorspace + "'");
  const int clusters = o.clusters.value_or(0);
  check_option(clusters == 0 || (clusters >= 2 && clusters <= 16), "--clusters",
               "auto or a number from 2 to 16", std::to_string(clusters));
  check_option(o.frames_at_once >= 0 && o.frames_at_once <= 1024, "--frames-at-once",
               "a number from 1 to 1024, or 0 for what suits the machine", std::to_string(o.frames_at_once));
}

}  // namespace splinevox
