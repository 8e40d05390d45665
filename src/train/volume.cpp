// SPDX-License-Identifier: Apache-2.0
#include "train/volume.hpp"

#include "splinevox/core/error.hpp"

namespace splinevox {
namespace {

bool fits(const Channels& values, const Learner& learner, int width) {
  return values.width == width && learner.m.size() == values.values.size() &&
         learner.v.size() == values.values.size();
}

bool fits(const Volume& volume, const Config& config) {
  const Lattices& l = volume.lattices;
  const RadianceField& radiance = l.model.radiance;
  const int order = radiance.sh_order, points = l.model.motion.points;
  if (order < order_at(config.radiance, 0) || order > config.radiance.sh_order) return false;
  if (!basis_of(config.motion.basis).points.allows(points)) return false;
  if (!fits(radiance.raw, l.radiance, radiance_width(order))) return false;
  const std::size_t kept = config.grid.empty_start.empty() ? 0 : radiance.raw.topology->bricks.size();
  if (l.visible.rows.size() != kept) return false;
  for (std::size_t i = 0; i < l.levels.size(); ++i)
    if (!fits(l.levels[i], l.level_learners[i], l.model.motion.width())) return false;
  return true;
}

}  // namespace

void check_fits(bool good) {
  if (!good)
    fail({"checkpoint", "the training state does not fit this configuration",
          "a state written by the same version and configuration", "other sizes", ""});
}

void Volume::archive(Archive& a, const Setting& setting) {
  Lattices& l = lattices;
  VoxelModel& model = l.model;
  a.section("radiance", [&] {
    a(model.radiance.raw, l.radiance.m, l.radiance.v, model.radiance.activation, model.radiance.sh_order);
    a(model.box, model.step, l.visible.rays, l.visible.rows);
  });
  a.section("motion", [&] {
    std::uint64_t levels = l.levels.size();
    a(levels, model.motion.points, moving.cells, moving.share, moving.proved);
    check_fits(levels <= setting.config.grid.motion.size());
    l.levels.resize(levels);
    l.level_learners.resize(levels);
    for (std::size_t i = 0; i < levels; ++i) {
      a(l.levels[i]);
      if (a.reading()) l.level_learners[i] = Learner(l.levels[i]);
      a(l.level_learners[i].m, l.level_learners[i].v);
    }
  });
  a.section("occupancy", [&] {
    FrameOccupancy& frames = occupancy.frames;
    std::uint64_t grids = frames.grids.size();
    a(grids, frames.of_frame, occupancy.hull);
    check_fits(grids == 0 ? frames.of_frame.empty() : frames.of_frame.size() == setting.train.frames.size());
    for (const std::int32_t grid : frames.of_frame) check_fits(grid >= 0 && std::uint64_t(grid) < grids);
    check_fits(grids <= most_occupancies(setting.train.frames.size()));
    frames.grids.resize(grids);
    for (BitGrid& grid : frames.grids) a(grid);
  });
  if (a.reading()) check_fits(fits(*this, setting.config));
}

}  // namespace splinevox
