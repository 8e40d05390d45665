// SPDX-License-Identifier: Apache-2.0
#include "data/layouts/npy_file.hpp"

#include <charconv>
#include <cmath>
#include <cstring>
#include <string_view>

#include "data/file_bytes.hpp"
#include "data/message_text.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::data {
namespace {

/// What stands behind 'key': in the header, a Python dictionary written as text.
std::string_view field(std::string_view header, std::string_view key, const std::string& where) {
  const std::size_t at = header.find(key);
  if (at == std::string_view::npos)
    fail({where, "the header has no " + std::string(key), "a .npy file as numpy.save writes it",
          in_quotes(header), ""});
  std::string_view rest = header.substr(at + key.size());
  while (!rest.empty() && (rest[0] == ':' || rest[0] == ' ')) rest.remove_prefix(1);
  return rest;
}

/// "(20, 17)" as two numbers.
void read_shape(std::string_view text, NpyTable& table, const std::string& where) {
  const std::string_view all =
      text.substr(0, text.find(')') == std::string_view::npos ? text.size() : text.find(')') + 1);
  const auto number_at = [&](std::size_t& value) {
    while (!text.empty() && (text[0] == '(' || text[0] == ' ' || text[0] == ',')) text.remove_prefix(1);
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    text.remove_prefix(std::size_t(end - text.data()));
    return error == std::errc() && value >= 1 && value <= (std::size_t(1) << 32);
  };
  const bool good = number_at(table.rows) && number_at(table.columns);
  while (!text.empty() && (text[0] == ' ' || text[0] == ',')) text.remove_prefix(1);
  if (!good || text.empty() || text[0] != ')')
    fail({where, "the table has not two axes", "(rows, columns), each at least 1",
          std::string(all.substr(0, 60)), ""});
}

}  // namespace

NpyTable read_npy(const std::filesystem::path& path, const std::string& where) {
  const std::vector<std::uint8_t> bytes = read_bytes(path, where, std::uintmax_t(1) << 30);
  if (bytes.size() < 12 || std::memcmp(bytes.data(), "\x93NUMPY", 6) != 0)
    fail({where, "this is no .npy file", "a table that numpy.save wrote",
          std::to_string(bytes.size()) + " bytes that begin otherwise", ""});
  const std::size_t wide = bytes[6] == 1 ? 2 : 4;
  std::size_t length = 0;
  for (std::size_t i = 0; i < wide; ++i) length |= std::size_t(bytes[8 + i]) << (8 * i);
  const std::size_t start = 8 + wide + length;
  if (bytes[6] < 1 || bytes[6] > 3 || start > bytes.size())
    fail({where, "the header is damaged", "version 1 to 3 and a header within the file",
          "version " + std::to_string(bytes[6]), "copy the file again"});
  const std::string_view header(reinterpret_cast<const char*>(bytes.data()) + 8 + wide, length);
  const std::string_view kind = field(header, "'descr'", where).substr(0, 5);
  const std::size_t size = kind == "'<f8'" ? 8 : kind == "'<f4'" ? 4 : 0;
  if (size == 0)
    fail({where, "the numbers are of a kind that is not read", "'<f8' or '<f4', little-endian floats",
          in_quotes(kind), ""});
  if (field(header, "'fortran_order'", where).substr(0, 5) != "False")
    fail({where, "the table is stored by columns", "fortran_order False", "True",
          "numpy.save(path, numpy.ascontiguousarray(table))"});
  NpyTable table;
  read_shape(field(header, "'shape'", where), table, where);
  const double expected = double(table.rows) * double(table.columns) * double(size);
  if (expected != double(bytes.size() - start))
    fail({where, "the file has not the size that its header says", number(expected) + " bytes of numbers",
          std::to_string(bytes.size() - start), "copy the file again"});
  table.values.resize(table.rows * table.columns);
  for (std::size_t i = 0; i < table.values.size(); ++i) {
    float single = 0;
    if (size == 8) std::memcpy(&table.values[i], bytes.data() + start + 8 * i, 8);
    if (size == 4) {
      std::memcpy(&single, bytes.data() + start + 4 * i, 4);
      table.values[i] = single;
    }
    if (!std::isfinite(table.values[i]))
      fail({where, "a number is not finite", "finite numbers",
            number(table.values[i]) + " in row " + std::to_string(i / table.columns), ""});
  }
  return table;
}

}  // namespace splinevox::data
