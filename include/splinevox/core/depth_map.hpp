// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace splinevox {

/// What the numbers d of a depth map say of the depth z along the camera's axis. s and b are unknown, and
/// others for every picture.
enum class DepthKind {
  metric,    ///< z = d, scene units
  relative,  ///< z = s d + b
  inverse,   ///< 1 / z = s d + b
};

/// A number per pixel that tells how far away the pixel's surface is, where that is known. Copies share their
/// values, which never change. They are kept as halves in a unit of the map: 11 bits each.
class DepthMap {
 public:
  DepthMap() = default;
  /// @param values  [height * width] row by row; 0, and what is not finite: unknown
  DepthMap(int width, int height, std::span<const float> values, DepthKind kind);

  bool empty() const { return !values_; }
  int width() const { return width_; }
  int height() const { return height_; }
  DepthKind kind() const { return kind_; }
  std::size_t bytes() const { return values_ ? values_->size() * sizeof(std::uint16_t) : 0; }
  /// The number of pixel i, 0: unknown. @pre not empty
  float value(std::size_t i) const;
  /// That of the pixel in which the middle of pixel (x, y) of a picture of width x height lies, which shows
  /// the same; 0: unknown. @pre not empty
  float at(int x, int y, int width, int height) const {
    const std::int64_t u = (2 * std::int64_t(x) + 1) * width_ / (2 * width),
                       v = (2 * std::int64_t(y) + 1) * height_ / (2 * height);
    return value(std::size_t(v * width_ + u));
  }
  /// Share of the pixels that are known, in [0, 1].
  double known_share() const;

 private:
  int width_ = 0, height_ = 0;
  DepthKind kind_ = DepthKind::metric;
  float unit_ = 1;  ///< a power of two
  std::shared_ptr<const std::vector<std::uint16_t>> values_;
};

}  // namespace splinevox
