// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/rng.hpp"
#include "model.hpp"
#include "splinevox/data/scene.hpp"

namespace splinevox::mlp {

/// Rays through the centres of every n-th pixel of every n-th row, from the (n / 2)-th on, clipped to the
/// box.
Rays view_rays(const Camera& camera, double time, const Box& box, int stride);
/// The colours of those pixels over a background: [n, 3].
torch::Tensor view_colors(const Picture& image, Vec3 background, int stride);
/// Pixels a side that a stride leaves.
inline int strided(int size, int stride) { return (size - stride / 2 + stride - 1) / stride; }

struct CropBatch {
  Rays rays;
  torch::Tensor color;  ///< [n, 3]
};

/// Squares of neighbouring pixels of random frames, on pictures shrunk by block means (their first stages in
/// the paper).
class CropSampler {
 public:
  CropSampler(const Split& train, const Box& box, const Settings& settings);
  /// Shrinks the pictures by K x K blocks from now on. Blocks that do not divide a picture leave its right
  /// and lower rim out.
  void set_shrink(int block);
  CropBatch draw(std::int64_t step) const;

 private:
  const Split& train_;
  Box box_;
  Settings settings_;
  int block_ = 1;
  std::vector<Picture> shrunk_;  ///< empty at block 1
};

}  // namespace splinevox::mlp
