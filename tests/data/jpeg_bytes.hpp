// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <jpeglib.h>

#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string>
#include <vector>

namespace splinevox::test {

/// How a JPEG for a test is made.
struct JpegKind {
  int width = 16, height = 8, components = 3, quality = 95;
  bool progressive = false;
  bool whole_colours = false;            ///< a colour for every pixel, not for every four
  std::vector<unsigned char> app1 = {};  ///< what stands in its EXIF marker; empty: there is none
};

/// An EXIF marker that says how the picture is to be turned, 1 to 8.
inline std::vector<unsigned char> exif_turn(int orientation) {
  return {'E', 'x', 'i', 'f',  0,    0, 'M', 'M', 0, 42, 0, 0, 0,
          8,   0,   1,   0x01, 0x12, 0, 3,   0,   0, 0,  1, 0, static_cast<unsigned char>(orientation),
          0,   0,   0,   0,    0,    0};
}

/// @param rows  width * height * components bytes
inline std::string jpeg_bytes(const JpegKind& kind, const std::vector<unsigned char>& rows) {
  jpeg_compress_struct info;
  jpeg_error_mgr errors;
  info.err = jpeg_std_error(&errors);
  jpeg_create_compress(&info);
  unsigned char* memory = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&info, &memory, &size);
  info.image_width = JDIMENSION(kind.width);
  info.image_height = JDIMENSION(kind.height);
  info.input_components = kind.components;
  info.in_color_space = kind.components == 1 ? JCS_GRAYSCALE : kind.components == 3 ? JCS_RGB : JCS_CMYK;
  jpeg_set_defaults(&info);
  jpeg_set_quality(&info, kind.quality, TRUE);
  if (kind.progressive) jpeg_simple_progression(&info);
  if (kind.whole_colours) info.comp_info[0].h_samp_factor = info.comp_info[0].v_samp_factor = 1;
  jpeg_start_compress(&info, TRUE);
  if (!kind.app1.empty())
    jpeg_write_marker(&info, JPEG_APP0 + 1, kind.app1.data(), static_cast<unsigned int>(kind.app1.size()));
  const std::size_t stride = std::size_t(kind.width) * std::size_t(kind.components);
  for (std::size_t y = 0; y < std::size_t(kind.height); ++y) {
    JSAMPROW row = const_cast<JSAMPROW>(rows.data() + y * stride);  // libjpeg does not write to it
    jpeg_write_scanlines(&info, &row, 1);
  }
  jpeg_finish_compress(&info);
  jpeg_destroy_compress(&info);
  const std::string bytes(reinterpret_cast<char*>(memory), size);
  std::free(memory);
  return bytes;
}

/// A smooth picture: red grows to the right, green downwards; grey and CMYK likewise.
inline std::string jpeg_bytes(const JpegKind& kind = {}) {
  std::vector<unsigned char> rows;
  for (int y = 0; y < kind.height; ++y)
    for (int x = 0; x < kind.width; ++x)
      for (int c = 0; c < kind.components; ++c)
        rows.push_back(static_cast<unsigned char>(c == 0   ? 255 * x / kind.width
                                                  : c == 1 ? 255 * y / kind.height
                                                           : 60));
  return jpeg_bytes(kind, rows);
}

}  // namespace splinevox::test
