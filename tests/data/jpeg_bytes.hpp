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
};

/// A smooth picture: red grows to the right, green downwards; grey and CMYK likewise.
inline std::string jpeg_bytes(const JpegKind& kind = {}) {
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
  jpeg_start_compress(&info, TRUE);
  std::vector<unsigned char> row(std::size_t(kind.width) * std::size_t(kind.components));
  for (int y = 0; y < kind.height; ++y) {
    for (int x = 0; x < kind.width; ++x)
      for (int c = 0; c < kind.components; ++c)
        row[std::size_t(x * kind.components + c)] =
            static_cast<unsigned char>(c == 0   ? 255 * x / kind.width
                                       : c == 1 ? 255 * y / kind.height
                                                : 60);
    JSAMPROW rows = row.data();
    jpeg_write_scanlines(&info, &rows, 1);
  }
  jpeg_finish_compress(&info);
  jpeg_destroy_compress(&info);
  const std::string bytes(reinterpret_cast<char*>(memory), size);
  std::free(memory);
  return bytes;
}

}  // namespace splinevox::test
