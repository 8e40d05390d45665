// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "splinevox/data/scene.hpp"
#include "splinevox/train/trainer.hpp"

namespace splinevox {

/// A run from start to end, as the benchmarks need it.
struct Trained {
  VoxelModel model;
  double seconds = 0;          ///< of training
  double samples_per_ray = 0;  ///< mean over all rays
  PhaseSeconds phases;
};

inline Trained train_to_end(const Config& config, const Dataset& data) {
  Trainer trainer(config, *data.find("train"), data.time_map);
  std::int64_t samples = 0, rays = 0;
  while (!trainer.done()) {
    const StepReport report = trainer.step();
    samples += report.samples, rays += report.rays;
  }
  return {trainer.model(), trainer.seconds(), double(samples) / double(rays), trainer.phases()};
}

}  // namespace splinevox
