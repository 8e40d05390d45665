// SPDX-License-Identifier: Apache-2.0
#include "data/pictures/png_decoder.hpp"

#include <bit>
#include <cstdio>
#include <cstring>
#include <new>

namespace splinevox::data {
namespace {

/// Chunks that have nothing to do with pixels here, some of which the library would inflate: a few bytes can
/// be a thousand times as many.
constexpr png_byte kUnused[] = "zTXt\0iTXt\0tEXt\0iCCP\0sPLT\0eXIf\0hIST\0pCAL\0sCAL\0tIME";
constexpr std::size_t kNameBytes = 5;

}  // namespace

PngDecoder::PngDecoder(std::span<const std::uint8_t> bytes) : bytes_(bytes) {
  png_ = png_create_read_struct(PNG_LIBPNG_VER_STRING, this, on_error, on_warning);
  if (png_ != nullptr) info_ = png_create_info_struct(png_);
  if (info_ == nullptr) {
    png_destroy_read_struct(&png_, nullptr, nullptr);
    throw std::bad_alloc();
  }
}

PngDecoder::~PngDecoder() { png_destroy_read_struct(&png_, &info_, nullptr); }

bool PngDecoder::begin(int width, int height) {
  if (setjmp(png_jmpbuf(png_)) != 0) return false;
  png_set_read_fn(png_, this, on_read);
  png_set_user_limits(png_, png_uint_32(width), png_uint_32(height));
  png_set_chunk_malloc_max(png_, 8u << 20);
  png_set_keep_unknown_chunks(png_, PNG_HANDLE_CHUNK_NEVER, kUnused, int(sizeof kUnused / kNameBytes));
  png_read_info(png_, info_);
  ask_for_rgba16();
  png_read_update_info(png_, info_);
  if (png_get_rowbytes(png_, info_) != std::size_t(width) * 8 ||
      png_get_image_height(png_, info_) != png_uint_32(height))
    png_error(png_, "the size changed while reading");
  return true;
}

/// Palette to RGB, grey to RGB, tRNS to alpha, 8 bit to 16 as 257 v, opaque where there is no alpha.
void PngDecoder::ask_for_rgba16() {
  png_set_expand_16(png_);
  png_set_gray_to_rgb(png_);
  png_set_add_alpha(png_, 0xffff, PNG_FILLER_AFTER);
  if (std::endian::native == std::endian::little) png_set_swap(png_);
  png_set_interlace_handling(png_);
}

bool PngDecoder::read(std::uint8_t** rows) {
  if (setjmp(png_jmpbuf(png_)) != 0) return false;
  png_read_image(png_, rows);
  png_read_end(png_, nullptr);
  return true;
}

void PngDecoder::on_error(png_structp png, png_const_charp text) {
  auto* self = static_cast<PngDecoder*>(png_get_error_ptr(png));
  std::snprintf(self->message_, sizeof self->message_, "%s", text);
  png_longjmp(png, 1);
}

void PngDecoder::on_read(png_structp png, png_bytep out, png_size_t count) {
  auto* self = static_cast<PngDecoder*>(png_get_io_ptr(png));
  if (count > self->bytes_.size() - self->at_) png_error(png, "the file ends too early");
  std::memcpy(out, self->bytes_.data() + self->at_, count);
  self->at_ += count;
}

}  // namespace splinevox::data
