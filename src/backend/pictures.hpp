// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "render/picture_maker.hpp"
#include "splinevox/backend/device.hpp"

namespace splinevox {

/// What draws a model's pictures on a device; null for the CPU, where Renderer does. The model must outlive
/// it.
/// @pre the device is there (choose_device)
std::unique_ptr<PictureMaker> make_pictures(Device device, const VoxelModel& model);

/// The device's kernels on the calling arena's threads: what tests run where there is no device.
std::unique_ptr<PictureMaker> make_host_pictures(const VoxelModel& model);

}  // namespace splinevox
