// SPDX-License-Identifier: Apache-2.0
#include "train/effects/fit_config.hpp"

#include <algorithm>

#include "train/config/loss_terms.hpp"

namespace splinevox {

Config fit_config(const Config& config, const EffectSet& effects) {
  Config c = config;
  apply(effects, c);
  c.run.max_time = 0;
  c.run.max_steps = config.effects.steps;
  c.grid.radiance = {20, 40};
  c.grid.radiance_start = {0, 0.25f};
  c.grid.motion = {4, 8, 16};
  c.grid.motion_start = {0, 0.25f, 0.25f};
  c.grid.surroundings = {32, 48};
  c.grid.surroundings_start = {0, 0.4f};
  c.radiance.sh_order = order_at(c.radiance, 0);
  c.radiance.sh_start.clear();
  c.radiance.steepen = 0;  // fits with presence have none
  c.motion.rest = 0;
  c.motion.elevate_points.clear();
  c.motion.elevate_start.clear();
  c.motion.halve_start.clear();
  c.grid.empty_start.clear();
  c.loss = for_trials(c.loss);
  c.sampling.rays = std::min(c.sampling.rays, 2048);
  c.sampling.growth = 1;
  c.sampling.changing = 0;
  c.sampling.hard_share = 0;
  c.sampling.window = 1;  // every fit learns from the same pictures
  c.sampling.occupancy_cells = 32;
  c.sampling.occupancy_every = 100;
  return c;
}

}  // namespace splinevox
