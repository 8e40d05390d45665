// SPDX-License-Identifier: Apache-2.0
#include "train/plan.hpp"

#include <algorithm>

#include "splinevox/math/basis.hpp"
#include "train/bounds/freeze.hpp"
#include "train/bounds/hidden.hpp"
#include "train/effects/effect_table.hpp"
#include "train/rates.hpp"

namespace splinevox {
namespace {

using Starts = std::vector<float>;
using Counts = Plan::Counts;

/// A run between two steps.
struct Moment {
  const Setting& setting;
  const double progress;
  const bool begun;
  const TimeWindow& window;
  Volume& volume;
  Counts& counts;
};

/// What an event leaves to be made anew.
enum class Leaves {
  nothing,
  lattices,  ///< what belongs to them
  places     ///< that, and the occupancy: matter is elsewhere
};

struct Event {
  const char* what;
  const Starts& (*starts)(const Config&);  ///< progress at which it happens, in order
  int Counts::*count;                      ///< times it has happened
  /// Before the occupancy is used: whether bricks were pruned. null: nothing to do.
  bool (*clear)(const Moment&);
  /// Where new bricks are laid out. null: nothing to do. @param times  that it is to have happened
  Leaves (*lay_out)(const Moment&, int times);
  bool near_matter = false;  ///< new bricks lie where the occupancy has matter
};

const Starts kNever;

bool changes_over_time(const Config& c) { return changes(effects_of(c)); }
bool halves(const Config& c) { return basis_of(c.motion.basis).halves(); }

const Starts& emptying_starts(const Config& c) { return c.grid.empty_start; }
const Starts& stage_starts(const Config& c) { return c.grid.radiance_start; }
const Starts& harmonics_starts(const Config& c) { return c.radiance.sh_start; }
const Starts& level_starts(const Config& c) { return changes_over_time(c) ? c.grid.motion_start : kNever; }
const Starts& curve_starts(const Config& c) {
  if (!changes_over_time(c)) return kNever;
  return halves(c) ? c.motion.halve_start : c.motion.elevate_start;
}

bool empty(const Moment& m) {
  return m.counts.stages > 0 && empty_hidden(m.setting, m.window, m.volume.lattices);
}

bool tighten(const Moment& m) {
  if (m.begun && m.window.whole) tighten_box(m.setting, m.volume, m.window);
  return false;
}

void add_levels(const Moment& m, int times) {
  Lattices& l = m.volume.lattices;
  while (int(l.levels.size()) < times)
    l.add_level(m.setting.config.grid.motion[l.levels.size()], motion_cells(m.volume, m.window));
}

/// Cells near which the next radiance lattice has bricks.
BitGrid matter(const Moment& m) {
  if (!m.window.whole) return m.volume.occupancy.hull;
  const Config& c = m.setting.config;
  const VoxelModel& model = m.volume.lattices.model;
  return canonical_occupancy(model, c.sampling.occupancy_cells, c.grid.prune_alpha, model.step);
}

Leaves begin_stages(const Moment& m, int times) {
  const GridConfig& grid = m.setting.config.grid;
  Lattices& l = m.volume.lattices;
  std::optional<Offset> offset;
  if (m.begun)
    offset = freeze(m.setting, m.volume, m.window, l.edge() / float(grid.radiance[std::size_t(times - 1)]));
  const Leaves leaves = offset ? Leaves::places : Leaves::lattices;
  if (offset) {  // all levels, which cost little now: what is static is laid out as finely as they are
    m.counts.levels = int(grid.motion.size());
    add_levels(m, m.counts.levels);
  }
  for (int stage = m.counts.stages; stage < times; ++stage) {
    if (stage == 0)
      l.start_radiance(m.setting, m.volume.occupancy.hull);
    else
      l.refine_radiance(m.setting, grid.radiance[std::size_t(stage)], matter(m), offset,
                        m.window.whole && grid.prune_alpha > 0);
    offset.reset();  // the lattice has been resampled at it
  }
  return leaves;
}

Leaves join_harmonics(const Moment& m, int) {
  const int order = order_at(m.setting.config.radiance, m.progress);
  if (order == m.volume.lattices.model.radiance.sh_order) return Leaves::nothing;
  m.volume.lattices.add_harmonics(order);
  return Leaves::lattices;
}

Leaves begin_levels(const Moment& m, int times) {
  add_levels(m, times);
  return Leaves::lattices;
}

Leaves refine_curves(const Moment& m, int times) {
  const Config& c = m.setting.config;
  Lattices& l = m.volume.lattices;
  for (int i = m.counts.curves; i < times; ++i)
    l.refine_curves(halves(c) ? basis_of(c.motion.basis).refinement.refined(l.model.motion.points)
                              : c.motion.elevate_points[std::size_t(i)]);
  return Leaves::lattices;
}

/// In the order in which they happen.
constexpr Event kEvents[] = {
    {"hidden matter is emptied", emptying_starts, &Counts::emptied, empty, nullptr},
    {"a radiance lattice begins", stage_starts, &Counts::stages, tighten, begin_stages, true},
    {"harmonics join", harmonics_starts, &Counts::harmonics, nullptr, join_harmonics},
    {"a motion level begins", level_starts, &Counts::levels, nullptr, begin_levels, true},
    {"curves get more control points", curve_starts, &Counts::curves, nullptr, refine_curves},
};

/// That an event should have happened.
int times(const Event& event, const Config& config, double progress, int most_stages) {
  const int due = reached(event.starts(config), progress) + 1;
  return event.count == &Counts::stages ? std::min(due, most_stages) : due;
}

}  // namespace

std::vector<std::string_view> Plan::due(const Config& config, double progress) const {
  std::vector<std::string_view> out;
  for (const Event& event : kEvents)
    if (counts_.*event.count < times(event, config, progress, most_stages_)) out.push_back(event.what);
  return out;
}

bool Plan::carry_out(const Setting& setting, double progress, bool begun, const TimeWindow& window,
                     Volume& volume) {
  const Moment now{setting, progress, begun, window, volume, counts_};
  bool went = false, looks = false;
  for (const Event& event : kEvents) {
    if (counts_.*event.count >= times(event, setting.config, progress, most_stages_)) continue;
    if (event.clear) went |= event.clear(now);
    looks |= begun && event.near_matter;
  }
  if (went || looks) refresh_occupancy(setting, volume, window);
  Leaves leaves = went ? Leaves::lattices : Leaves::nothing;
  for (const Event& event : kEvents) {
    const int wanted = times(event, setting.config, progress, most_stages_);
    if (counts_.*event.count >= wanted) continue;
    if (event.lay_out) leaves = std::max(leaves, event.lay_out(now, wanted));
    counts_.*event.count = wanted;
  }
  if (leaves >= Leaves::lattices) fit(setting, volume);
  if (leaves >= Leaves::places) refresh_occupancy(setting, volume, window);
  return leaves >= Leaves::lattices;
}

void Plan::fit(const Setting& setting, Volume& volume) const {
  set_rates(setting.config, volume.lattices);
  set_priors(setting.config, halves(setting.config) ? counts_.curves : 0, volume.lattices);
  fit_motion(setting, volume);
}

void Plan::archive(Archive& a) { a(counts_); }

bool Plan::fits(const Config& config, const Lattices& lattices) const {
  for (const Event& event : kEvents) {
    const int count = counts_.*event.count;
    if (count < 0 || count > int(event.starts(config).size())) return false;
  }
  return counts_.stages > 0 && counts_.levels == int(lattices.levels.size());
}

}  // namespace splinevox
