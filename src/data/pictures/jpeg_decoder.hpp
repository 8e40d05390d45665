// SPDX-License-Identifier: Apache-2.0
#pragma once

// clang-format off
#include <cstdio>  // jpeglib.h needs FILE
#include <jpeglib.h>
// clang-format on

#include <csetjmp>
#include <cstdint>
#include <span>
#include <string>

namespace splinevox::data {

/// libjpeg held at arm's length, as PngDecoder holds libpng. What libjpeg only warns of and fills with grey,
/// a file that ends early or is damaged, is an error here.
class JpegDecoder {
 public:
  /// @param bytes  the file, or its beginning for begin() alone; must outlive the decoder.
  explicit JpegDecoder(std::span<const std::uint8_t> bytes);
  ~JpegDecoder();
  JpegDecoder(const JpegDecoder&) = delete;
  JpegDecoder& operator=(const JpegDecoder&) = delete;

  /// Reads everything before the pixels. False if it cannot.
  bool begin();
  /// The EXIF block, after begin(); empty if there is none.
  std::span<const std::uint8_t> app1() const;
  /// Reads all pixels as 8-bit RGB. @param rgb  width * height * 3 bytes.
  bool read(std::uint8_t* rgb);
  int width() const { return int(info_.image_width); }
  int height() const { return int(info_.image_height); }
  /// Grey or YCbCr or RGB: what read() can turn into RGB.
  bool colours_known() const {
    return info_.jpeg_color_space == JCS_GRAYSCALE || info_.jpeg_color_space == JCS_YCbCr ||
           info_.jpeg_color_space == JCS_RGB;
  }
  std::string error() const { return message_; }

 private:
  static void on_error(j_common_ptr info);
  static void on_message(j_common_ptr info, int level);
  static void on_progress(j_common_ptr info);

  std::span<const std::uint8_t> bytes_;
  jpeg_decompress_struct info_{};
  jpeg_error_mgr errors_{};
  jpeg_progress_mgr progress_{};
  std::jmp_buf jump_;
  char message_[JMSG_LENGTH_MAX] = "";
};

}  // namespace splinevox::data
