// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <png.h>

#include <cstdint>
#include <span>
#include <string>

namespace splinevox::data {

/// libpng held at arm's length: its errors jump, so every call into it sits in a function without objects
/// to destroy, and comes back as false with error() saying why.
class PngDecoder {
 public:
  /// @param bytes  the whole file; must outlive the decoder.
  explicit PngDecoder(std::span<const std::uint8_t> bytes);
  ~PngDecoder();
  PngDecoder(const PngDecoder&) = delete;
  PngDecoder& operator=(const PngDecoder&) = delete;

  /// Reads everything before the pixels and asks for straight RGBA of 16 bits in this machine's byte order.
  /// False too if the size is not width x height.
  bool begin(int width, int height);
  /// Reads all pixels and checks the end of the file. @param rows  height pointers to width * 8 bytes.
  bool read(std::uint8_t** rows);
  std::string error() const { return message_; }

 private:
  static void on_error(png_structp png, png_const_charp text);
  static void on_warning(png_structp, png_const_charp) {}
  static void on_read(png_structp png, png_bytep out, png_size_t count);
  void ask_for_rgba16();

  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 0;
  char message_[128] = "";
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
};

}  // namespace splinevox::data
