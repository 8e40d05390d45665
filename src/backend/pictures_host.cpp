// SPDX-License-Identifier: Apache-2.0
#include "backend/executor_host.hpp"
#include "backend/pictures.hpp"
#include "backend/pictures_impl.hpp"

namespace splinevox {

std::unique_ptr<PictureMaker> make_host_pictures(const VoxelModel& model) {
  return std::make_unique<Pictures<HostExecutor>>(model);
}

}  // namespace splinevox
