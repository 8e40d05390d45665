// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "splinevox/data/image_io.hpp"

namespace splinevox::data {

/// A place in a picture, or a way from one place to another, in pixels to the right and down. The centre of
/// the first pixel is at (0.5, 0.5).
struct PixelPlace {
  double u = 0, v = 0;
};

/// Optical flow: where what a pixel of one picture shows lies in another.
struct FlowField {
  PictureSize size;
  std::vector<float> values;  ///< [height * width * 2], pixels to the right and down; not finite: not known

  /// The way from a place, bilinear. None: the place is outside, or a pixel beside it has none.
  std::optional<PixelPlace> at(PixelPlace place) const;
};

enum class FlowWay {
  forward,  ///< to the next picture
  backward  ///< to the one before
};

/// A file of flow: .flo of the Middlebury benchmark; .npy or .npz with an array `flow` or no other, of shape
/// (height, width, 2) or (2, height, width); OpenEXR with channels u and v, or R and G, of no layer, of
/// one called `forward` or `backward` as `way` is, or of the only one that has any. Throws Error
/// (Fault::input) for another file, a damaged one, or another shape.
FlowField read_flow(const std::filesystem::path& path, const std::string& where, FlowWay way);

/// Files of flow in a folder, by the pictures they lead from and to.
struct FlowFiles {
  std::vector<std::string> forward;   ///< names; the k-th leads from picture k to the next
  std::vector<std::string> backward;  ///< the k-th leads from picture k + 1 to the one before; may be empty
};

/// What has "bwd" or "backward" in its name leads backward; in the order in which people count. Throws Error
/// (Fault::input) if there is no flow in the folder, or both ways and not as many files.
FlowFiles find_flow(const std::filesystem::path& folder, const std::string& where);

}  // namespace splinevox::data
