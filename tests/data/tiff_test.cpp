// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>
#include <zlib.h>

#include <cstring>
#include <map>
#include <random>
#include <string>

#include "core/half.hpp"
#include "data/expect_error.hpp"
#include "data/pictures/tiff_read.hpp"
#include "support/tiny_dataset.hpp"

namespace {

using namespace splinevox;
using namespace splinevox::test;

enum class Kind { byte, word, half, real };

/// A TIFF for a test: value (x, y, c) is whatever `value` says, 0 to 1.
struct TinyTiff {
  int width = 37, height = 11, samples = 3, compression = 1, predictor = 1, extra = 2;
  Kind kind = Kind::byte;
  bool big_end = false, tiles = false;
  int photometric = 2;
};

float value(int x, int y, int c) { return float((x * 7 + y * 13 + c * 29 + (x / 5) * (y / 3)) % 101) / 100; }

int bytes_of(Kind kind) { return kind == Kind::byte ? 1 : kind == Kind::real ? 4 : 2; }

std::uint32_t stored(Kind kind, float v) {
  std::uint32_t bits = 0;
  if (kind == Kind::byte) return std::uint32_t(v * 255 + 0.5f);
  if (kind == Kind::word) return std::uint32_t(v * 65535 + 0.5f);
  if (kind == Kind::half) return to_half(v);
  std::memcpy(&bits, &v, 4);
  return bits;
}

void put(Bytes& out, std::uint32_t v, int bytes, bool big) {
  for (int i = 0; i < bytes; ++i) out.push_back(std::uint8_t(v >> 8 * (big ? bytes - 1 - i : i)));
}

/// Codes of 9 to 12 bits as TIFF 6.0 section 13 writes them.
Bytes lzw(const Bytes& in) {
  Bytes out;
  std::map<std::string, int> table;
  int next = 258, bits = 9, held = 0;
  std::uint32_t buffer = 0;
  const auto code = [&](int c) {
    buffer = buffer << bits | std::uint32_t(c);
    for (held += bits; held >= 8; held -= 8) out.push_back(std::uint8_t(buffer >> (held - 8)));
  };
  const auto number = [&](const std::string& text) {
    return text.size() == 1 ? int(std::uint8_t(text[0])) : table.at(text);
  };
  code(256);
  std::string text;
  for (const std::uint8_t b : in) {
    std::string longer = text;
    longer.push_back(char(b));
    if (longer.size() == 1 || table.contains(longer)) {
      text = longer;
      continue;
    }
    code(number(text));
    table[longer] = next++;
    if (next == 512 || next == 1024 || next == 2048) ++bits;
    if (next == 4094) {
      code(256);
      table.clear();
      next = 258;
      bits = 9;
    }
    text.assign(1, char(b));
  }
  code(number(text));
  code(257);
  if (held > 0) out.push_back(std::uint8_t(buffer << (8 - held)));
  return out;
}

Bytes packbits(const Bytes& in) {
  Bytes out;
  for (std::size_t i = 0; i < in.size();) {
    std::size_t same = 1;
    while (i + same < in.size() && same < 128 && in[i + same] == in[i]) ++same;
    out.push_back(same > 1 ? std::uint8_t(257 - same) : 0);
    out.push_back(in[i]);
    i += same;
  }
  return out;
}

Bytes packed(const TinyTiff& t, Bytes raw) {
  if (t.compression == 5) return lzw(raw);
  if (t.compression == 32773) return packbits(raw);
  if (t.compression == 1) return raw;
  uLongf size = ::compressBound(raw.size());
  Bytes out(size);
  ::compress(out.data(), &size, raw.data(), raw.size());
  out.resize(size);
  return out;
}

/// A row of pixels from x0 on, beyond the edge zeros, with its predictor.
Bytes row_of(const TinyTiff& t, int x0, int y, int width) {
  const int size = bytes_of(t.kind);
  std::vector<std::uint32_t> v;
  for (int x = x0; x < x0 + width; ++x)
    for (int c = 0; c < t.samples; ++c)
      v.push_back(x < t.width && y < t.height ? stored(t.kind, value(x, y, c)) : 0);
  Bytes out;
  if (t.predictor == 3) {
    for (int rank = size - 1; rank >= 0; --rank)
      for (const std::uint32_t s : v) out.push_back(std::uint8_t(s >> 8 * rank));
    for (std::size_t i = out.size(); i-- > std::size_t(t.samples);)
      out[i] = std::uint8_t(out[i] - out[i - std::size_t(t.samples)]);
    return out;
  }
  if (t.predictor == 2)
    for (std::size_t i = v.size(); i-- > std::size_t(t.samples);) v[i] -= v[i - std::size_t(t.samples)];
  for (const std::uint32_t s : v) put(out, s, size, t.big_end);
  return out;
}

Bytes tiff_bytes(const TinyTiff& t) {
  const int block_width = t.tiles ? 16 : t.width, block_height = t.tiles ? 16 : 4;
  std::vector<Bytes> blocks;
  for (int y0 = 0; y0 < t.height; y0 += block_height)
    for (int x0 = 0; x0 < t.width; x0 += block_width) {
      Bytes raw;
      for (int y = y0; y < (t.tiles ? y0 + block_height : std::min(t.height, y0 + block_height)); ++y) {
        const Bytes row = row_of(t, x0, y, block_width);
        raw.insert(raw.end(), row.begin(), row.end());
      }
      blocks.push_back(packed(t, raw));
    }
  const bool big = t.big_end;
  Bytes out = big ? Bytes{'M', 'M', 0, 42} : Bytes{'I', 'I', 42, 0};
  std::vector<std::uint32_t> offsets, sizes,
      bits(std::size_t(t.samples), std::uint32_t(8 * bytes_of(t.kind)));
  put(out, 0, 4, big);
  for (const Bytes& b : blocks) {
    offsets.push_back(std::uint32_t(out.size()));
    sizes.push_back(std::uint32_t(b.size()));
    out.insert(out.end(), b.begin(), b.end());
  }
  std::vector<std::pair<int, std::vector<std::uint32_t>>> tags = {{256, {std::uint32_t(t.width)}},
                                                                  {257, {std::uint32_t(t.height)}},
                                                                  {258, bits},
                                                                  {259, {std::uint32_t(t.compression)}},
                                                                  {262, {std::uint32_t(t.photometric)}}};
  if (!t.tiles) tags.push_back({273, offsets});
  tags.push_back({277, {std::uint32_t(t.samples)}});
  if (!t.tiles) {
    tags.push_back({278, {std::uint32_t(block_height)}});
    tags.push_back({279, sizes});
  }
  tags.push_back({317, {std::uint32_t(t.predictor)}});
  if (t.tiles)
    for (auto& tag :
         {std::pair{322, std::vector<std::uint32_t>{16}}, {323, {16}}, {324, offsets}, {325, sizes}})
      tags.push_back(tag);
  const int colours = t.photometric < 2 ? 1 : 3;
  if (t.samples > colours && t.extra >= 0) tags.push_back({338, {std::uint32_t(t.extra)}});
  tags.push_back(
      {339, std::vector<std::uint32_t>(bits.size(), t.kind == Kind::half || t.kind == Kind::real ? 3 : 1)});
  std::vector<std::uint32_t> places;
  for (const auto& [tag, list] : tags) {
    places.push_back(std::uint32_t(out.size()));
    if (list.size() > 1)
      for (const std::uint32_t v : list) put(out, v, 4, big);
  }
  const std::uint32_t first = std::uint32_t(out.size());
  for (int i = 0; i < 4; ++i) out[std::size_t(4 + i)] = std::uint8_t(first >> 8 * (big ? 3 - i : i));
  put(out, std::uint32_t(tags.size()), 2, big);
  for (std::size_t i = 0; i < tags.size(); ++i) {
    put(out, std::uint32_t(tags[i].first), 2, big);
    put(out, 4, 2, big);
    put(out, std::uint32_t(tags[i].second.size()), 4, big);
    put(out, tags[i].second.size() > 1 ? places[i] : tags[i].second[0], 4, big);
  }
  put(out, 0, 4, big);
  return out;
}

data::FilePixels read(const TempFolder& folder, const Bytes& bytes) {
  write_bytes(folder.path() / "a.tif", bytes);
  return data::read_tiff(folder.path() / "a.tif", "a.tif");
}

void check_pixels(const TinyTiff& t, const data::FilePixels& got) {
  const bool real = t.kind == Kind::half || t.kind == Kind::real;
  const bool grey = t.photometric < 2;
  const int alpha_at = grey ? 1 : 3;
  const bool alpha = t.samples > alpha_at && t.extra != 0;  // -1: no tag
  REQUIRE((real ? got.real.width : got.whole.width) == t.width);
  REQUIRE((real ? got.real.height : got.whole.height) == t.height);
  int wrong = 0;
  for (int y = 0; y < t.height; ++y)
    for (int x = 0; x < t.width; ++x)
      for (int c = 0; c < 4; ++c) {
        const float a = alpha ? value(x, y, alpha_at) : 1;
        float want = c == 3 ? a : value(x, y, grey ? 0 : c);
        if (c < 3 && t.photometric == 0) want = 1 - want;
        if (c < 3 && alpha && t.extra == 1) want = a > 0 ? want / a : 0;
        const float is = real ? got.real.pixel(x, y)[c] : float(got.whole.pixel(x, y)[c]) / 65535;
        const float step = t.kind == Kind::byte ? 0.002f : t.kind == Kind::real ? 1e-6f : 5e-4f;
        const float room = step * (c < 3 && alpha && t.extra == 1 ? (a > 0 ? 2 / (a * a) : 1) : 1);
        if (std::abs(is - (real ? want : std::min(want, 1.0f))) > room) ++wrong;
      }
  CHECK(wrong == 0);
}

TEST_SUITE("data/tiff") {
  TEST_CASE("every kind of number, order, packing, predictor and cut gives the same picture") {
    const TempFolder folder;
    for (const Kind kind : {Kind::byte, Kind::word, Kind::half, Kind::real})
      for (const int compression : {1, 5, 8, 32946, 32773})
        for (const bool big_end : {false, true})
          for (const bool tiles : {false, true})
            for (const bool predicted : {false, true}) {
              TinyTiff t{.compression = compression, .kind = kind, .big_end = big_end, .tiles = tiles};
              if (predicted) t.predictor = kind == Kind::half || kind == Kind::real ? 3 : 2;
              CAPTURE(int(kind));
              CAPTURE(compression);
              CAPTURE(big_end);
              CAPTURE(tiles);
              CAPTURE(predicted);
              check_pixels(t, read(folder, tiff_bytes(t)));
            }
    check_pixels({.width = 500, .height = 90, .compression = 5},
                 read(folder, tiff_bytes({.width = 500, .height = 90, .compression = 5})));
  }

  TEST_CASE("grey, white as zero, straight and premultiplied alpha, and channels that say nothing") {
    const TempFolder folder;
    for (const Kind kind : {Kind::byte, Kind::real})
      for (const int photometric : {0, 1, 2})
        for (const int extra : {-1, 0, 1, 2}) {
          const TinyTiff t{
              .samples = photometric < 2 ? 2 : 4, .extra = extra, .kind = kind, .photometric = photometric};
          CAPTURE(photometric);
          CAPTURE(extra);
          const Bytes bytes = tiff_bytes(t);
          const data::FilePixels pixels = read(folder, bytes);
          check_pixels(t, pixels);
          CHECK(pixels.premultiplied == (extra == 1));
          const data::PictureHeader header = data::tiff_header(folder.path() / "a.tif", "a.tif");
          CHECK(header.size == PictureSize{t.width, t.height});
          CHECK(header.alpha == (extra != 0));
          CHECK(header.real == (kind == Kind::real));
        }
  }

  TEST_CASE("what is not supported is refused by name") {
    const TempFolder folder;
    const auto refused = [&](const TinyTiff& t, const std::vector<std::string>& parts) {
      expect_error([&] { read(folder, tiff_bytes(t)); }, parts);
    };
    refused({.photometric = 6}, {"a.tif", "colours of this kind", "photometric 6"});
    refused({.compression = 7}, {"this packing is not supported", "compression 7"});
    refused({.predictor = 4}, {"this predictor is not supported"});
    Bytes big = tiff_bytes({});
    big[2] = 43;
    expect_error([&] { read(folder, big); }, {"a BigTIFF"});
    expect_error([&] { read(folder, {'I', 'I', 42, 0}); }, {"truncated or damaged"});
  }

  TEST_CASE("no end and no wrong byte does more than refuse") {
    const TempFolder folder;
    for (const int compression : {1, 5, 8, 32773}) {
      const Bytes good = tiff_bytes({.width = 9, .height = 5, .compression = compression});
      const auto refuses = [&](const Bytes& bytes) {
        try {
          read(folder, bytes);
        } catch (const Error& error) {
          CHECK(error.fault == Fault::input);
          return true;
        }
        return false;
      };
      constexpr std::size_t kUnread = 4;  // where a directory of another picture would be
      for (std::size_t n = 0; n + kUnread < good.size(); n += 3)
        CHECK(refuses(Bytes(good.begin(), good.begin() + std::ptrdiff_t(n))));
      int refused = 0;
      std::mt19937 random(unsigned(compression) + 1);
      for (int i = 0; i < 400; ++i) {
        Bytes bad = good;
        for (int k = 0; k < 3; ++k) bad[random() % bad.size()] = std::uint8_t(random());
        refused += refuses(bad);
      }
      CHECK(refused > 40);
      CHECK(refused < 400);
    }
  }
}

}  // namespace
