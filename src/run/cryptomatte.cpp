// SPDX-License-Identifier: Apache-2.0
#include "run/cryptomatte.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <numeric>

#include "core/parallel.hpp"
#include "field/columns.hpp"
#include "run/compositing.hpp"
#include "run/support.hpp"

namespace splinevox::run {
namespace {

constexpr const char* kLayer = "crypto_part";
constexpr float kSure = 30;  ///< raw colour whose sigmoid is 1, and 0 below zero

/// The model with red, green and blue of 1 where matter is of the clusters `first`, first + 1 and first + 2,
/// and 0 elsewhere, from every side and at every time; nothing behind it. A colour is then the sum of the
/// shares that a cluster's samples have.
VoxelModel mask_of(const VoxelModel& model, const MotionClusters& clusters, int first) {
  VoxelModel out = nothing_behind(model);
  Channels& raw = out.radiance.raw;
  const auto mark = [&](std::size_t row, int label) {
    float* values = raw.row(row);
    for (int c = 0; c < 3; ++c) values[1 + c] = std::max(0, label) == first + c ? kSure : -kSure;
    std::fill_n(values + 4, out.radiance.sh_count(), 0.0f);
    if (out.radiance.sh_count() > 0) values[4] = -100;  // the view takes nothing away
  };
  for (int i = 0; i < kBrickRows; ++i) mark(std::size_t(i), 0);
  parallel_for(raw.topology->brick_count(), [&](int brick) {
    for (int i = 0; i < kBrickRows; ++i)
      mark(std::size_t(brick + 1) * kBrickRows + std::size_t(i),
           clusters.at(raw.topology->position(brick + 1, i)));
  });
  for (const Column& light : columns_of(out, ColumnKind::light))
    for (Channels& level : out.motion.levels)
      for (std::size_t at = std::size_t(light.first); at < level.values.size();
           at += std::size_t(level.width))
        level.values[at] = 0;
  return out;
}

}  // namespace

std::uint32_t murmur3(std::string_view bytes, std::uint32_t seed) {
  const auto scrambled = [](std::uint32_t k) { return std::rotl(k * 0xcc9e2d51u, 15) * 0x1b873593u; };
  std::uint32_t h = seed;
  std::size_t at = 0;
  for (; at + 4 <= bytes.size(); at += 4) {
    std::uint32_t k = 0;
    for (std::size_t b = 0; b < 4; ++b) k |= std::uint32_t(std::uint8_t(bytes[at + b])) << (8 * b);
    h = std::rotl(h ^ scrambled(k), 13) * 5 + 0xe6546b64u;
  }
  std::uint32_t rest = 0;
  for (std::size_t b = 0; at + b < bytes.size(); ++b)
    rest |= std::uint32_t(std::uint8_t(bytes[at + b])) << (8 * b);
  h ^= scrambled(rest) ^ std::uint32_t(bytes.size());
  h = (h ^ h >> 16) * 0x85ebca6bu;
  h = (h ^ h >> 13) * 0xc2b2ae35u;
  return h ^ h >> 16;
}

std::uint32_t crypto_id(std::string_view name) {
  const std::uint32_t hash = murmur3(name), exponent = hash >> 23 & 255;
  return exponent == 0 || exponent == 255 ? hash ^ 1u << 23 : hash;
}

PartMattes::PartMattes(const VoxelModel& model, const MotionClusters& clusters, Device device) {
  Json manifest = Json::object();
  for (std::size_t c = 0; c < clusters.clusters.size(); ++c) {
    const std::string name = fmt::format("cluster_{}", c);
    const std::uint32_t id = crypto_id(name);
    ids_.push_back(std::bit_cast<float>(id));
    manifest[name] = fmt::format("{:08x}", id);
  }
  const std::string key = "cryptomatte/" + fmt::format("{:08x}", murmur3(kLayer)).substr(0, 7) + "/";
  attributes_ = {{key + "name", kLayer},
                 {key + "hash", "MurmurHash3_32"},
                 {key + "conversion", "uint32_to_float32"},
                 {key + "manifest", json_text(manifest)}};
  for (int first = 0; first < int(ids_.size()); first += 3) masks_.push_back(mask_of(model, clusters, first));
  for (const VoxelModel& mask : masks_) renderers_.push_back(make_renderer(mask, device));
}

std::vector<Image> PartMattes::coverage(const Camera& camera, double time, const Image& alpha,
                                        const RenderOptions& options) {
  std::vector<Image> out(ids_.size(), Image(alpha.width, alpha.height, 1));
  for (std::size_t m = 0; m < renderers_.size(); ++m) {
    const Image shares = renderers_[m].render(camera, time, options).rgb;
    for (std::size_t c = 0; c < 3 && 3 * m + c < out.size(); ++c)
      for (std::size_t p = 0; p < alpha.pixels(); ++p)
        out[3 * m + c].data[p] = std::max(0.0f, shares.data[3 * p + c]);
  }
  // Where three parts meet within a voxel, interpolated colours of parts add up to a little less or more.
  for (std::size_t p = 0; p < alpha.pixels(); ++p) {
    float sum = 0;
    for (const Image& part : out) sum += part.data[p];
    for (Image& part : out) part.data[p] *= sum > 0 ? alpha.data[p] / sum : 0;
  }
  return out;
}

std::vector<ExrLayer> PartMattes::layers(const Camera& camera, double time, const Image& alpha,
                                         const RenderOptions& options) {
  const std::vector<Image> parts = coverage(camera, time, alpha, options);
  std::vector<ExrLayer> out;
  for (std::size_t r = 0; r < parts.size(); r += 2)
    out.push_back({fmt::format("{}{:02}", kLayer, r / 2), Image(alpha.width, alpha.height, 4), {}});
  std::vector<std::size_t> order(parts.size());
  for (std::size_t p = 0; p < alpha.pixels(); ++p) {
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return parts[a].data[p] > parts[b].data[p]; });
    for (std::size_t r = 0; r < order.size() && parts[order[r]].data[p] > 0; ++r) {
      float* pair = out[r / 2].image.data.data() + 4 * p + 2 * (r % 2);
      pair[0] = ids_[order[r]];
      pair[1] = parts[order[r]].data[p];
    }
  }
  return out;
}

}  // namespace splinevox::run
