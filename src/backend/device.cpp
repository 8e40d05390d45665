// SPDX-License-Identifier: Apache-2.0
#include "splinevox/backend/device.hpp"

#include "backend/cuda.hpp"
#include "backend/host/host_step.hpp"
#include "core/ranks.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox {

CudaFound find_cuda() { return cuda::find(); }

Device choose_device(const std::string& name, Ranks& ranks) {
  if (name != "cpu") cuda::take(ranks.local());
  const Device device = choose_device(name);
  const double mine = device == Device::cuda;
  for (const double theirs : ranks.gather({&mine, 1}))
    if (theirs != mine)
      fail({"--device", "some processes found a CUDA device and others none", "all of them alike",
            describe(device) + " in process " + std::to_string(ranks.rank()),
            "--device cpu, or machines that all have one"});
  return device;
}

Device choose_device(const std::string& name) {
  if (name == "cpu") return Device::cpu;
  if (name != "auto" && name != "cuda")
    fail({"--device", "there is no such device", "auto, cpu or cuda", name, ""});
  const CudaFound found = find_cuda();
  if (found.usable) return Device::cuda;
  if (name == "auto") return Device::cpu;
  fail({"--device", found.built ? "CUDA has no device here" : "this build has no CUDA", "auto or cpu",
        found.built ? found.reason : name,
        found.built ? "nvidia-smi shows the devices and the driver; --device cpu"
                    : "a build made where nvcc is (docs/cuda.md), or --device cpu"});
}

std::string describe(Device device) { return device == Device::cuda ? "cuda: " + find_cuda().name : "cpu"; }

std::unique_ptr<PictureMaker> make_pictures(Device device, const VoxelModel& model) {
  return device == Device::cuda ? cuda::make_pictures(model) : nullptr;
}

Renderer make_renderer(const VoxelModel& model, Device device) {
  return Renderer(model, make_pictures(device, model));
}

std::unique_ptr<StepBackend> make_step(Device device, bool deterministic, Ranks* ranks) {
  if (device == Device::cuda) return cuda::make_step(deterministic, ranks);
  return std::make_unique<HostStep>(ranks);
}

}  // namespace splinevox
