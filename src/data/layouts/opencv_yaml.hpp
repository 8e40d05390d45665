// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace splinevox::data {

/// A value of a file that OpenCV's FileStorage writes: a text, a list of texts, or a matrix.
struct StorageValue {
  enum class Kind { text, list, matrix };
  Kind kind = Kind::text;
  int line = 0;                    ///< at which it begins, from 1
  std::vector<std::string> texts;  ///< one for a text; without quotes
  int rows = 0, columns = 0;       ///< of a matrix
  std::vector<double> numbers;     ///< of a matrix, row by row; may be not finite
};

/// The values of a file by their keys. Read are: `key: value`, `key: [a, b]`, lists of lines `- a`, and
/// `key: !!opencv-matrix` with rows, cols, dt and data. Anything else of YAML is refused: tags, anchors,
/// aliases, maps in maps, texts of several lines. At most 16 MiB.
///
/// Throws Error (Fault::input) with the line. @param where  how messages name the file
std::map<std::string, StorageValue> read_opencv_yaml(const std::filesystem::path& path,
                                                     const std::string& where);

/// The number that a text is; not a number (NaN) for a text that is none.
double storage_number(const std::string& text);

}  // namespace splinevox::data
