// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <fstream>
#include <span>
#include <string_view>
#include <vector>

#include "data/file_bytes.hpp"
#include "data/pictures/png_decoder.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/data/image_io.hpp"

namespace splinevox {
namespace {

using Bytes = std::span<const std::uint8_t>;
constexpr std::uint64_t kLongestSide = 1u << 16;
constexpr std::uint64_t kDeflateBound = 1100;  ///< raw bytes per file byte; 1032 is possible
constexpr std::size_t kPngHeaderBytes = 33;    ///< signature and IHDR

constexpr std::string_view kStart("\x89PNG\r\n\x1a\n\0\0\0\rIHDR", 16);

/// What a file that is no PNG seems to be, and what to do with it.
struct Guess {
  std::string format, hint = "convert it to PNG";
};
Guess guess_format(Bytes bytes) {
  if (bytes.empty()) return {"an empty file", "copy the file again"};
  if (data::begins_with(bytes, data::kJpegMark)) return {"a JPEG"};
  return {"something else (" + std::to_string(bytes.size()) + " bytes looked at)"};
}

std::uint32_t be32(Bytes bytes, std::size_t at) {
  return (std::uint32_t(bytes[at]) << 24) | (std::uint32_t(bytes[at + 1]) << 16) |
         (std::uint32_t(bytes[at + 2]) << 8) | bytes[at + 3];
}

/// Samples per pixel of a PNG colour type; 0 if there is no such type with this many bits.
int samples_of(int colour_type, int bits) {
  const bool deep = bits == 8 || bits == 16, shallow = bits == 1 || bits == 2 || bits == 4;
  if (colour_type == 0 && (deep || shallow)) return 1;
  if (colour_type == 3 && (bits == 8 || shallow)) return 1;
  if (!deep) return 0;
  return colour_type == 2 ? 3 : colour_type == 4 ? 2 : colour_type == 6 ? 4 : 0;
}

PngHeader check_png(Bytes head, std::uintmax_t file_size, const std::string& where) {
  if (!data::begins_with(head, kStart.substr(0, 8))) {
    const Guess guess = guess_format(head);
    fail({where, "the image is not a PNG", "a PNG file", guess.format, guess.hint});
  }
  if (head.size() < kPngHeaderBytes)
    fail({where, "the image is truncated", "a whole PNG", std::to_string(file_size) + " bytes",
          "copy the file again"});
  if (!data::begins_with(head, kStart))
    fail({where, "the image is damaged", "a PNG that begins with its header", "another chunk",
          "copy the file again"});
  const std::uint64_t width = be32(head, 16), height = be32(head, 20);
  const std::string size = std::to_string(width) + " x " + std::to_string(height);
  if (width < 1 || height < 1 || width > kLongestSide || height > kLongestSide ||
      width * height > data::kMostPixels)
    fail({where, "the image's size is out of range", "1 to 65536 pixels a side and at most 2^28 in all", size,
          ""});
  const int bits = head[24], samples = samples_of(head[25], bits);
  if (samples == 0)
    fail({where, "the image is damaged", "a PNG colour type and bit depth that go together",
          "type " + std::to_string(head[25]) + " with " + std::to_string(bits) + " bits",
          "copy the file again"});
  const std::uint64_t raw = (1 + (width * std::uint64_t(bits * samples) + 7) / 8) * height;
  if (raw / kDeflateBound > file_size)
    fail({where, "the image claims more pixels than its file can hold",
          "a PNG of " + size + " pixels in full", std::to_string(file_size) + " bytes",
          "copy the file again"});
  return {int(width), int(height), bits, samples, samples % 2 == 0};
}

/// Whether a tRNS chunk stands before the pixels: it makes a colour, or colours of the palette, transparent.
bool has_transparency(const std::filesystem::path& path) {
  constexpr int kMostChunks = 1000;  // files have a few; one that is made to keep us busy has any number
  std::ifstream in(path, std::ios::binary);
  std::uint64_t at = kPngHeaderBytes;
  for (int i = 0; i < kMostChunks; ++i) {
    std::array<std::uint8_t, 8> chunk{};  // the length of its content, and its name
    in.seekg(std::streamoff(at));
    if (!in.read(reinterpret_cast<char*>(chunk.data()), std::streamsize(chunk.size()))) return false;
    const Bytes name = Bytes(chunk).subspan(4);
    if (data::begins_with(name, "tRNS")) return true;
    if (data::begins_with(name, "IDAT")) return false;
    at += be32(chunk, 0) + std::uint64_t(12);  // a checksum ends it
  }
  return false;
}

}  // namespace

PngHeader read_png_header(const std::filesystem::path& path, const std::string& where) {
  const std::string name = where.empty() ? path.string() : where;
  const std::uintmax_t size = data::file_size_of(path, name);
  PngHeader header = check_png(data::read_bytes(path, name, data::kLargestFile, kPngHeaderBytes), size, name);
  header.alpha = header.alpha || has_transparency(path);
  return header;
}

Image16 read_png(const std::filesystem::path& path, const std::string& where) {
  const std::string name = where.empty() ? path.string() : where;
  const std::vector<std::uint8_t> bytes = data::read_bytes(path, name, data::kLargestFile);
  const PngHeader header = check_png(bytes, bytes.size(), name);
  data::PngDecoder decoder(bytes);
  Image16 image{header.width, header.height, {}};
  bool good = decoder.begin(image.width, image.height);
  if (good) {
    image.rgba.resize(std::size_t(image.width) * image.height * 4);
    std::vector<std::uint8_t*> rows;
    for (int y = 0; y < image.height; ++y)
      rows.push_back(reinterpret_cast<std::uint8_t*>(image.rgba.data() + std::size_t(y) * image.width * 4));
    good = decoder.read(rows.data());
  }
  if (!good)
    fail({name, "the image is truncated or damaged", "a whole PNG", decoder.error(),
          "copy or render the file again"});
  return image;
}

}  // namespace splinevox
