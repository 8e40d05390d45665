// SPDX-License-Identifier: Apache-2.0
// consumer DIR : makes a scene, trains a few steps, writes and reads the model, renders it. 0: everything is
// as it should be.
#include <cstdio>
#include <string>

#include "splinevox/core/error.hpp"
#include "splinevox/core/version.hpp"
#include "splinevox/data/synth.hpp"
#include "splinevox/io/model_vdb.hpp"
#include "splinevox/math/metrics.hpp"
#include "splinevox/render/render_image.hpp"
#include "splinevox/train/trainer.hpp"

int main(int count, char** words) {
  using namespace splinevox;
  static_assert(SPLINEVOX_VERSION_NUMBER >= 100, "the first version with this header is 0.1.0");
  SynthOptions scene;
  scene.frames = 8, scene.size = 32;
  const Dataset data = make_synth("ball", scene);
  Config config = preset("draft");
  config.run.max_time = 0, config.run.max_steps = 40;
  config.grid.radiance = {16}, config.grid.radiance_start = {0};
  Trainer trainer(config, *data.find("train"), data.time_map);
  while (!trainer.done()) trainer.step();
  const std::string path = std::string(count > 1 ? words[1] : ".") + "/model.vdb";
  save_model(path, trainer.model());
  const Frame& frame = data.find("test")->frames.front();
  const Image picture = render_image(load_model(path), frame.camera, frame.time).rgb;
  const double dB = psnr(picture, composite(frame.image, {1, 1, 1}));
  std::printf("splinevox %s: a ball after 40 steps, %.2f dB\n", kVersion, dB);
  try {
    load_model(path + ".none");
  } catch (const Error& error) {
    return dB > 12 && error.fault == Fault::input ? 0 : 1;
  }
  return 1;
}
