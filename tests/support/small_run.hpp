// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <functional>

#include "math/camera.hpp"
#include "splinevox/data/synth.hpp"
#include "splinevox/math/metrics.hpp"
#include "splinevox/render/render_image.hpp"
#include "splinevox/train/trainer.hpp"
#include "support/on_threads.hpp"

/// Runs that a test can wait for.
namespace splinevox::test {

/// So many steps on small lattices, each refined once.
inline Config small_run(int steps) {
  Config c = preset("draft");
  c.run.max_time = 0;
  c.run.max_steps = steps;
  c.grid.radiance = {16, 28};
  c.grid.radiance_start = {0, 0.3f};
  c.grid.motion = {4, 8};
  c.grid.motion_start = {0, 0.2f};
  c.sampling.rays = 1024;
  c.sampling.occupancy_cells = 32;
  c.sampling.occupancy_every = 50;
  return c;
}

/// The model of a whole run.
inline VoxelModel trained(const Config& config, const Dataset& data, int threads = 2) {
  return on_threads(threads, [&] {
    Trainer trainer(config, *data.find("train"), data.time_map);
    while (!trainer.done()) trainer.step();
    return trainer.finish();
  });
}

/// Mean PSNR of the test split.
inline double test_psnr(const VoxelModel& model, const Dataset& data) {
  Renderer renderer(model);
  const Split& test = *data.find("test");
  double sum = 0;
  for (const Frame& f : test.frames)
    sum += psnr(clamped(renderer.render(f.camera, f.time).rgb), composite(f.image, model.background.color));
  return sum / double(test.frames.size());
}

/// The moving ball, photographed before something: no alpha.
/// @param behind  colour that a ray ends on, [0, 1]
inline Dataset ball_before(const std::function<Vec3(const Ray&)>& behind, int frames, int size) {
  Dataset data = make_synth("ball", {.frames = frames, .size = size, .seed = 3});
  for (Split& split : data.splits)
    for (Frame& f : split.frames) {
      Image16 image = f.image.unpacked();
      for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) {
          std::uint16_t* p =
              image.rgba.data() + 4 * (std::size_t(y) * std::size_t(image.width) + std::size_t(x));
          const Vec3 colour = behind(camera_ray(f.camera, x + 0.5, y + 0.5));
          for (int c = 0; c < 3; ++c)
            p[c] = std::uint16_t(
                std::lround(p[c] * (p[3] / 65535.0) + 65535 * colour[c] * (1 - p[3] / 65535.0)));
          p[3] = 65535;
        }
      f.image = image;
    }
  data.has_alpha = false;
  return data;
}

}  // namespace splinevox::test
