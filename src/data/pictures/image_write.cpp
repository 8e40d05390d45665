// SPDX-License-Identifier: Apache-2.0
#include <string_view>

#include "core/atomic_file.hpp"
#include "data/pictures/encode.hpp"
#include "splinevox/data/image_io.hpp"

namespace splinevox {
namespace {

void write(const std::string& path, const std::vector<char>& bytes) {
  write_file(path, {std::string_view(bytes.data(), bytes.size())});
}

}  // namespace

std::vector<char> encode_png(const Image& image) { return encode_png_for("PNG picture", image); }

void write_png(const std::string& path, const Image& image) { write(path, encode_png_for(path, image)); }

void write_exr(const std::string& path, const std::vector<ExrLayer>& layers, const ExrNotes& notes) {
  write(path, encode_exr_for(path, layers, notes));
}

}  // namespace splinevox
