// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "math/schedule.hpp"
#include "train/state.hpp"

namespace splinevox {
namespace {

LearnedRows learned(Channels& values, Learner& learner) {
  LearnedRows rows{&values, &learner.m, &learner.v, learner.rate, learner.tv, {}};
  for (const Shrink& s : learner.shrink) rows.shrink.push_back({s.member, s.threshold});
  rows.seen = learner.gradient.seen;
  return rows;
}

}  // namespace

void Trainer::State::bring_home() {
  if (!home) device->download();
  home = true;
}

StepSums Trainer::State::step_on_device(const RayLosses& losses, const std::vector<double>& times,
                                        double progress_now) {
  if (!uploaded) {
    StepModel now{&model, learned(model.radiance.raw, radiance), {}, active.rows, occupancy};
    for (std::size_t l = 0; l < levels.size(); ++l)
      now.levels.push_back(learned(levels[l], level_learners[l]));
    if (occupancy.empty()) now.occupancy = {&bounds.hull, 1};
    device->upload(now);
    uploaded = true;
  }
  std::vector<int> grids;
  for (const int f : batch.frames) grids.push_back(occupancy.size() > 1 ? f : 0);
  ++step;
  StepInput in;
  in.rays = batch.rays, in.targets = batch.targets, in.times = times, in.occupancy = grids;
  in.losses = losses;
  in.tv_scale = float(std::pow(double(config.loss.tv_final), progress_now)),
  in.tv_share = config.loss.tv_share;
  in.curves = curve_prior(), in.rest = rest_prior();
  in.draw = losses.probe_seed;  // of the rows, the same on all ranks
  if (ranks)
    in.losses.probe_seed =
        hash64(in.draw + std::uint64_t(ranks->rank()));  // a device counts its own rays from 0
  in.factors = factors();
  in.radiance_rate = float(cosine_decay(progress_now, config.optimiser.final_radiance));
  in.motion_rate = float(cosine_decay(progress_now, config.optimiser.final_motion));
  in.largest = kLargestGradient;
  in.behind = behind;
  home = false;
  return device->run(in);
}

}  // namespace splinevox
