// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace splinevox {

/// Some of a picture's pixels: a bit each, row-major from the top left. One without a size has none.
class PixelMask {
 public:
  PixelMask() = default;
  PixelMask(int width, int height)
      : width_(width), height_(height), words_((std::size_t(width) * height + 63) / 64) {}
  int width() const { return width_; }
  int height() const { return height_; }
  std::size_t pixels() const { return std::size_t(width_) * height_; }
  bool empty() const { return words_.empty(); }
  bool test(std::size_t i) const { return !words_.empty() && (words_[i >> 6] >> (i & 63) & 1) != 0; }
  bool test(int x, int y) const { return test(std::size_t(y) * width_ + x); }
  void set(std::size_t i) { words_[i >> 6] |= std::uint64_t(1) << (i & 63); }
  std::size_t count() const {
    std::size_t n = 0;
    for (const std::uint64_t w : words_) n += std::size_t(std::popcount(w));
    return n;
  }
  /// Whether every pixel of a picture is in it.
  bool all() const { return !words_.empty() && count() == pixels(); }
  const std::vector<std::uint64_t>& words() const { return words_; }
  /// @pre as many as there are
  void set_words(std::vector<std::uint64_t> words) { words_ = std::move(words); }
  /// @pre of the same size
  PixelMask& operator|=(const PixelMask& other) {
    for (std::size_t i = 0; i < words_.size(); ++i) words_[i] |= other.words_[i];
    return *this;
  }
  /// Calls visit(bits) for 64 pixels after 64, the first in the lowest bit.
  template <class Visit>
  void each_word(const Visit& visit) const {
    for (const std::uint64_t w : words_) visit(w);
  }
  friend bool operator==(const PixelMask&, const PixelMask&) = default;

 private:
  int width_ = 0, height_ = 0;
  std::vector<std::uint64_t> words_;
};

/// The same in squares of pixels.
struct CoarseMask {
  PixelMask squares;
  int factor = 1;  ///< pixels along a square; those that are left over at an edge belong to the last one

  bool empty() const { return squares.empty(); }
  bool test(int x, int y) const {
    return !squares.empty() && squares.test(std::min(x / factor, squares.width() - 1),
                                            std::min(y / factor, squares.height() - 1));
  }
  friend bool operator==(const CoarseMask&, const CoarseMask&) = default;
};

}  // namespace splinevox
