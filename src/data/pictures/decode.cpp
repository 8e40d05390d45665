// SPDX-License-Identifier: Apache-2.0
#include "data/pictures/decode.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <utility>
#include <vector>

#include "core/half.hpp"
#include "core/in_order.hpp"
#include "core/parallel.hpp"
#include "data/fingerprint.hpp"
#include "data/pictures/film_read.hpp"
#include "data/pictures/picture_header.hpp"
#include "data/pictures/read_picture.hpp"
#include "math/srgb.hpp"
#include "splinevox/data/image_io.hpp"

namespace splinevox::data {
namespace {

constexpr float kMostLight = 65504;  ///< of linear light; some 100 as a screen shows it

/// Pictures that are begun and not handed over. More than one a thread, so that none waits for the first.
int at_once(int threads) { return 2 * threads; }

/// Values of linear light as a screen shows them, in place. @return whether some are below 0 or not finite
bool show(Image& rgba) {
  bool odd = false;
  for (std::size_t i = 0; i < rgba.data.size(); ++i) {
    float& v = rgba.data[i];
    odd |= !(v >= 0 && std::isfinite(v));
    v = v > 0 ? std::min(v, kMostLight) : 0;  // NaN compares false
    if (i % 4 != 3) v = linear_to_srgb(v);
  }
  return odd;
}

/// The same of whole numbers, 65535 = 1.
void show(Image16& image) {
  for (std::size_t i = 0; i < image.rgba.size(); ++i)
    if (i % 4 != 3) image.rgba[i] = std::uint16_t(linear_to_srgb(image.rgba[i] / 65535.0f) * 65535 + 0.5f);
}

/// cut_out of a picture of floats.
Image cut_out(Image rgba, const MaskPlan& masks, std::size_t i) {
  if (!masks.cuts_out(i)) return rgba;
  const Image16 opaque{rgba.width, rgba.height, std::vector<std::uint16_t>(rgba.data.size(), 65535)};
  const Image16 kept = cut_out(opaque, masks, i);
  for (std::size_t k = 3; k < rgba.data.size(); k += 4) rgba.data[k] *= kept.rgba[k] / 65535.0f;
  return rgba;
}

bool is_odd(const Image& rgba) {
  return !std::all_of(rgba.data.begin(), rgba.data.end(), [](float v) { return v >= 0 && std::isfinite(v); });
}

std::array<std::uint16_t, 4> stored_halves(const Picture& image, std::size_t i) {
  const Picture::Layout layout = image.layout();
  std::array<std::uint16_t, 4> out{0, 0, 0, kHalfOne};
  std::memcpy(out.data(), image.values() + layout.size(i), layout.size(1));
  return out;
}

/// Every film once, its wanted frames in their order.
void decode_films(const PicturePlan& plan, const TakePicture& take) {
  std::map<std::filesystem::path, std::vector<std::size_t>> of_film;
  for (std::size_t i = 0; i < plan.paths.size(); ++i) of_film[plan.paths[i]].push_back(i);
  for (auto& [path, frames] : of_film) {
    std::sort(frames.begin(), frames.end(),
              [&](std::size_t a, std::size_t b) { return plan.film_frame[a] < plan.film_frame[b]; });
    std::vector<int> wanted;
    for (const std::size_t i : frames) wanted.push_back(plan.film_frame[i]);
    const PictureSize& size = plan.sizes[frames[0]];
    read_film(
        path, size, plan.turns[frames[0]] != 1, wanted,
        [&, &list = frames](std::size_t k, Image16&& image) {
          Image16 small = area_downscale(std::move(image), plan.downscale);
          if (plan.linear[list[k]]) show(small);
          Picture picture = small;
          const PictureFacts facts = facts_of(picture);
          take(list[k], std::move(picture), facts);
        },
        plan.where[frames[0]]);
  }
}

}  // namespace

FilePixels kept_pixels(const PicturePlan& plan, std::size_t i) {
  FilePixels pixels = read_pixels(plan.paths[i], plan.where[i], plan.layer);
  if (pixels.real.data.empty())
    pixels.whole = cut_out(turned(std::move(pixels.whole), plan.turns[i]), plan.masks, i);
  else
    pixels.real = cut_out(std::move(pixels.real), plan.masks, i);
  if (plan.masks.use.of_alpha) {
    for (std::size_t p = 3; p < pixels.whole.rgba.size(); p += 4) pixels.whole.rgba[p] = 65535;
    for (std::size_t p = 3; p < pixels.real.data.size(); p += 4) pixels.real.data[p] = 1;
  }
  return pixels;
}

Decoded decode_one(const PicturePlan& plan, std::size_t i) {
  FilePixels pixels = kept_pixels(plan, i);
  const ColourMean mean =
      pixels.premultiplied || plan.masks.cuts_out(i) ? ColourMean::by_alpha : ColourMean::plain;
  Decoded out;
  bool odd = false;
  if (pixels.real.data.empty()) {
    Image16 whole = area_downscale(std::move(pixels.whole), plan.downscale, mean);
    if (plan.linear[i]) show(whole);
    out.picture = whole;
  } else {
    Image real = area_downscale(std::move(pixels.real), plan.downscale, mean);
    odd = plan.linear[i] ? show(real) : is_odd(real);
    out.picture = Picture(real);
  }
  out.facts = facts_of(out.picture);
  out.facts.odd = odd;
  return out;
}

PictureFacts facts_of(const Picture& image) {
  PictureFacts facts;
  const std::uint64_t one = image.layout().half ? kHalfOne : 65535;
  Fingerprint hash;
  hash.add(std::uint64_t(image.width));
  hash.add(std::uint64_t(image.height));
  for (std::size_t i = 0; i < image.pixels(); ++i) {
    auto p = image.pixel(i);
    if (image.layout().half) p = stored_halves(image, i);
    const std::uint64_t r = p[0], g = p[1], b = p[2], a = p[3];
    hash.add(r | (g << 16) | (b << 32) | (a << 48));
    facts.see_through |= a < one;
    facts.invisible &= a == 0;
    facts.black &= a == 0 || (r | g | b) == 0;
  }
  facts.hash = hash.value();
  return facts;
}

void decode(const PicturePlan& plan, const TakePicture& take) {
  if (plan.film()) return decode_films(plan, take);
  std::vector<Decoded> decoded(plan.paths.size());
  in_order(
      int(decoded.size()), at_once(thread_count()),
      [&](int index) {
        const std::size_t i(index);
        decoded[i] = decode_one(plan, i);
      },
      [&](int index) {
        const std::size_t i(index);
        take(i, std::exchange(decoded[i].picture, {}), decoded[i].facts);
        return true;
      });
}

PictureMemory memory_for(const PicturePlan& plan, int threads) {
  PictureMemory out;
  for (std::size_t i = 0; i < plan.sizes.size(); ++i) {
    const double pixels = double(plan.sizes[i].width) * plan.sizes[i].height;
    const double kept = plan.pixel_bytes[i] * pixels / plan.downscale / plan.downscale;
    const bool twice = plan.downscale > 1 || plan.turns[i] != 1 || plan.real[i];
    const double stored =
        4 * (plan.real[i] ? sizeof(float) : sizeof(std::uint16_t));  // of a pixel as it is read
    out.kept += kept;
    out.pixels += pixels / plan.downscale / plan.downscale;
    out.passing =
        std::max(out.passing, threads * (twice ? 2 : 1) * stored * pixels + at_once(threads) * kept);
  }
  return out;
}

}  // namespace splinevox::data
