// SPDX-License-Identifier: Apache-2.0
#include "splinevox/core/depth_map.hpp"

#include <algorithm>
#include <cmath>

#include "core/half.hpp"

namespace splinevox {
namespace {

constexpr std::uint16_t kSign = 0x8000;
/// From here on a value says that nothing was hit: renderers write 1e10. One such would set the unit of all.
constexpr float kNoHit = 1e9f;

bool is_known(float v) { return v != 0 && std::abs(v) < kNoHit; }

}  // namespace

DepthMap::DepthMap(int width, int height, std::span<const float> values, DepthKind kind)
    : width_(width), height_(height), kind_(kind) {
  float largest = 0;
  for (const float v : values)
    if (is_known(v)) largest = std::max(largest, std::abs(v));
  constexpr int kTop = 15;  // halves end below 2^16
  if (largest > 0) unit_ = std::ldexp(1.0f, std::max(std::ilogb(largest) - kTop + 1, -120));
  std::vector<std::uint16_t> halves;
  halves.reserve(values.size());
  for (const float v : values) {
    halves.push_back(is_known(v) ? std::uint16_t(std::max<std::uint16_t>(to_half(std::abs(v) / unit_), 1) |
                                                 (v < 0 ? kSign : 0))
                                 : std::uint16_t(0));
  }
  values_ = std::make_shared<const std::vector<std::uint16_t>>(std::move(halves));
}

float DepthMap::value(std::size_t i) const { return unit_ * from_half((*values_)[i]); }

double DepthMap::known_share() const {
  if (empty() || values_->empty()) return 0;
  const auto unknown = std::count(values_->begin(), values_->end(), std::uint16_t(0));
  return 1 - double(unknown) / double(values_->size());
}

}  // namespace splinevox
