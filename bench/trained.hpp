// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "splinevox/core/process.hpp"
#include "splinevox/data/image_read.hpp"
#include "splinevox/data/scene.hpp"
#include "splinevox/math/metrics.hpp"
#include "splinevox/render/render_image.hpp"
#include "splinevox/train/trainer.hpp"

namespace splinevox {

/// A run from start to end, as the benchmarks need it.
struct Trained {
  VoxelModel model;
  double seconds = 0;          ///< of training, processor time summed over cores
  double samples_per_ray = 0;  ///< mean over all rays
  PhaseSeconds phases;
};

inline Trained train_to_end(const Config& config, const Dataset& data) {
  const double start = processor_seconds();
  Trainer trainer(config, *data.find("train"), data.time_map);
  std::int64_t samples = 0, rays = 0;
  while (!trainer.done()) {
    const StepReport report = trainer.step();
    samples += report.samples, rays += report.rays;
  }
  return {trainer.model(), processor_seconds() - start, double(samples) / double(rays), trainer.phases()};
}

/// Mean PSNR of the model's pictures of a split, dB.
inline double mean_psnr(const VoxelModel& model, const Split& split) {
  Renderer renderer(model);
  double db = 0;
  for (const Frame& f : split.frames) db += capped_psnr(psnr(clamped(renderer.render(f.camera, f.time).rgb), composite(f.image, model.background.color)));
  return db / double(split.frames.size());
}

}  // namespace splinevox
