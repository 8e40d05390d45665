// SPDX-License-Identifier: Apache-2.0
#include "data/pictures/jpeg_decoder.hpp"

#include <jerror.h>

namespace splinevox::data {
namespace {

constexpr int kMostScans =
    100;  ///< a progressive file may ask for the whole picture to be gone through any number of times

JpegDecoder* self_of(j_common_ptr info) { return static_cast<JpegDecoder*>(info->client_data); }

}  // namespace

JpegDecoder::JpegDecoder(std::span<const std::uint8_t> bytes) : bytes_(bytes) {
  info_.err = jpeg_std_error(&errors_);
  errors_.error_exit = on_error;
  errors_.emit_message = on_message;
  info_.client_data = this;
  jpeg_create_decompress(&info_);
  info_.client_data = this;
  progress_.progress_monitor = on_progress;
  info_.progress = &progress_;
}

JpegDecoder::~JpegDecoder() { jpeg_destroy_decompress(&info_); }

bool JpegDecoder::begin() {
  if (setjmp(jump_) != 0) return false;
  jpeg_mem_src(&info_, bytes_.data(), static_cast<unsigned long>(bytes_.size()));
  jpeg_save_markers(&info_, JPEG_APP0 + 1, 0xffff);
  jpeg_read_header(&info_, TRUE);
  return true;
}

std::span<const std::uint8_t> JpegDecoder::app1() const {
  for (const jpeg_marker_struct* m = info_.marker_list; m != nullptr; m = m->next)
    if (m->marker == JPEG_APP0 + 1 && m->data_length > 4 && m->data[0] == 'E')
      return {m->data, m->data_length};
  return {};
}

bool JpegDecoder::read(std::uint8_t* rgb) {
  if (setjmp(jump_) != 0) return false;
  info_.out_color_space = JCS_RGB;
  info_.dct_method = JDCT_ISLOW;
  jpeg_start_decompress(&info_);
  while (info_.output_scanline < info_.output_height) {
    JSAMPROW row = rgb + std::size_t(info_.output_scanline) * info_.output_width * 3;
    jpeg_read_scanlines(&info_, &row, 1);
  }
  jpeg_finish_decompress(&info_);
  return true;
}

void JpegDecoder::on_error(j_common_ptr info) {
  JpegDecoder* self = self_of(info);
  (*info->err->format_message)(info, self->message_);
  std::longjmp(self->jump_, 1);
}

/// Bytes between markers and odd Adobe markers harm nothing; whatever else is warned of costs pixels.
void JpegDecoder::on_message(j_common_ptr info, int level) {
  if (level >= 0 || info->err->msg_code == JWRN_EXTRANEOUS_DATA || info->err->msg_code == JWRN_ADOBE_XFORM ||
      info->err->msg_code == JWRN_JFIF_MAJOR)
    return;
  on_error(info);
}

void JpegDecoder::on_progress(j_common_ptr info) {
  if (reinterpret_cast<j_decompress_ptr>(info)->input_scan_number <= kMostScans) return;
  JpegDecoder* self = self_of(info);
  std::snprintf(self->message_, sizeof self->message_, "more than %d scans", kMostScans);
  std::longjmp(self->jump_, 1);
}

}  // namespace splinevox::data
