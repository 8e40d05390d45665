// SPDX-License-Identifier: Apache-2.0
#include "splinevox/field/channels.hpp"

#include <cstring>
#include <utility>

namespace splinevox {

Channels make_channels(TopologyPtr topology, int width, const float* background) {
  Channels channels{std::move(topology), width, {}};
  const std::size_t rows = channels.topology->rows();
  channels.values.resize(rows * width);
  for (std::size_t r = 0; r < rows; ++r) std::memcpy(channels.row(r), background, sizeof(float) * width);
  return channels;
}

}  // namespace splinevox
