// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdio>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "backend/pictures.hpp"
#include "backend/step.hpp"

namespace splinevox::test {

/// Who runs the device's kernels: the host's threads always, and a CUDA device where one is.
struct Runner {
  std::string name;
  std::function<std::unique_ptr<PictureMaker>(const VoxelModel&)> pictures;
  std::function<std::unique_ptr<StepBackend>(bool deterministic)> step;
};

inline const std::vector<Runner>& runners() {
  static const std::vector<Runner> list = [] {
    std::vector<Runner> out{{"host", make_host_pictures, [](bool d) { return make_host_step(d); }}};
    const CudaFound cuda = find_cuda();
    if (cuda.usable)
      out.push_back({cuda.name, [](const VoxelModel& m) { return make_pictures(Device::cuda, m); },
                     [](bool d) { return make_step(Device::cuda, d); }});
    else
      std::printf("skipped on a CUDA device: %s. The same kernels ran on the host's threads.\n",
                  cuda.reason.c_str());
    return out;
  }();
  return list;
}

}  // namespace splinevox::test
