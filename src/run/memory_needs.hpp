// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "splinevox/data/scene.hpp"
#include "splinevox/train/config.hpp"

namespace splinevox::run {

/// What a training will take beside its pictures: at most, as far as it can be told before. Bytes.
struct MemoryNeeds {
  int cells = 0;          ///< of the finest radiance lattice, along the longest edge
  double lattices = 0;    ///< values, moments and gradients of the finest lattices
  double occupancy = 0;   ///< of all frames
  double step = 0;        ///< rays and their samples, slices, the program itself
  double checkpoint = 0;  ///< on disk
  double in_memory() const { return lattices + occupancy + step; }
};

/// @param data  with frames, their pictures not yet read
MemoryNeeds memory_needs(const Config& config, const Dataset& data);

/// "6G", "500M", "1.5GB" (powers of 1000), "6Gi", "6GiB" (of 1024), or bytes. Throws Error (input) naming
/// `option`.
double parse_memory(const std::string& text, const std::string& option);

/// The bound of --memory, or what the process may have. Throws Error (input).
double memory_bound(const std::string& asked);

/// Room for pictures within the bound. Throws Error (input) if the training does not fit without any.
double room_for_pictures(double bound, const MemoryNeeds& needs);

/// One line for the user, once pictures are where they are.
std::string memory_line(double bound, const MemoryNeeds& needs, const Dataset& data);

}  // namespace splinevox::run
