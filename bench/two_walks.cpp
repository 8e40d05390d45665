// SPDX-License-Identifier: Apache-2.0
// Why rays are walked in two ways: the same training steps on this machine's threads by the CPU's own code,
// in vector registers, and by the kernels of a device, lane by lane.
//
//   bench_two_walks [DATASET] [threads] [steps]     DATASET: default $SPLINEVOX_DATA/dnerf_trex, or the
//   built-in dancer
#include <fmt/core.h>
#include <tbb/global_control.h>

#include <cstdlib>
#include <ctime>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "backend/step.hpp"
#include "solid_preset.hpp"
#include "splinevox/data/synth.hpp"
#include "splinevox/train/prepare.hpp"
#include "splinevox/train/trainer.hpp"

using namespace splinevox;

namespace {

struct Run {
  double seconds = 0;  ///< of processors, for all steps
  double loss = 0;     ///< of the last step
};

Run train(const Config& config, Dataset& data, std::unique_ptr<StepBackend> backend) {
  Trainer trainer(config, *data.find("train"), data.time_map, 0, nullptr, std::move(backend));
  Run out;
  const std::clock_t start = std::clock();
  while (!trainer.done()) out.loss = trainer.step().loss;
  out.seconds = double(std::clock() - start) / CLOCKS_PER_SEC;
  return out;
}

}  // namespace

int main(int argc, char** argv) {
  const char* root = std::getenv("SPLINEVOX_DATA");
  const std::string path = argc > 1 && *argv[1] ? argv[1] : root ? std::string(root) + "/dnerf_trex" : "";
  const int threads = argc > 2 ? std::atoi(argv[2]) : 1;
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
  Dataset data = path.empty() ? make_synth("dancer", {.frames = 100, .size = 200})
                              : load_dataset(path, {.splits = {"train"}});

  Config asked = solid_preset("fast");
  asked.run.max_time = 0;
  asked.run.max_steps = argc > 3 ? std::atoi(argv[3]) : 400;
  const Config config = prepare(asked, data, {.effects = EffectPolicy::keep}).config;
  const Run vectors = train(config, data, make_step(Device::cpu)),
            lanes = train(config, data, make_host_step(false));
  const nlohmann::json line{
      {"bench", "two_walks"},
      {"data", path.empty() ? "built-in dancer" : path},
      {"threads", threads},
      {"steps", config.run.max_steps},
      {"processor_seconds", {{"vector_registers", vectors.seconds}, {"lanes", lanes.seconds}}},
      {"lanes_over_vector_registers", lanes.seconds / vectors.seconds},
      {"last_loss", {{"vector_registers", vectors.loss}, {"lanes", lanes.loss}}}};
  fmt::print("{}\n", line.dump());
}
