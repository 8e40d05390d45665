// SPDX-License-Identifier: Apache-2.0
#include "train/batch.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>

#include "core/parallel.hpp"
#include "core/rng.hpp"
#include "math/camera.hpp"
#include "math/exposure.hpp"
#include "render/field_view.hpp"
#include "train/by_time.hpp"

namespace splinevox {
namespace {

constexpr int kRing = 4;            ///< blocks around the silhouette that count as near it
constexpr float kMostOften = 4;     ///< times as often as elsewhere, that what moves is drawn at most
constexpr float kBusyShare = 0.9f;  ///< of the patches, taken near the silhouette

/// Random streams, one per kind of draw.
enum Stream : std::uint64_t { kDeck = 1, kPatch = 2, kRay = 3, kCarve = 4, kCameras = 5, kErrors = 6 };

/// Pixel k of a block, 0 to 3; a border that cuts the block repeats its last ones.
PixelIndex pixel_of(const Frame& frame, std::uint32_t block, int k) {
  const std::uint32_t w = std::uint32_t(blocks_along(frame.image.width));
  return {std::min(int(block % w) * 2 + (k & 1), frame.image.width - 1),
          std::min(int(block / w) * 2 + (k >> 1), frame.image.height - 1)};
}

/// A deck of n cards, shuffled anew for every round through it.
class Deck {
 public:
  Deck(std::uint64_t seed, Stream stream, int n) : seed_(seed), stream_(stream), cards_(std::size_t(n)) {}
  /// The i-th card of all rounds.
  int at(std::int64_t i) {
    const auto n = std::int64_t(cards_.size());
    if (const std::int64_t r = i / n; r != round_) {
      round_ = r;
      const Rng rng(seed_, stream_ + 16 * std::uint64_t(r));
      for (int k = 0; k < int(n); ++k) {
        const auto j = std::size_t(rng.below(k, k + 1));
        cards_[std::size_t(k)] = cards_[j];
        cards_[j] = k;
      }
    }
    return cards_[std::size_t(i % n)];
  }

