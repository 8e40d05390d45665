// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace splinevox::data {

/// A table of numbers as numpy.save writes it.
struct NpyTable {
  std::size_t rows = 0, columns = 0;
  std::vector<double> values;  ///< [rows * columns]
  double at(std::size_t row, std::size_t column) const { return values[row * columns + column]; }
};

/// Reads a .npy file of two axes of little-endian 32- or 64-bit floats in C order. Throws Error
/// (Fault::input) for anything else, for a file that is shorter or longer than its header says, and for a
/// number that is not finite.
NpyTable read_npy(const std::filesystem::path& path, const std::string& where);

}  // namespace splinevox::data
