// SPDX-License-Identifier: Apache-2.0
#include "data/pictures/mask_read.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "core/in_order.hpp"
#include "core/parallel.hpp"
#include "core/squares.hpp"
#include "data/message_text.hpp"
#include "data/pictures/picture_header.hpp"
#include "data/pictures/pictures.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::data {
namespace {

constexpr int kWhite = 65535, kMiddle = 32768;
constexpr int kGrey = 32 * 257;  ///< between channels: what a JPEG makes of grey

/// Least and most of something over a picture.
struct Range {
  int lo = kWhite, hi = 0;
  void add(int v) {
    lo = std::min(lo, v);
    hi = std::max(hi, v);
  }
  bool varies() const { return hi > lo; }
};

/// Work on the masks of all frames that have one, on all cores; of several errors the first frame's comes
/// out.
template <class Work>
void for_each_mask(const MaskPlan& plan, const Work& work) {
  in_order(
      int(plan.files.size()), 2 * thread_count(),
      [&](int i) {
        if (!plan.files[std::size_t(i)].empty()) work(std::size_t(i));
      },
      [](int) { return true; });
}

}  // namespace

MaskPlan plan_masks(const std::filesystem::path& folder, const RawSplit& split, const MaskUse& use,
                    const std::vector<PictureSize>& sizes, const std::vector<int>& turns) {
  MaskPlan plan;
  plan.use = use;
  if (use.what == MaskUse::What::none) return plan;
  for (std::size_t i = 0; i < split.frames.size(); ++i) {
    const RawFrame& frame = split.frames[i];
    const std::string of = frame.file_path + " (" + split.name + ", frame " + std::to_string(i) + ")";
    plan.files.push_back(frame.mask_file);
    plan.where.push_back(printable((folder / frame.mask).string() + ", the mask of " + of));
    plan.turns.push_back(turns[i]);
    if (frame.mask_file.empty()) continue;
    std::string problem;
    try {
      const PictureSize size = read_picture_header(frame.mask_file, plan.where[i]).size;
      if (turned(size, turns[i]) == sizes[i]) {
        plan.guessed += turns[i] != 1 && size == sizes[i];
        continue;
      }
      plan.turns[i] = 1;
      if (size == sizes[i]) continue;
      fail({plan.where[i], "the mask is of another size than its picture", size_text(sizes[i]),
            size_text(size), "make masks of the pictures as they are stored"});
    } catch (const Error& error) {
      if (use.used()) throw;
      problem = error.problem.where + ": " + error.problem.what;
    }
    plan.files[i].clear();
    if (++plan.misfits == 1) plan.misfit = problem;
  }
  return plan;
}

double Mask::mean() const {
  return double(std::accumulate(white.begin(), white.end(), std::uint64_t(0))) / kWhite /
         double(std::max<std::size_t>(white.size(), 1));
}

Mask read_mask(const MaskPlan& plan, std::size_t i) {
  const Image16 image = turned(read_picture(plan.files[i], plan.where[i]), plan.turns[i]);
  if (plan.use.of_alpha) {
    Mask mask{image.width, image.height, {}, false};
    for (std::size_t p = 0; p < image.pixels(); ++p) mask.white.push_back(image.rgba[4 * p + 3]);
    return mask;
  }
  Range grey, alpha;
  int colour = 0;
  std::size_t coloured = 0;  // the pixel with the most colour
  for (std::size_t p = 0; p < image.pixels(); ++p) {
    const std::uint16_t* v = image.rgba.data() + 4 * p;
    const auto [lo, hi] = std::minmax({v[0], v[1], v[2]});
    grey.add(hi);
    alpha.add(v[3]);
    if (hi - lo > colour) {
      colour = hi - lo;
      coloured = p;
    }
  }
  // Where the alpha is 0 everywhere, what it would cut out is not in the picture.
  const bool by_alpha = (alpha.varies() || alpha.hi == 0) && (!grey.varies() || colour > kGrey);
  if (colour > kGrey && !by_alpha) {
    const std::uint16_t* v = image.rgba.data() + 4 * coloured;
    fail({plan.where[i], "the mask has colours", "black and white, or what is meant as alpha",
          "a pixel of (" + std::to_string(v[0] / 257) + ", " + std::to_string(v[1] / 257) + ", " +
              std::to_string(v[2] / 257) + ")",
          "make a grey picture of the parts that are meant: white for them, black for all others"});
  }
  constexpr int kOne = 257;  // of 8 bits: a mask of 0 and 1, as programs write what is no picture to them
  const bool of_ones = grey.hi == kOne && !by_alpha;
  Mask mask{image.width, image.height, {}, of_ones};
  mask.white.reserve(image.pixels());
  for (std::size_t p = 0; p < image.pixels(); ++p) {
    const std::uint16_t* v = image.rgba.data() + 4 * p;
    const std::uint64_t g = (of_ones ? 255 : 1) * std::max({v[0], v[1], v[2]}), a = v[3];
    mask.white.push_back(std::uint16_t(by_alpha ? a : alpha.varies() ? (g * a + kMiddle - 1) / kWhite : g));
  }
  return mask;
}

