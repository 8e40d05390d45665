// SPDX-License-Identifier: Apache-2.0
#include "splinevox/train/batch.hpp"

#include <algorithm>

#include "splinevox/core/parallel.hpp"
#include "splinevox/core/rng.hpp"
#include "splinevox/math/camera.hpp"
#include "splinevox/render/field_view.hpp"

namespace splinevox {
namespace {

constexpr int kTaskRays = 128;
constexpr int kRing = 4;             ///< blocks around the silhouette that count as near it
constexpr float kBusyShare = 0.9f;   ///< of the patches, taken near the silhouette

/// Random streams, one per kind of draw.
enum Stream : std::uint64_t { kDeck = 1, kPatch = 2, kRay = 3 };

/// 2 x 2 blocks with any alpha within kRing blocks.
std::vector<std::uint32_t> busy_blocks(const Image16& image) {
  const int w = image.width / 2, h = image.height / 2;
  std::vector<char> hit(std::size_t(w) * h), near(hit.size());
  for (int y = 0; y < 2 * h; ++y)
    for (int x = 0; x < 2 * w; ++x)
      if (image.pixel(x, y)[3] > 0) hit[std::size_t(y / 2) * w + x / 2] = 1;
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      if (!hit[std::size_t(y) * w + x]) continue;
      for (int v = std::max(0, y - kRing); v <= std::min(h - 1, y + kRing); ++v)
        std::fill_n(near.begin() + std::size_t(v) * w + std::max(0, x - kRing),
                    std::min(w - 1, x + kRing) - std::max(0, x - kRing) + 1, char(1));
    }
  std::vector<std::uint32_t> out;
  for (std::size_t i = 0; i < near.size(); ++i)
    if (near[i]) out.push_back(std::uint32_t(i));
  return out;
}

/// The i-th card of a deck of n, shuffled anew for every round through it.
int card(std::uint64_t seed, std::int64_t i, int n, std::vector<int>& deck, std::int64_t& round) {
  if (const std::int64_t r = i / n; r != round) {
    round = r;
    deck.resize(n);
    const Rng rng(seed, kDeck + 16 * std::uint64_t(r));
    for (int k = 0; k < n; ++k) {
      const int j = int(rng.below(k, k + 1));
      deck[k] = deck[j];
      deck[j] = k;
    }
  }
  return deck[i % n];
}

}  // namespace

BatchSampler::BatchSampler(const Split& train, const Box& box, const SamplingConfig& config, Vec3 background, std::uint64_t seed)
    : train_(train), box_(box), config_(config), background_(background), seed_(seed), busy_(train.frames.size()) {
  parallel_for(int(train.frames.size()), [&](int f) { busy_[f] = busy_blocks(train.frames[f].image); });
}

void BatchSampler::draw(std::int64_t index, int rays, float step, Batch& out) const {
  const int n = int(train_.frames.size()), frames = std::min(config_.frames, n);
  const int patches = std::max(1, rays / (4 * frames));
  out.frames.resize(frames);
  std::vector<int> deck;
  std::int64_t round = -1;
  for (int f = 0; f < frames; ++f) out.frames[f] = card(seed_, index * frames + f, n, deck, round);
  out.rays.resize(std::size_t(frames) * patches * 4);
  out.targets.resize(out.rays.size());
  out.tasks.clear();
  const int per_frame = patches * 4;
  for (int f = 0; f < frames; ++f)
    for (int first = 0; first < per_frame; first += kTaskRays)
      out.tasks.push_back({f, f * per_frame + first, f * per_frame + std::min(first + kTaskRays, per_frame)});

  parallel_for(frames, [&](int f) {
    const Frame& frame = train_.frames[out.frames[f]];
    const auto& busy = busy_[out.frames[f]];
    const int w = std::max(1, frame.image.width / 2), h = std::max(1, frame.image.height / 2);
    const Rng patch_rng(seed_, kPatch + 16 * std::uint64_t(index)), ray_rng(seed_, kRay + 16 * std::uint64_t(index));
    // Patches sorted along the picture: neighbours in the list share what they fetch.
    std::vector<std::uint32_t> blocks(patches);
    for (int p = 0; p < patches; ++p) {
      const std::uint64_t i = 2 * (std::uint64_t(f) * patches + p);
      const bool near = !busy.empty() && patch_rng.uniform(i) < kBusyShare;
      blocks[p] = near ? busy[patch_rng.below(i + 1, std::uint32_t(busy.size()))] : patch_rng.below(i + 1, std::uint32_t(w * h));
    }
    std::sort(blocks.begin(), blocks.end());
    for (int p = 0; p < patches; ++p)
      for (int k = 0; k < 4; ++k) {
        const std::size_t r = std::size_t(f) * per_frame + 4 * p + k;
        const int x = std::min(int(blocks[p] % w) * 2 + (k & 1), frame.image.width - 1);
        const int y = std::min(int(blocks[p] / w) * 2 + (k >> 1), frame.image.height - 1);
        Vec3 background = background_;
        if (config_.background == BackgroundKind::random)
          background = {ray_rng.uniform(4 * r), ray_rng.uniform(4 * r + 1), ray_rng.uniform(4 * r + 2)};
        out.rays[r] = clip_ray(camera_ray(frame.camera, x + 0.5, y + 0.5), box_, step, ray_rng.uniform(4 * r + 3), background);
        const std::uint16_t* rgba = frame.image.pixel(x, y);
        const float alpha = rgba[3] * (1 / 65535.0f);
        for (int c = 0; c < 3; ++c) out.targets[r][c] = alpha * (rgba[c] * (1 / 65535.0f)) + (1 - alpha) * background[c];
      }
  });
}

}  // namespace splinevox
