// SPDX-License-Identifier: Apache-2.0
#include "data/pictures/tiff_read.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/half.hpp"
#include "data/file_bytes.hpp"
#include "data/pictures/tiff_unpack.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::data {
namespace {

constexpr std::uint64_t kLongestSide = 1u << 16;
constexpr std::uint64_t kPackBound = 4096;  ///< bytes of a byte of the file, at most; LZW may reach 2700

/// Tags of TIFF 6.0.
enum Tag : std::uint64_t {
  kWidth = 256,
  kHeight,
  kBits,
  kCompression,
  kPhotometric = 262,
  kStripOffsets = 273,
  kOrientation,
  kSamples = 277,
  kRowsPerStrip,
  kStripBytes,
  kPlanar = 284,
  kPredictor = 317,
  kTileWidth = 322,
  kTileHeight,
  kTileOffsets,
  kTileBytes,
  kExtraSamples = 338,
  kSampleFormat
};

/// How pixels are stored.
struct Layout {
  std::uint64_t width = 0, height = 0;
  int bits = 8, samples = 1, predictor = 1, alpha = -1;  ///< alpha: which sample; -1: none
  bool real = false, grey = false, white_is_zero = false, premultiplied = false;
  TiffPacking packing = TiffPacking::plain;
  std::uint64_t block_width = 0, block_height = 0;  ///< of a strip or a tile
  std::vector<std::uint64_t> offsets, sizes;        ///< of their bytes, row by row
  std::size_t sample_bytes() const { return std::size_t(bits) / 8; }
  std::size_t row_bytes() const { return block_width * std::size_t(samples) * sample_bytes(); }
};

/// The first directory of a file, every place checked against its length.
class Directory {
 public:
  Directory(std::span<const std::uint8_t> bytes, const std::string& where) : bytes_(bytes), where_(where) {
    little_ = bytes.size() > 1 && bytes[0] == 'I';
    if (const std::uint64_t version = number(2, 2); version != 42)
      refuse("this kind of TIFF is not supported", "a TIFF of version 42",
             version == 43 ? "a BigTIFF" : "version " + std::to_string(version));
    first_ = number(4, 4);
    count_ = number(first_, 2);
  }
  bool little() const { return little_; }
  std::span<const std::uint8_t> bytes() const { return bytes_; }

  [[noreturn]] void refuse(const std::string& what, const std::string& expected,
                           const std::string& got) const {
    fail({where_, what, expected, got, "mogrify -format png, or oiiotool a.tif -o a.exr"});
  }
  [[noreturn]] void damaged(const std::string& got) const {
    fail({where_, "the image is truncated or damaged", "a whole TIFF", got, "copy or make the file again"});
  }
  /// All numbers of a tag; empty if it is not there.
  std::vector<std::uint64_t> all(Tag tag) const {
    for (std::uint64_t i = 0; i < count_; ++i) {
      const std::uint64_t entry = first_ + 2 + 12 * i;
      if (number(entry, 2) != tag) continue;
      const std::uint64_t type = number(entry + 2, 2), n = number(entry + 4, 4);
      const std::uint64_t size = type == 1 ? 1 : type == 3 ? 2 : type == 4 ? 4 : 0;
      if (size == 0) damaged("tag " + std::to_string(tag) + " of type " + std::to_string(type));
      if (n * size > bytes_.size()) damaged("a list of " + std::to_string(n) + " numbers");
      const std::uint64_t at = n * size <= 4 ? entry + 8 : number(entry + 8, 4);
      std::vector<std::uint64_t> out;
      for (std::uint64_t k = 0; k < n; ++k) out.push_back(number(at + k * size, size));
      return out;
    }
    return {};
  }
  std::uint64_t one(Tag tag, std::optional<std::uint64_t> otherwise = {}) const {
    const std::vector<std::uint64_t> list = all(tag);
    if (list.empty() && !otherwise) damaged("no tag " + std::to_string(tag));
    return list.empty() ? *otherwise : list[0];
  }

 private:
  std::uint64_t number(std::uint64_t at, std::uint64_t size) const {
    if (at > bytes_.size() || size > bytes_.size() - at)
      damaged("an end after " + std::to_string(bytes_.size()) + " bytes");
    std::uint64_t value = 0;
    for (std::uint64_t i = 0; i < size; ++i) value = value << 8 | bytes_[at + (little_ ? size - 1 - i : i)];
    return value;
  }

