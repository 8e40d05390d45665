// SPDX-License-Identifier: Apache-2.0
#include "data/layouts/npy_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <iterator>
#include <string_view>
#include <utility>

#include "core/half.hpp"
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

/// "(20, 17)", "(3,)" or "()". Every axis has at least one number.
std::vector<std::size_t> read_shape(std::string_view text, const std::string& where) {
  constexpr std::size_t kMostAxes = 8, kLongest = std::size_t(1) << 32;
  const std::string_view all =
      text.substr(0, text.find(')') == std::string_view::npos ? text.size() : text.find(')') + 1);
  const auto skip = [&] {
    while (!text.empty() && (text[0] == '(' || text[0] == ' ' || text[0] == ',')) text.remove_prefix(1);
  };
  std::vector<std::size_t> shape;
  for (skip(); !text.empty() && text[0] != ')'; skip()) {
    std::size_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    text.remove_prefix(std::size_t(end - text.data()));
    if (error != std::errc() || value < 1 || value > kLongest || shape.size() == kMostAxes) {
      text = {};
      break;
    }
    shape.push_back(value);
  }
  if (text.empty())
    fail({where, "the header's shape is not understood", "as in (20, 17), each axis at least 1",
          std::string(all.substr(0, 60)), ""});
  return shape;
}

/// A kind of numbers: its name in the header, bytes of one, and how one is read.
struct NumberKind {
  std::string_view name;
  std::size_t size;
  double (*read)(const std::uint8_t* from);
};

template <class T>
double read_as(const std::uint8_t* from) {
  T value{};
  std::memcpy(&value, from, sizeof(T));
  return double(value);
}

double read_half(const std::uint8_t* from) { return from_half(std::uint16_t(from[0] | from[1] << 8)); }

constexpr NumberKind kNumberKinds[] = {{"'<f8'", 8, read_as<double>},
                                       {"'<f4'", 4, read_as<float>},
                                       {"'<f2'", 2, read_half},
                                       {"'<i8'", 8, read_as<std::int64_t>},
                                       {"'<i4'", 4, read_as<std::int32_t>},
                                       {"'|u1'", 1, read_as<std::uint8_t>},
                                       {"'|b1'", 1, read_as<std::uint8_t>}};

}  // namespace

NpyArray parse_npy(std::span<const std::uint8_t> bytes, const std::string& where, bool any) {
  if (bytes.size() < 12 || !begins_with(bytes, kNpyMark))
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
  const std::string_view name = field(header, "'descr'", where).substr(0, 5);
  const auto kind = std::find_if(std::begin(kNumberKinds), std::end(kNumberKinds),
                                 [&](const NumberKind& k) { return k.name == name; });
  if (kind == std::end(kNumberKinds))
    fail({where, "the numbers are of a kind that is not read",
          "'<f8' or '<f4', little-endian floats; also '<f2', '<i8', '<i4', '|u1' and '|b1'", in_quotes(name),
          ""});
  NpyArray out;
  out.shape = read_shape(field(header, "'shape'", where), where);
  // The order of the axes says nothing where only one is longer than 1.
  const bool one_way =
      std::count_if(out.shape.begin(), out.shape.end(), [](std::size_t n) { return n > 1; }) < 2;
  if (!one_way && field(header, "'fortran_order'", where).substr(0, 5) != "False")
    fail({where, "the table is stored by columns", "fortran_order False", "True",
          "numpy.save(path, numpy.ascontiguousarray(table))"});
  double count = 1;
  for (const std::size_t n : out.shape) count *= double(n);
  if (count * double(kind->size) != double(bytes.size() - start))
    fail({where, "the file has not the size that its header says",
          number(count * double(kind->size)) + " bytes of numbers", std::to_string(bytes.size() - start),
          "copy the file again"});
  out.values.resize(std::size_t(count));
  for (std::size_t i = 0; i < out.values.size(); ++i) {
    out.values[i] = kind->read(bytes.data() + start + kind->size * i);
    if (!any && !std::isfinite(out.values[i]))
      fail({where, "a number is not finite", "finite numbers",
            number(out.values[i]) + " in row " +
                std::to_string(out.shape.empty() ? 0 : i * out.shape[0] / out.values.size()),
            ""});
  }
  return out;
}

std::string axes_text(const std::vector<std::size_t>& shape) {
  return fmt::format("({})", fmt::join(shape, ", "));
}

std::vector<std::size_t> without_batch(std::vector<std::size_t> shape, std::size_t axes) {
  while (shape.size() > axes && shape[0] == 1) shape.erase(shape.begin());
  return shape;
}

std::string npy_bytes(const std::vector<std::size_t>& shape, std::span<const float> values) {
  constexpr std::size_t kBefore = 10,
                        kAligned = 64;  // bytes before the header, and of what is before numbers
  std::string header =
      fmt::format("{{'descr': '<f4', 'fortran_order': False, 'shape': ({},), }}", fmt::join(shape, ", "));
  header.resize((kBefore + header.size() + kAligned) / kAligned * kAligned - kBefore, ' ');
  header.back() = '\n';
  std::string out(kNpyMark);
  out += '\1';  // version 1.0
  out += '\0';
  out += char(header.size() & 0xff);
  out += char(header.size() >> 8);
  out += header;
  out.append(reinterpret_cast<const char*>(values.data()), values.size_bytes());
  return out;
}

NpyTable read_npy(const std::filesystem::path& path, const std::string& where) {
  NpyArray array = parse_npy(read_bytes(path, where, std::uintmax_t(1) << 30), where);
  if (array.shape.size() != 2)
    fail({where, "the table has not two axes", "(rows, columns), each at least 1",
          std::to_string(array.shape.size()) + " axes", ""});
  return {array.shape[0], array.shape[1], std::move(array.values)};
}

}  // namespace splinevox::data