 private:
  std::uint64_t seed_;
  Stream stream_;
  std::vector<int> cards_;
  std::int64_t round_ = -1;
};

}  // namespace

std::optional<PixelIndex> usable_pixel(const Frame& frame, std::uint32_t block, int k) {
  for (int tried = 0; tried < 4; ++tried) {
    const PixelIndex p = pixel_of(frame, block, (k + tried) & 3);
    if (!frame.ignored.test(p.x, p.y)) return p;
  }
  return {};
}

BatchSampler::BatchSampler(const Split& train, const Box& box, const SamplingConfig& config,
                           std::uint64_t seed, float brightest)
    : train_(train),
      box_(box),
      config_(config),
      brightest_(brightest),
      seed_(seed),
      by_time_(frames_by_time(train)),
      rank_(train.frames.size()),
      shown_(train.frames.size()) {
  parallel_for(int(train.frames.size()),
               [&](int f) { shown_[f] = SilhouetteBlocks(train.frames[f], kRing); });
  for (std::size_t i = 0; i < by_time_.size(); ++i) rank_[by_time_[i]] = int(i);
  moments_ = starts_of_moments(by_time_, [&](int f) { return train.frames[std::size_t(f)].time; });
  config_.carve_speed *= std::max(1.0f, float(moments_of(train).size()) / float(kLongSequence));
  each_.resize(by_time_.size());
  std::iota(each_.begin(), each_.end(), std::size_t(0));
}

void BatchSampler::set_moving(const std::vector<CoarseMask>& moving, float rest) {
  changing_.resize(moving.size());
  parallel_for(int(moving.size()), [&](int f) {
    if (!moving[std::size_t(f)].empty())
      changing_[std::size_t(f)] = ChangingBlocks(train_.frames[std::size_t(f)], moving[std::size_t(f)]);
  });
  rest_ = rest;
}

const std::vector<std::size_t>& BatchSampler::moments(const CameraFits& cameras) const {
  // Nothing is made for a moment where there is but one; and cameras of which some are late share none.
  const bool late = std::any_of(cameras.cameras.begin(), cameras.cameras.end(),
                                [](const CameraFit& c) { return c.offset != 0; });
  return moments_.size() == 1 || late ? each_ : moments_;
}

std::vector<int> BatchSampler::frames_of_moment(std::size_t first, std::size_t end, std::int64_t visit,
                                                int most) const {
  const std::int64_t views = std::min(std::int64_t(end - first), std::int64_t(most));
  Deck deck(hash64(seed_ ^ hash64(first)), kCameras, int(end - first));
  std::vector<int> out;
  for (std::int64_t k = 0; k < views; ++k)
    out.push_back(by_time_[first + std::size_t(deck.at(visit * views + k))]);
  return out;
}

float BatchSampler::changing_share(int frame) const {
  const Picture& image = train_.frames[std::size_t(frame)].image;
  const float blocks = float(blocks_along(image.width)) * float(blocks_along(image.height));
  return std::min(config_.changing, kMostOften * float(changing_[std::size_t(frame)].count()) / blocks);
}

float BatchSampler::chance(const Patch& patch, const ErrorDraw* by_error) const {
  const std::size_t f = std::size_t(patch.frame);
  const SilhouetteBlocks& shown = shown_[f];
  const bool known = !changing_.empty() && changing_[f].count() > 0;
  const float changing = known ? changing_share(patch.frame) : 0, any = 1 / float(shown.usable_count());
  float out = any;
  if (const std::uint32_t near = shown.near_count(); near > 0) {
    float busy = shown.is_near(patch.block) ? 1 / float(near) : 0;
    if (by_error) busy += config_.hard_share * (by_error->chance(patch.block) - busy);
    out += std::max(0.0f, kBusyShare - changing) * (busy - any);
  }
  if (!known) return out;
  const float there = float(changing_[f].times(patch.block)) / float(changing_[f].count());
  return out + changing * (there - any);
}

Patch BatchSampler::draw_patch(std::uint64_t step, std::uint64_t number, int frame,
                               const ErrorDraw* by_error) const {
  const auto blocks = [&](int f) {
    const Picture& image = train_.frames[f].image;
    return std::uint32_t(blocks_along(image.width) * blocks_along(image.height));
  };
  const Rng carve(seed_, kCarve + 16 * step), patch(seed_, kPatch + 16 * step);
  if (carve.uniform(3 * number) < config_.carve) {
    const int reach = config_.carve_frames,
              drawn = int(carve.below(3 * number + 1, std::uint32_t(2 * reach)));
    const int away = drawn < reach ? drawn - reach : drawn - reach + 1;  // -reach..-1, 1..reach
    const int rank = rank_[frame] + away;
    if (rank >= 0 && rank < int(by_time_.size())) {
      const int other = by_time_[rank];
      const std::uint32_t block = carve.below(3 * number + 2, blocks(other));
      const double apart = std::abs(train_.frames[other].time - train_.frames[frame].time);
      const double margin = kRing + config_.carve_speed * apart * (train_.frames[other].image.width / 2);
      if (shown_[other].near_count() > 0 && shown_[other].clear(block, margin)) return {other, block};
    }
  }
  // One number decides on all: where nothing is known to change, pictures are drawn from as ever.
  if (!changing_.empty() && changing_[frame].count() > 0 && patch.uniform(2 * number) < changing_share(frame))
    return {frame, changing_[frame].at(patch.below(2 * number + 1, changing_[frame].count()))};
  const SilhouetteBlocks& shown = shown_[frame];
  const bool near = shown.near_count() > 0 && patch.uniform(2 * number) < kBusyShare;
  if (const Rng errors(seed_, kErrors + 16 * step);
      near && by_error && errors.uniform(4 * number) < config_.hard_share) {
    const std::uint32_t block = by_error->block(
        errors.uniform(4 * number + 1), errors.uniform(4 * number + 2), errors.uniform(4 * number + 3));
    if (usable_pixel(train_.frames[std::size_t(frame)], block, 0)) return {frame, block};
  }
  return {frame, near ? shown.near(patch.below(2 * number + 1, shown.near_count()))
                      : shown.usable(patch.below(2 * number + 1, shown.usable_count()))};
}

void BatchSampler::draw_patches(std::uint64_t step, std::uint64_t first, const std::vector<int>& views,
                                const ErrorMap* errors, std::span<Patch> out,
                                std::span<float> weights) const {
  std::map<int, ErrorDraw> by_error;
  if (errors)
    for (const int frame : views)
      if (const ErrorDraw draw = errors->draw(frame); draw.known()) by_error.emplace(frame, draw);
  const auto known = [&](int frame) {
    const auto at = by_error.find(frame);
    return at == by_error.end() ? nullptr : &at->second;
  };
  for (std::size_t p = 0; p < out.size(); ++p) {
    const int frame = views[p % views.size()];
    out[p] = draw_patch(step, first + p, frame, known(frame));
  }
  // Patches sorted along the pictures: neighbours in the list share what they fetch.
  std::sort(out.begin(), out.end());
  float sum = 0;
  int weighted = 0;
  for (std::size_t p = 0; p < out.size(); ++p) {
    const ErrorDraw* const draw = known(out[p].frame);
    weights[p] = draw ? std::pow(chance(out[p], nullptr) / chance(out[p], draw), config_.hard_undo) : 0;
    sum += weights[p];
    weighted += draw != nullptr;
  }
  const float scale = weighted > 0 ? float(weighted) / sum : 0;
  for (float& w : weights) w = w > 0 ? scale * w : 1;
}

std::span<const int> BatchSampler::window(double progress) const {
  if (whole(progress)) return by_time_;
  const int n = int(by_time_.size());
  const double share = config_.window + (1 - config_.window) * progress / config_.window_full;
  const int wanted = std::clamp(int(std::lround(share * n)), std::min(n, config_.frames), n);
  int first = (n - wanted) / 2, last = first + wanted;
  // Frames of one moment stay together.
  const auto time = [&](int rank) { return train_.frames[by_time_[rank]].time; };
  while (first > 0 && time(first - 1) == time(first)) --first;
  while (last < n && time(last) == time(last - 1)) ++last;
  return std::span(by_time_).subspan(first, last - first);
}

void BatchSampler::draw(std::int64_t index, double progress, float step, const Background& background,
                        const Surroundings& around, Batch& out, const CameraFits& cameras,
                        const DepthFits& depths, const ErrorMap* errors) const {
  const std::span<const int> window = this->window(progress);
  const std::vector<std::size_t>& starts = moments(cameras);
  const auto moment_at = [&](std::ptrdiff_t rank) {
    return std::lower_bound(starts.begin(), starts.end(), std::size_t(rank)) - starts.begin();
  };
  const std::ptrdiff_t from = window.data() - by_time_.data(), first_moment = moment_at(from);
  const int n = int(moment_at(from + std::ptrdiff_t(window.size())) - first_moment),
            frames = std::min(config_.frames, n), views = (config_.frames + frames - 1) / frames;
  const int rays = int(share_ * config_.rays * (1 + (config_.growth - 1) * progress));
  const int patches = std::max(1, rays / (4 * frames));
  out.frames.resize(frames);
  out.times.resize(frames);
  Deck deck(seed_, kDeck, n);
  const auto frames_of_card = [&](std::int64_t i) {
    const std::size_t moment = std::size_t(first_moment + deck.at(i));
    return frames_of_moment(starts[moment], moment + 1 < starts.size() ? starts[moment + 1] : by_time_.size(),
                            i / n, views);
  };
  std::vector<std::vector<int>> of_slot(static_cast<std::size_t>(frames));
  for (int f = 0; f < frames; ++f) {
    of_slot[f] = frames_of_card(index * frames + f);
    out.frames[f] = of_slot[f].front();
    out.times[f] = cameras.time_of(train_.frames[out.frames[f]]);
  }
  out.rays.resize(std::size_t(frames) * patches * 4);
  out.targets.resize(out.rays.size());
  out.lines.resize(around.any() ? out.rays.size() : 0);
  out.shown.resize(cameras.cameras.empty() ? 0 : out.rays.size());
  out.patches.resize(out.rays.size() / 4);
  out.depths.resize(depths.empty() ? 0 : out.rays.size());
  out.tasks.clear();
  const int per_frame = patches * 4;
  const bool random = config_.background != BackgroundKind::fixed && !background.learned(),
             opaque_random = random && config_.background != BackgroundKind::ground;
  for (int f = 0; f < frames; ++f)
    for (int first = 0; first < per_frame; first += kTaskRays)
      out.tasks.push_back({f, f * per_frame + first, f * per_frame + std::min(first + kTaskRays, per_frame)});

  const float voxel = step / config_.step, in_voxels = 1 / (voxel * voxel);
  out.draw = hash64(seed_ ^ hash64(std::uint64_t(index)));
  std::vector<std::vector<int>> used(frames);  // carving looks into others
  parallel_for(frames, [&](int f) {
    const Rng ray_rng(seed_, kRay + 16 * std::uint64_t(index));
    const std::span drawn = std::span(out.patches).subspan(std::size_t(f) * patches, patches);
    std::vector<float> weights(drawn.size());
    draw_patches(std::uint64_t(index), std::uint64_t(f) * patches, of_slot[f], errors, drawn, weights);
    for (Patch& p : drawn)  // what carves looks at another moment than its picture shows
      p.own_moment = cameras.time_of(train_.frames[p.frame]) == out.times[f];
    for (int p = 0; p < patches; ++p)
      for (int k = 0; k < 4; ++k) {
        const std::size_t r = std::size_t(f) * per_frame + 4 * p + k;
        const Frame& frame = train_.frames[drawn[p].frame];
        const std::uint32_t block = drawn[p].block;
        const auto [x, y] = *usable_pixel(frame, block, k);
        const Ray ray = camera_ray(frame.camera, x + 0.5, y + 0.5);
        const auto rgba = frame.image.rgba(x, y);
        const bool ends = !frame.image.layout().half, clipped = config_.clipped && ends;  // floats do not end
        // Without `clipped` the float before 1 stands for it, as it did when 1 said that it is a bound: the
        // published methods keep their bits.
        const float most =
            ends && !clipped ? std::nextafter(1.0f, 0.0f) : std::numeric_limits<float>::infinity();
        const Vec3 behind = (rgba[3] == 65535 ? opaque_random : random)
                                ? brightest_ * Vec3{ray_rng.uniform(4 * r), ray_rng.uniform(4 * r + 1),
                                                    ray_rng.uniform(4 * r + 2)}
                                : behind_box(background, around, ray);
        if (!out.lines.empty()) out.lines[r] = ray;
        out.rays[r] = clip_ray(ray, box_, step, ray_rng.uniform(4 * r + 3), behind);
        out.rays[r].weight = weights[p];
        const bool now = drawn[p].own_moment;
        if (!out.depths.empty())
          out.depths[r] =
              now ? depth_target(frame, x, y, ray, depths[std::size_t(drawn[p].frame)], out.rays[r], step)
                  : DepthTarget<float>{};
        if (!changing_.empty() && changing_[drawn[p].frame].known() && now &&
            !changing_[drawn[p].frame].near(x, y))
          out.rays[r].rest = in_voxels * rest_;
        const float alpha = rgba[3] * (1 / 65535.0f);
        const Vec3 shown = (alpha * (1 / 65535.0f)) * Vec3{rgba[0], rgba[1], rgba[2]},
                   gain = cameras.gain_of(frame);
        for (int c = 0; c < 3; ++c) {
          const float display = std::min(most, alpha * (rgba[c] * (1 / 65535.0f)) + (1 - alpha) * behind[c]);
          out.targets[r][c] = neutral_target(display, shown[c], gain[c], clipped);
        }
        if (!out.shown.empty()) out.shown[r] = {shown, cameras.index_of(frame), frame.time};
      }
    for (const Patch& p : drawn)
      if (used[f].empty() || used[f].back() != p.frame) used[f].push_back(p.frame);
  });
  // Of pictures in files, those of the next step are read while this one is made.
  for (const std::vector<int>& pictures : used)
    for (const int f : pictures) train_.frames[f].image.give_back();
  for (int f = 0; f < frames; ++f)
    for (const int frame : frames_of_card((index + 1) * frames + f)) train_.frames[frame].image.fetch();
}

}  // namespace splinevox
