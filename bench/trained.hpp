// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/process.hpp"
#include "splinevox/data/image_io.hpp"
#include "splinevox/data/scene.hpp"
#include "splinevox/math/metrics.hpp"
#include "splinevox/render/render_image.hpp"
#include "splinevox/train/prepare.hpp"
#include "splinevox/train/trainer.hpp"

namespace splinevox {

/// A run from start to end, as the benchmarks need it.
struct Trained {
  VoxelModel model;
  double seconds = 0;          ///< of training, processor time summed over cores
  double samples_per_ray = 0;  ///< mean over all rays
  PhaseSeconds phases;
  double moving_share = 1;  ///< Trainer::moving_share
};

/// With the effects of the configuration, untried.
inline Trained train_to_end(const Config& config, Dataset& data) {
  const double start = processor_seconds();
  const Prepared ready = prepare(config, data, {.effects = EffectPolicy::keep});
  Trainer trainer(ready.config, *data.find("train"), data.time_map);
  std::int64_t samples = 0, rays = 0;
  while (!trainer.done()) {
    const StepReport report = trainer.step();
    samples += report.samples;
    rays += report.rays;
  }
  return {trainer.model(), processor_seconds() - start, double(samples) / double(rays), trainer.phases(),
          trainer.moving_share()};
}

/// Every n-th pixel of every n-th row of a picture, from the (n / 2)-th on.
inline Image strided(const Image& image, int stride) {
  const auto count = [&](int size) { return (size - stride / 2 + stride - 1) / stride; };
  Image out(count(image.width), count(image.height), image.channels);
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x)
      std::copy_n(image.pixel(stride / 2 + stride * x, stride / 2 + stride * y), image.channels,
                  out.pixel(x, y));
  return out;
}

/// Mean PSNR of the model's pictures of a split at every n-th pixel and row, dB.
inline double mean_psnr(const VoxelModel& model, const Split& split, int stride = 1) {
  Renderer renderer(model);
  double db = 0;
  for (const Frame& f : split.frames)
    db += capped_psnr(psnr(strided(clamped(renderer.render(f.camera, f.time).rgb), stride),
                           strided(composite(f.image, model.background.color), stride)));
  return db / double(split.frames.size());
}

}  // namespace splinevox
