// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "splinevox/core/vec3.hpp"
#include "splinevox/data/scene.hpp"
#include "train/patch.hpp"

namespace splinevox {

/// Which blocks of one picture are drawn how often, by the errors of its tiles.
class ErrorDraw {
 public:
  /// @param tiles  squared errors, row by row; 0: unknown, never drawn. @param along  of them in a row
  /// @param side  blocks along a tile. @param width and @param height  of the picture, blocks
  ErrorDraw(std::span<const float> tiles, int along, int side, int width, int height);
  bool known() const { return upto_.back() > 0; }
  /// A block, from three numbers in [0, 1): a tile as often as the root of its error, a block of it evenly.
  /// @pre known()
  std::uint32_t block(float tile, float x, float y) const;
  /// The chance that block() gives it.
  float chance(std::uint32_t block) const;

 private:
  /// Blocks of a tile from the first on, along one axis; those at the edges of a picture may be cut.
  static int length(int first, int side, int all) { return first + side < all ? side : all - first; }
  int along_, side_, width_, height_;
  std::vector<float> upto_;  ///< sums of the roots, and 0 before the first
};

/// Where training pictures are fitted worst: the squared photometric errors of square tiles of all pictures,
/// as the patches drawn there had them, newer ones counting more.
///
/// A half-fitted scene is fitted well almost everywhere. Rays drawn where it is not tell more
/// (docs/experiments.md).
class ErrorMap {
 public:
  ErrorMap() = default;  ///< of no picture: nothing is learned
  explicit ErrorMap(const Split& train);
  bool empty() const { return pictures_.empty(); }
  /// @param patches  of which each has four errors in turn; those of another moment say nothing
  /// @param errors  photometric, of every ray
  void learn(std::span<const Patch> patches, std::span<const Vec3> errors);
  ErrorDraw draw(int frame) const;
  template <class Archive>
  void archive(Archive& a) {
    a(tiles_);
  }
  std::size_t tiles() const { return tiles_.size(); }

 private:
  struct Picture {
    std::size_t first;         ///< of tiles_
    int along, width, height;  ///< tiles in a row; blocks
  };
  int side_ = 4;  ///< blocks along a tile
  std::vector<Picture> pictures_;
  std::vector<float> tiles_;
};

}  // namespace splinevox
