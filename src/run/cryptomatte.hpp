// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "data/pictures/exr.hpp"
#include "splinevox/backend/device.hpp"
#include "splinevox/field/edit.hpp"
#include "splinevox/render/render_image.hpp"

/// Mattes of the parts that move alike, by the Cryptomatte specification 1.2 (Psyop).
namespace splinevox::run {

/// MurmurHash3_x86_32 (Austin Appleby, public domain).
std::uint32_t murmur3(std::string_view bytes, std::uint32_t seed = 0);

/// Bits of the float that stands for a name in the channels: its hash, of which a bit of the exponent is
/// turned over where the float would be none or too small.
std::uint32_t crypto_id(std::string_view name);

/// The parts of a model, and how much of every pixel each of them is.
class PartMattes {
 public:
  /// @param clusters  one part each, named cluster_0 and so on; matter of none goes with the static one
  PartMattes(const VoxelModel& model, const MotionClusters& clusters, Device device);

  /// Of each part the sum of the shares that its samples have in a pixel: [parts], one channel; at every
  /// pixel they add up to alpha. @param alpha  of the model's picture
  /// @param options  of that picture
  std::vector<Image> coverage(const Camera& camera, double time, const Image& alpha,
                              const RenderOptions& options = {});

  /// The same as layers crypto_part00 and so on, two parts a pixel each: R and B have whose, G and A have how
  /// much of it, the most first; 0 where there is no further part.
  std::vector<ExrLayer> layers(const Camera& camera, double time, const Image& alpha,
                               const RenderOptions& options = {});

  /// What the header says of them: name, hash, conversion and manifest.
  const std::map<std::string, std::string>& attributes() const { return attributes_; }

 private:
  std::vector<float> ids_;  ///< [parts] that stand for their names
  std::map<std::string, std::string> attributes_;
  std::vector<VoxelModel> masks_;  ///< three parts each
  std::vector<Renderer> renderers_;
};

}  // namespace splinevox::run
