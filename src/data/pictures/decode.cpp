// SPDX-License-Identifier: Apache-2.0
#include "data/pictures/decode.hpp"

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

#include "core/in_order.hpp"
#include "core/parallel.hpp"
#include "data/fingerprint.hpp"
#include "data/pictures/film_read.hpp"
#include "data/pictures/picture_header.hpp"
#include "splinevox/data/image_io.hpp"

namespace splinevox::data {
namespace {

/// Pictures that are begun and not handed over. More than one a thread, so that none waits for the first.
int at_once(int threads) { return 2 * threads; }

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
        path, size, wanted,
        [&, &list = frames](std::size_t k, Image16&& image) {
          Picture picture = area_downscale(std::move(image), plan.downscale);
          const PictureFacts facts = facts_of(picture);
          take(list[k], std::move(picture), facts);
        },
        plan.where[frames[0]]);
  }
}

}  // namespace

PictureFacts facts_of(const Picture& image) {
  PictureFacts facts;
  Fingerprint hash;
  hash.add(std::uint64_t(image.width));
  hash.add(std::uint64_t(image.height));
  for (std::size_t i = 0; i < image.pixels(); ++i) {
    const auto p = image.pixel(i);
    const std::uint64_t r = p[0], g = p[1], b = p[2], a = p[3];
    hash.add(r | (g << 16) | (b << 32) | (a << 48));
    facts.see_through |= a < 65535;
    facts.invisible &= a == 0;
    facts.black &= a == 0 || (r | g | b) == 0;
  }
  facts.hash = hash.value();
  return facts;
}

void decode(const PicturePlan& plan, const TakePicture& take) {
  if (plan.film()) return decode_films(plan, take);
  struct Decoded {
    Picture picture;
    PictureFacts facts;
  };
  std::vector<Decoded> decoded(plan.paths.size());
  in_order(
      int(decoded.size()), at_once(thread_count()),
      [&](int index) {
        const std::size_t i(index);
        Decoded& d = decoded[i];
        d.picture = area_downscale(
            cut_out(turned(read_picture(plan.paths[i], plan.where[i]), plan.turns[i]), plan.masks, i),
            plan.downscale);
        d.facts = facts_of(d.picture);
      },
      [&](int index) {
        const std::size_t i(index);
        take(i, std::exchange(decoded[i].picture, {}), decoded[i].facts);
        return true;
      });
}

PictureMemory memory_for(const PicturePlan& plan, int threads) {
  constexpr double kStored = sizeof(std::uint16_t) * 4;  // of a pixel of Image16
  PictureMemory out;
  for (std::size_t i = 0; i < plan.sizes.size(); ++i) {
    const double pixels = double(plan.sizes[i].width) * plan.sizes[i].height;
    const double kept = plan.pixel_bytes[i] * pixels / plan.downscale / plan.downscale;
    const bool twice = plan.downscale > 1 || plan.turns[i] != 1;
    out.kept += kept;
    out.pixels += pixels / plan.downscale / plan.downscale;
    out.passing =
        std::max(out.passing, threads * (twice ? 2 : 1) * kStored * pixels + at_once(threads) * kept);
  }
  return out;
}

}  // namespace splinevox::data
