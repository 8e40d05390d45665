// SPDX-License-Identifier: Apache-2.0
#include "backend/pictures_impl.hpp"
#include "splinevox/backend/executor_host.hpp"
#include "splinevox/backend/pictures.hpp"

namespace splinevox {

std::unique_ptr<PictureMaker> make_host_pictures(const VoxelModel& model) { return std::make_unique<Pictures<HostExecutor>>(model); }

}  // namespace splinevox
