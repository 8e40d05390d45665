// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "data/expect_error.hpp"
#include "data/wild.hpp"
#include "splinevox/data/image_io.hpp"

namespace splinevox::test {

inline constexpr int kMasks = 10;

/// A grey PNG whose pixels are value(x, y).
template <class Value>
TinyPng grey_png(const Value& value, int wide = kWide, int high = kHigh) {
  TinyPng png{wide, high, 8, PngKind::grey, {}};
  for (int y = 0; y < high; ++y)
    for (int x = 0; x < wide; ++x) png.rows.push_back(std::uint8_t(value(x, y)));
  return png;
}

/// White in the left half, with a column of 128 as its edge.
inline int left_half(int x, int) { return x < 5 ? 255 : x == 5 ? 128 : 0; }

inline LoadOptions with(const std::string& masks, int downscale = 1) {
  LoadOptions options;
  options.downscale = downscale;
  options.rules.masks = masks;
  return options;
}

/// nerfstudio's layout, opaque, with mask `png` for every picture as `name(i)`.
struct Masked {
  TempFolder folder;
  explicit Masked(const TinyPng& png = grey_png(left_half), const std::string& before = "masks/frame_",
                  const std::string& behind = ".png") {
    write_nerfstudio(folder.path(), true_cameras({}, kMasks));
    for (int i = 0; i < kMasks; ++i) write_png(folder.path() / (before + padded(i) + behind), png);
  }
  Dataset load(const LoadOptions& options) const { return load_dataset(folder.str(), options); }
  std::string error(const std::string& masks) const {
    return error_of([&] { load(with(masks)); });
  }
};

inline bool holds(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace splinevox::test
