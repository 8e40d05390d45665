// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "splinevox/render/render_image.hpp"

namespace splinevox {

class Ranks;

/// Where the kernels run.
enum class Device { cpu, cuda };

/// What this build and this machine have of CUDA: a device that can be used, or why there is none.
struct CudaFound {
  bool built = false;  ///< this build has CUDA kernels
  bool usable = false;
  std::string name;    ///< of the device, e.g. "NVIDIA H200 (sm_90, 139 GB)"
  std::string reason;  ///< why none is usable: what was found
};
CudaFound find_cuda();

/// The device that `--device NAME` means: "cpu", "cuda", or "auto", which is cuda where it is built in and a
/// device is there. Throws Error (input) for another name, and for cuda where it cannot be had.
Device choose_device(const std::string& name);
/// The same for a process that trains with others: a device of its own, of the kind that all of them have.
/// Throws Error (input) where a machine has fewer devices than processes, or only some of them have one.
Device choose_device(const std::string& name, Ranks& ranks);
/// For reports: "cpu", or "cuda: " and the device's name.
std::string describe(Device device);

/// A renderer whose pictures the device draws. The model must outlive it. @pre the device is there
/// (choose_device)
Renderer make_renderer(const VoxelModel& model, Device device);

}  // namespace splinevox
