// SPDX-License-Identifier: Apache-2.0
#include "train/error_map.hpp"

#include <algorithm>
#include <cmath>

namespace splinevox {
namespace {

constexpr float kNewest = 0.3f;                           ///< weight of the newest patch of a tile
constexpr std::size_t kMostTiles = std::size_t(1) << 23;  ///< 32 MB; larger sets have larger tiles

int tiles_along(int blocks, int side) { return (blocks + side - 1) / side; }

}  // namespace

ErrorDraw::ErrorDraw(std::span<const float> tiles, int along, int side, int width, int height)
    : along_(along), side_(side), width_(width), height_(height), upto_(tiles.size() + 1) {
  double sum = 0;
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    sum += std::sqrt(double(tiles[i]));
    upto_[i + 1] = float(sum);
  }
}

std::uint32_t ErrorDraw::block(float tile, float x, float y) const {
  // The first sum beyond the number: tiles whose error is unknown repeat the sum before, and are passed over.
  const auto next = std::upper_bound(upto_.begin() + 1, upto_.end() - 1, tile * upto_.back());
  const int at = int(next - upto_.begin()) - 1;
  const int left = at % along_ * side_, top = at / along_ * side_;
  const auto within = [](float u, int n) { return std::min(int(u * float(n)), n - 1); };
  return std::uint32_t(top + within(y, length(top, side_, height_))) * std::uint32_t(width_) +
         std::uint32_t(left + within(x, length(left, side_, width_)));
}

float ErrorDraw::chance(std::uint32_t block) const {
  const int x = int(block % std::uint32_t(width_)) / side_, y = int(block / std::uint32_t(width_)) / side_;
  const auto at = std::size_t(y * along_ + x);
  const int blocks = length(x * side_, side_, width_) * length(y * side_, side_, height_);
  return (upto_[at + 1] - upto_[at]) / (upto_.back() * float(blocks));
}

ErrorMap::ErrorMap(const Split& train) {
  const auto lay_out = [&] {
    std::size_t all = 0;
    for (const Frame& f : train.frames) {
      const int width = blocks_along(f.image.width), height = blocks_along(f.image.height),
                along = tiles_along(width, side_);
      pictures_.push_back({all, along, width, height});
      all += std::size_t(along) * std::size_t(tiles_along(height, side_));
    }
    return all;
  };
  std::size_t all = lay_out();
  while (all > kMostTiles) {
    side_ *= 2;
    pictures_.clear();
    all = lay_out();
  }
  tiles_.resize(all);
}

void ErrorMap::learn(std::span<const Patch> patches, std::span<const Vec3> errors) {
  for (std::size_t p = 0; p < patches.size(); ++p) {
    if (!patches[p].own_moment) continue;
    float squared = 0;
    for (const Vec3& e : errors.subspan(4 * p, 4)) squared += dot(e, e);
    const Picture& picture = pictures_[std::size_t(patches[p].frame)];
    const auto width = std::uint32_t(picture.width), side = std::uint32_t(side_);
    float& tile = tiles_[picture.first + patches[p].block / width / side * std::size_t(picture.along) +
                         patches[p].block % width / side];
    tile = tile > 0 ? tile + kNewest * (squared - tile) : squared;
  }
}

ErrorDraw ErrorMap::draw(int frame) const {
  const Picture& p = pictures_[std::size_t(frame)];
  const std::size_t count = std::size_t(p.along) * std::size_t(tiles_along(p.height, side_));
  return {std::span(tiles_).subspan(p.first, count), p.along, side_, p.width, p.height};
}

}  // namespace splinevox