  std::span<const std::uint8_t> bytes_;
  const std::string& where_;
  bool little_ = true;
  std::uint64_t first_ = 0, count_ = 0;
};

/// What samples mean. Throws where it is nothing that is supported.
void read_samples(const Directory& d, Layout& l) {
  const std::vector<std::uint64_t> bits = d.all(kBits), formats = d.all(kSampleFormat),
                                   extra = d.all(kExtraSamples);
  const auto differ = [](const std::vector<std::uint64_t>& list) {
    return std::adjacent_find(list.begin(), list.end(), std::not_equal_to<>()) != list.end();
  };
  if (differ(bits) || differ(formats))
    d.refuse("the channels differ in kind", "channels of one kind", "several");
  const std::uint64_t b = bits.empty() ? 1 : bits[0], format = formats.empty() ? 1 : formats[0];
  const bool whole = format == 1 && (b == 8 || b == 16), real = format == 3 && (b == 16 || b == 32);
  if (!whole && !real)
    d.refuse("numbers of this kind are not supported", "8 or 16 bits, half or float",
             std::to_string(b) + " bits of format " + std::to_string(format));
  l.bits = int(b);
  l.real = real;
  const std::uint64_t photometric = d.one(kPhotometric), samples = d.one(kSamples, 1);
  if (photometric > 2)
    d.refuse("colours of this kind are not supported", "grey or RGB",
             "photometric " + std::to_string(photometric));
  l.grey = photometric < 2;
  l.white_is_zero = photometric == 0;
  const std::uint64_t colours = l.grey ? 1 : 3;
  if (samples < colours || samples > 16)
    d.refuse("the number of channels is out of range", std::to_string(colours) + " to 16",
             std::to_string(samples));
  l.samples = int(samples);
  for (std::size_t i = 0; i < extra.size() && colours + i < samples && l.alpha < 0; ++i)
    if (extra[i] == 1 || extra[i] == 2) {
      l.alpha = int(colours + i);
      l.premultiplied = extra[i] == 1;
    }
  if (extra.empty() && samples == colours + 1) l.alpha = int(colours);  // as other readers take it
  if (d.one(kPlanar, 1) != 1)
    d.refuse("the channels lie apart", "one after the other in each pixel", "planes");
  if (const std::uint64_t turned = d.one(kOrientation, 1); turned != 1)
    d.refuse("the picture is turned", "orientation 1", std::to_string(turned));
}

void read_blocks(const Directory& d, Layout& l) {
  const bool tiles = !d.all(kTileWidth).empty();
  l.block_width = tiles ? d.one(kTileWidth) : l.width;
  l.block_height =
      std::min(tiles ? d.one(kTileHeight) : d.one(kRowsPerStrip, l.height), tiles ? kLongestSide : l.height);
  if (l.block_width < 1 || l.block_width > kLongestSide || l.block_height < 1)
    d.damaged("strips or tiles of no size");
  l.offsets = d.all(tiles ? kTileOffsets : kStripOffsets);
  l.sizes = d.all(tiles ? kTileBytes : kStripBytes);
  const std::uint64_t across = (l.width + l.block_width - 1) / l.block_width,
                      down = (l.height + l.block_height - 1) / l.block_height;
  if (l.offsets.size() < across * down || l.sizes.size() < across * down)
    d.damaged(std::to_string(l.offsets.size()) + " of " + std::to_string(across * down) + " strips or tiles");
  for (std::uint64_t i = 0; i < across * down; ++i)
    if (l.offsets[i] > d.bytes().size() || l.sizes[i] > d.bytes().size() - l.offsets[i])
      d.damaged("strip or tile " + std::to_string(i) + " beyond the end");
  const std::uint64_t raw = l.row_bytes() * l.block_height * across * down;
  if (raw / kPackBound > d.bytes().size() || raw / 4 > kMostPixels * 16)
    d.damaged(std::to_string(raw) + " bytes of pixels in a file of " + std::to_string(d.bytes().size()));
}

Layout read_layout(const Directory& d) {
  Layout l;
  l.width = d.one(kWidth);
  l.height = d.one(kHeight);
  if (l.width < 1 || l.height < 1 || l.width > kLongestSide || l.height > kLongestSide ||
      l.width * l.height > kMostPixels)
    d.refuse("the image's size is out of range", "1 to 65536 pixels a side and at most 2^28 in all",
             std::to_string(l.width) + " x " + std::to_string(l.height));
  read_samples(d, l);
  const std::uint64_t packing = d.one(kCompression, 1);
  if (packing != 1 && packing != 5 && packing != 8 && packing != 32946 && packing != 32773)
    d.refuse("this packing is not supported", "none, LZW, Deflate or PackBits",
             "compression " + std::to_string(packing));
  l.packing = TiffPacking(packing);
  l.predictor = int(d.one(kPredictor, 1));
  if (l.predictor < 1 || l.predictor > 3 || (l.predictor == 3) != (l.real && l.predictor != 1))
    d.refuse("this predictor is not supported", "1, 2 for whole numbers, 3 for floats",
             std::to_string(l.predictor));
  read_blocks(d, l);
  return l;
}

/// Samples of a row in this machine's order, predictors undone, in place.
void undo(const Layout& l, bool little, std::span<std::uint8_t> row) {
  const std::size_t size = l.sample_bytes(), count = row.size() / size, step = std::size_t(l.samples);
  if (l.predictor == 3) {  // Adobe's TIFF note 3: bytes by rank, the highest first, each less its left one
    for (std::size_t i = step; i < row.size(); ++i) row[i] = std::uint8_t(row[i] + row[i - step]);
    const std::vector<std::uint8_t> ranks(row.begin(), row.end());
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t b = 0; b < size; ++b) row[i * size + size - 1 - b] = ranks[b * count + i];
    return;
  }
  if (!little && size > 1)
    for (std::size_t i = 0; i < count; ++i)
      std::reverse(row.begin() + std::ptrdiff_t(i * size), row.begin() + std::ptrdiff_t((i + 1) * size));
  if (l.predictor != 2) return;
  if (size == 1) {
    for (std::size_t i = step; i < count; ++i) row[i] = std::uint8_t(row[i] + row[i - step]);
  } else {
    for (std::size_t i = step; i < count; ++i) {
      std::uint16_t here, left;
      std::memcpy(&here, row.data() + 2 * i, 2);
      std::memcpy(&left, row.data() + 2 * (i - step), 2);
      here = std::uint16_t(here + left);
      std::memcpy(row.data() + 2 * i, &here, 2);
    }
  }
}

