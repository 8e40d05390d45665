// SPDX-License-Identifier: Apache-2.0
#include <png.h>

#include <bit>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include "data/pictures/encode.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox {
namespace {

/// libpng's full interface, because the simple one takes 16 bits for premultiplied. Its errors jump, so every
/// call sits in a function without objects to destroy; and nothing may be thrown through it, so the file has
/// its room from the start.
class Png16Encoder {
 public:
  /// @param most  bytes that the file can have
  explicit Png16Encoder(std::size_t most) : file_(most) {
    png_ = png_create_write_struct(PNG_LIBPNG_VER_STRING, this, on_error, on_warning);
    if (png_ != nullptr) info_ = png_create_info_struct(png_);
    if (info_ == nullptr) {
      png_destroy_write_struct(&png_, nullptr);
      throw std::bad_alloc();
    }
  }
  ~Png16Encoder() { png_destroy_write_struct(&png_, &info_); }
  Png16Encoder(const Png16Encoder&) = delete;
  Png16Encoder& operator=(const Png16Encoder&) = delete;

  /// @param rows  height pointers to width * 8 bytes of RGBA, in this machine's order; alpha may be left out
  bool write(int width, int height, bool alpha, std::uint8_t** rows) {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    png_set_write_fn(png_, this, on_write, on_flush);
    png_set_IHDR(png_, info_, png_uint_32(width), png_uint_32(height), 16,
                 alpha ? PNG_COLOR_TYPE_RGB_ALPHA : PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_write_info(png_, info_);
    if (!alpha) png_set_filler(png_, 0, PNG_FILLER_AFTER);
    if (std::endian::native == std::endian::little) png_set_swap(png_);
    png_write_image(png_, rows);
    png_write_end(png_, nullptr);
    return true;
  }
  std::vector<char> file() && {
    file_.resize(size_);
    return std::move(file_);
  }
  std::string error() const { return message_; }

 private:
  static void on_error(png_structp png, png_const_charp text) {
    auto* self = static_cast<Png16Encoder*>(png_get_error_ptr(png));
    std::snprintf(self->message_, sizeof self->message_, "%s", text);
    png_longjmp(png, 1);
  }
  static void on_warning(png_structp, png_const_charp) {}
  static void on_write(png_structp png, png_bytep bytes, png_size_t count) {
    auto* self = static_cast<Png16Encoder*>(png_get_io_ptr(png));
    if (count > self->file_.size() - self->size_) png_error(png, "the file is larger than it can be");
    std::memcpy(self->file_.data() + self->size_, bytes, count);
    self->size_ += count;
  }
  static void on_flush(png_structp) {}

  std::vector<char> file_;
  std::size_t size_ = 0;
  char message_[128] = "";
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
};

}  // namespace

std::vector<char> encode_png16(const Image16& picture, bool alpha) {
  png_image size{};
  size.width = png_uint_32(picture.width);
  size.height = png_uint_32(picture.height);
  size.format = PNG_FORMAT_LINEAR_RGB_ALPHA;
  Png16Encoder encoder(PNG_IMAGE_PNG_SIZE_MAX(size));
  std::vector<std::uint8_t*> rows;
  for (int y = 0; y < picture.height; ++y)  // libpng does not write to them
    rows.push_back(const_cast<std::uint8_t*>(reinterpret_cast<const std::uint8_t*>(picture.pixel(0, y))));
  if (!encoder.write(picture.width, picture.height, alpha, rows.data()))
    fail_output({.where = "PNG picture",
                 .what = "PNG compression failed",
                 .expected = {},
                 .got = encoder.error(),
                 .hint = {}});
  return std::move(encoder).file();
}

}  // namespace splinevox
