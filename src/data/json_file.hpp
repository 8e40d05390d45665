// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

namespace splinevox::data {

/// Reads a JSON file strictly: no comments, no NaN, no number beyond double, nesting of at most 64, no key
/// twice in one object (the parser alone would silently keep the last). At most 64 MiB.
/// @param where  how an error names the file.
/// Throws Error (Fault::input) with line, column and the field that was being read.
nlohmann::json read_json(const std::filesystem::path& path, const std::string& where);
/// The same with fields in the file's order, for files of this program: at most 4096 fields in an object,
/// since looking for one takes time in proportion to their number.
nlohmann::ordered_json read_ordered_json(const std::filesystem::path& path, const std::string& where);

/// One line of a file of such lines, as strictly; nothing if it is no JSON, as a line that was torn is none.
std::optional<nlohmann::ordered_json> read_json_line(std::string_view line, const std::string& where);

}  // namespace splinevox::data