/// A sample: 65535 = 1 of whole numbers, as stored of floats.
float sample(const Layout& l, const std::uint8_t* at) {
  if (l.bits == 8) return 257.0f * *at;
  if (l.bits == 32) {
    float v;
    std::memcpy(&v, at, 4);
    return v;
  }
  std::uint16_t v;
  std::memcpy(&v, at, 2);
  return l.real ? from_half(v) : float(v);
}

void put_pixel(const Layout& l, const std::uint8_t* from, std::size_t i, FilePixels& out) {
  const float one = l.real ? 1 : 65535;
  const auto read = [&](int s) { return sample(l, from + std::size_t(s) * l.sample_bytes()); };
  const float alpha = l.alpha < 0 ? one : read(l.alpha);
  for (int c = 0; c < 4; ++c) {
    float v = c == 3 ? alpha : read(l.grey ? 0 : c);
    if (c < 3 && l.white_is_zero) v = one - v;
    if (c < 3 && l.premultiplied && alpha != one) v = alpha > 0 ? v / alpha * one : 0;
    if (l.real)
      out.real.data[4 * i + std::size_t(c)] = v;
    else
      out.whole.rgba[4 * i + std::size_t(c)] = std::uint16_t(std::min(v, 65535.0f) + 0.5f);
  }
}

}  // namespace

PictureHeader tiff_header(const std::filesystem::path& path, const std::string& where) {
  // A directory may stand at the end of its file.
  const std::vector<std::uint8_t> bytes = read_bytes(path, where, kLargestFile);
  const Layout l = read_layout(Directory(bytes, where));
  PictureHeader out;
  out.size = {int(l.width), int(l.height)};
  out.alpha = l.alpha >= 0;
  out.deep = l.bits > 8;
  out.real = l.real;
  return out;
}

FilePixels read_tiff(const std::filesystem::path& path, const std::string& where) {
  const std::vector<std::uint8_t> bytes = read_bytes(path, where, kLargestFile);
  const Directory d(bytes, where);
  const Layout l = read_layout(d);
  const int width = int(l.width), height = int(l.height);
  FilePixels out;
  out.premultiplied = l.premultiplied;
  if (l.real)
    out.real = Image(width, height, 4);
  else
    out.whole = {width, height, std::vector<std::uint16_t>(4 * l.width * l.height)};
  const std::uint64_t across = (l.width + l.block_width - 1) / l.block_width;
  const bool tiles = !d.all(kTileWidth).empty();
  const std::size_t pixel_bytes = std::size_t(l.samples) * l.sample_bytes();
  std::vector<std::uint8_t> block;
  for (std::uint64_t top = 0, i = 0; top < l.height; top += l.block_height)
    for (std::uint64_t k = 0; k < across; ++k, ++i) {
      const std::uint64_t rows = std::min(l.block_height, l.height - top);  // of a tile all rows are stored
      block.resize(l.row_bytes() * (tiles ? l.block_height : rows));
      if (!tiff_unpack(l.packing, std::span(bytes).subspan(l.offsets[i], l.sizes[i]), block))
        d.damaged("strip or tile " + std::to_string(i) + " that cannot be unpacked");
      for (std::uint64_t y = 0; y < rows; ++y) {
        undo(l, d.little(), std::span(block).subspan(y * l.row_bytes(), l.row_bytes()));
        for (std::uint64_t x = 0; x < l.block_width && k * l.block_width + x < l.width; ++x)
          put_pixel(l, block.data() + y * l.row_bytes() + x * pixel_bytes,
                    (top + y) * l.width + k * l.block_width + x, out);
      }
    }
  return out;
}

}  // namespace splinevox::data
