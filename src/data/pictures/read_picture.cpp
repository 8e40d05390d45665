// SPDX-License-Identifier: Apache-2.0
#include "data/pictures/read_picture.hpp"

#include <string_view>
#include <utility>
#include <vector>

#include "data/file_bytes.hpp"
#include "data/pictures/real_read.hpp"
#include "splinevox/data/image_io.hpp"

namespace splinevox {
namespace data {
namespace {

enum class Format { png, jpeg, exr, tiff };

/// By the first bytes, whatever the file is called. What is none of them is told by the reader of PNG.
Format format_of(const std::filesystem::path& path, const std::string& where) {
  const std::vector<std::uint8_t> start = read_bytes(path, where, kLargestFile, 4);
  using namespace std::string_view_literals;
  if (begins_with(start, kJpegMark)) return Format::jpeg;
  if (begins_with(start, kExrMark)) return Format::exr;
  for (const std::string_view tiff : {"II*\0"sv, "MM\0*"sv, "II+\0"sv, "MM\0+"sv})
    if (begins_with(start, tiff)) return Format::tiff;
  return Format::png;
}

}  // namespace

PictureHeader read_picture_header(const std::filesystem::path& path, const std::string& where,
                                  const std::string& layer) {
  const std::string name = where.empty() ? path.string() : where;
  switch (format_of(path, name)) {
    case Format::jpeg:
      return jpeg_header(path, name);
    case Format::exr:
      return exr_picture_header(path, name, layer);
    case Format::tiff:
      return tiff_header(path, name);
    case Format::png:
      break;
  }
  const PngHeader header = read_png_header(path, name);
  return {.size = {header.width, header.height}, .alpha = header.alpha, .deep = header.bits > 8};
}

FilePixels read_pixels(const std::filesystem::path& path, const std::string& where,
                       const std::string& layer) {
  switch (format_of(path, where)) {
    case Format::jpeg:
      return {read_jpeg(path, where), {}};
    case Format::exr:
      return {{}, read_exr_picture(path, where, layer), true};
    case Format::tiff:
      return read_tiff(path, where);
    case Format::png:
      break;
  }
  return {read_png(path, where), {}};
}

}  // namespace data

Image16 read_picture(const std::filesystem::path& path, const std::string& where) {
  data::FilePixels pixels = data::read_pixels(path, where.empty() ? path.string() : where, "");
  return pixels.real.data.empty() ? std::move(pixels.whole) : Picture(pixels.real).unpacked();
}

PictureSize read_picture_size(const std::filesystem::path& path, const std::string& where) {
  return data::read_picture_header(path, where).size;
}

}  // namespace splinevox
