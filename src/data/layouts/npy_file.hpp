// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace splinevox::data {

/// Numbers as numpy.save writes them.
struct NpyArray {
  std::vector<std::size_t> shape;  ///< of the axes; none: one number
  std::vector<double> values;      ///< the last axis fastest
};

/// The bytes of a .npy file of little-endian floats (16, 32 or 64 bits) or signed integers (32 or 64), bytes
/// and truths in C order, at most 8 axes. Throws Error (Fault::input) for anything else, for a file that is
/// shorter or longer than its header says, and for a number that is not finite, unless `any` will do.
NpyArray parse_npy(std::span<const std::uint8_t> bytes, const std::string& where, bool any = false);

/// "(2, 3)".
std::string axes_text(const std::vector<std::size_t>& shape);
/// Axes of length 1 before the last `axes` are left out: a batch of one.
std::vector<std::size_t> without_batch(std::vector<std::size_t> shape, std::size_t axes);

/// The bytes of a .npy file of 32-bit floats. @pre as many values as the shape has
std::string npy_bytes(const std::vector<std::size_t>& shape, std::span<const float> values);

/// A table of numbers as numpy.save writes it.
struct NpyTable {
  std::size_t rows = 0, columns = 0;
  std::vector<double> values;  ///< [rows * columns]
  double at(std::size_t row, std::size_t column) const { return values[row * columns + column]; }
};

/// Reads a .npy file of two axes. Throws Error (Fault::input) for anything else, and as parse_npy.
NpyTable read_npy(const std::filesystem::path& path, const std::string& where);

}  // namespace splinevox::data