Image16 cut_out(Image16 picture, const MaskPlan& plan, std::size_t i) {
  if (!plan.cuts_out(i)) return picture;
  const Mask mask = read_mask(plan, i);
  const bool black = plan.use.keeps_black(plan.files[i]);
  for (std::size_t p = 0; p < picture.pixels(); ++p) {
    std::uint16_t& alpha = picture.rgba[4 * p + 3];
    const std::uint64_t kept = black ? kWhite - mask.white[p] : mask.white[p];
    alpha = std::uint16_t((alpha * kept + kMiddle - 1) / kWhite);
  }
  return picture;
}

std::vector<PixelMask> read_ignored(const MaskPlan& plan, int downscale) {
  std::vector<PixelMask> out(plan.files.size());
  for_each_mask(plan, [&](std::size_t i) {
    const Mask mask = read_mask(plan, i);
    const bool black = plan.use.keeps_black(plan.files[i]);
    PixelMask ignored(mask.width, mask.height);
    for (std::size_t p = 0; p < mask.white.size(); ++p)
      if ((mask.white[p] >= kMiddle) == black) ignored.set(p);
    if (ignored.count() > 0) out[i] = area_downscale(ignored, downscale);
  });
  return out;
}

std::vector<CoarseMask> read_moving(const MaskPlan& plan, const std::vector<PictureSize>& sizes,
                                    int downscale) {
  std::vector<CoarseMask> out(plan.files.size());
  for (std::size_t i = 0; i < out.size(); ++i) {
    const int w = sizes[i].width / downscale, h = sizes[i].height / downscale;
    out[i].factor = squares_factor(w, h);
    out[i].squares = PixelMask(w / out[i].factor, h / out[i].factor);
    if (plan.files[i].empty())
      for (std::size_t p = 0; p < out[i].squares.pixels(); ++p) out[i].squares.set(p);
  }
  for_each_mask(plan, [&](std::size_t i) {
    const Mask mask = read_mask(plan, i);
    const bool black = plan.use.keeps_black(plan.files[i]);
    PixelMask& squares = out[i].squares;
    const int pixels = downscale * out[i].factor;  // of the stored picture, along a square
    for (int y = 0; y < mask.height; ++y)
      for (int x = 0; x < mask.width; ++x)
        if ((mask.white[std::size_t(y) * std::size_t(mask.width) + std::size_t(x)] >= kMiddle) == black)
          squares.set(std::size_t(std::min(y / pixels, squares.height() - 1)) * std::size_t(squares.width()) +
                      std::size_t(std::min(x / pixels, squares.width() - 1)));
  });
  return out;
}

std::vector<PixelMask> read_inside(const MaskPlan& plan, int downscale) {
  std::vector<PixelMask> out(plan.files.size());
  const std::uint64_t half = std::uint64_t(kMiddle) * std::uint64_t(downscale) * std::uint64_t(downscale);
  for_each_mask(plan, [&](std::size_t i) {
    const Mask mask = read_mask(plan, i);
    PixelMask inside(mask.width / downscale, mask.height / downscale);
    for (int y = 0; y < inside.height(); ++y)
      for (int x = 0; x < inside.width(); ++x) {
        std::uint64_t sum = 0;
        for (int dy = 0; dy < downscale; ++dy)
          for (int dx = 0; dx < downscale; ++dx)
            sum += mask.white[std::size_t(y * downscale + dy) * std::size_t(mask.width) +
                              std::size_t(x * downscale + dx)];
        if (sum >= half) inside.set(std::size_t(y) * std::size_t(inside.width()) + std::size_t(x));
      }
    out[i] = std::move(inside);
  });
  return out;
}

MaskLook look_at_masks(const std::vector<const MaskPlan*>& plans, std::size_t most) {
  std::vector<std::pair<const MaskPlan*, std::size_t>> all, chosen;
  for (const MaskPlan* plan : plans)
    for (std::size_t i = 0; i < plan->files.size(); ++i)
      if (!plan->files[i].empty()) all.emplace_back(plan, i);
  const std::size_t n = std::min(most, all.size());
  for (std::size_t k = 0; k < n; ++k) chosen.push_back(all[k * all.size() / n]);
  MaskLook look;
  std::vector<Mask> masks(n);
  in_order(
      int(n), 2 * thread_count(),
      [&](int k) {
        masks[std::size_t(k)] = read_mask(*chosen[std::size_t(k)].first, chosen[std::size_t(k)].second);
      },
      [&](int k) {
        const Mask mask = std::exchange(masks[std::size_t(k)], {});
        const auto [lo, hi] = std::minmax_element(mask.white.begin(), mask.white.end());
        ++look.looked_at;
        look.black += *hi < kMiddle ? 1 : 0;
        look.white += *lo >= kMiddle ? 1 : 0;
        look.mean += mask.mean() / double(n);
        look.brightest = std::max(look.brightest, *hi);
        look.ones += mask.of_ones ? 1 : 0;
        look.numbers += !mask.of_ones && *hi > 0 && *hi < kLabels ? 1 : 0;
        return true;
      });
  return look;
}

}  // namespace splinevox::data
