// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace splinevox::data {

/// How a TIFF packs its strips.
enum class TiffPacking { plain = 1, lzw = 5, deflate = 8, old_deflate = 32946, packbits = 32773 };

/// Unpacks a strip. @param out  as large as it is unpacked
/// @return false if it is damaged, or holds less
bool tiff_unpack(TiffPacking packing, std::span<const std::uint8_t> packed, std::span<std::uint8_t> out);

}  // namespace splinevox::data
