// SPDX-License-Identifier: Apache-2.0
#include "io/splat/splat_file.hpp"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <string_view>

#include "math/activation.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox {
namespace {

constexpr std::size_t kMostHeader = 1 << 16;
constexpr int kFixed = 11;  ///< fields before f_dc
const char* const kFields[kFixed] = {"x",       "y",     "z",     "opacity", "scale_0", "scale_1",
                                     "scale_2", "rot_0", "rot_1", "rot_2",   "rot_3"};

/// Types of PLY: two names and a width each.
struct Type {
  const char *name, *other;
  std::size_t bytes;
};
constexpr Type kTypes[] = {{"char", "int8", 1},     {"uchar", "uint8", 1},   {"short", "int16", 2},
                           {"ushort", "uint16", 2}, {"int", "int32", 4},     {"uint", "uint32", 4},
                           {"float", "float32", 4}, {"double", "float64", 8}};

int type_of(std::string_view name) {
  for (int t = 0; t < int(std::size(kTypes)); ++t)
    if (name == kTypes[t].name || name == kTypes[t].other) return t;
  return -1;
}

template <class T>
double as(const std::uint8_t* bytes) {
  T v;
  std::memcpy(&v, bytes, sizeof v);
  return double(v);
}

std::vector<std::string_view> words_of(std::string_view line) {
  std::vector<std::string_view> words;
  while (!line.empty()) {
    const std::size_t start = line.find_first_not_of(" \t\r");
    if (start == line.npos) break;
    line.remove_prefix(start);
    const std::size_t end = std::min(line.find_first_of(" \t\r"), line.size());
    words.push_back(line.substr(0, end));
    line.remove_prefix(end);
  }
  return words;
}

std::string shown(std::string_view text) {
  std::string out(1, '\'');
  out.append(text.substr(0, 60));
  return out += '\'';
}

[[noreturn]] void refuse(const std::string& path, const std::string& what, const std::string& got,
                         const std::string& hint = "") {
  fail({.where = path,
        .what = what,
        .expected =
            "a PLY of Gaussian splats: x, y, z, f_dc_0, ..., opacity, scale_0, ..., rot_0, ..., binary "
            "little-endian or ASCII",
        .got = got,
        .hint = hint});
}

}  // namespace

SplatFile::SplatFile(const std::string& path) : path_(path), file_(MappedFile::open(path)) {
  static_assert(std::endian::native == std::endian::little);
  if (!file_) refuse(path, "there is no such file, or it is empty", "");
  const auto bytes = file_->bytes();
  read_header({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

void SplatFile::read_header(std::string_view bytes) {
  if (!bytes.starts_with("ply\n") && !bytes.starts_with("ply\r\n"))
    refuse(path_, "is no PLY", "a file that does not begin with 'ply'");
  const std::string_view head = bytes.substr(0, kMostHeader);
  std::vector<std::string> names;
  std::vector<Property> properties;
  bool vertex = false, seen = false;
  std::size_t at = 0;
  for (;;) {
    const std::size_t end = head.find('\n', at);
    if (end == head.npos) refuse(path_, "has a header without an end", "no line end_header");
    const std::vector<std::string_view> words = words_of(head.substr(at, end - at));
    at = end + 1;
    if (words.empty() || words[0] == "ply" || words[0] == "comment" || words[0] == "obj_info") continue;
    if (words[0] == "end_header") break;
    if (words[0] == "format") {
      text_ = words.size() > 1 && words[1] == "ascii";
      if (!text_ && (words.size() < 2 || words[1] != "binary_little_endian"))
        refuse(path_, "has a format that is not read", words.size() > 1 ? shown(words[1]) : "none");
    } else if (words[0] == "element") {
      if (words.size() != 3) refuse(path_, "has a malformed element", shown(words[0]));
      if (words[1] == "chunk")
        refuse(path_, "is a compressed PLY of splats", "an element 'chunk'",
               "convert it to a plain PLY, as splat-transform does");
      vertex = words[1] == "vertex";
      if (vertex) {
        const auto [stop, error] =
            std::from_chars(words[2].data(), words[2].data() + words[2].size(), count_);
        if (error != std::errc() || stop != words[2].data() + words[2].size() || count_ > (1u << 31))
          refuse(path_, "has a malformed number of splats", shown(words[2]));
      } else if (!seen && words[2] != "0") {
        refuse(path_, "has another element before its splats", shown(words[1]));
      }
      seen = seen || vertex;
    } else if (words[0] == "property" && vertex) {
      const int type = words.size() == 3 ? type_of(words[1]) : -1;
      if (type < 0) refuse(path_, "has a property that is no number", shown(words.back()));
      names.emplace_back(words[2]);
      properties.push_back({type, text_ ? names.size() - 1 : stride_});
      stride_ += kTypes[type].bytes;
    }
  }
  find_fields(names, properties);
  const std::string_view body = bytes.substr(at);
  if (text_) {
    stride_ = names.size();
    read_text(body);
    return;
  }
  if (body.size() / stride_ < count_)
    refuse(path_, "ends before its last splat",
           std::to_string(body.size() / stride_) + " of " + std::to_string(count_) + " splats");
  rows_ = reinterpret_cast<const std::uint8_t*>(body.data());
}

void SplatFile::find_fields(const std::vector<std::string>& names, const std::vector<Property>& properties) {
  const auto find = [&](const std::string& name) -> const Property* {
    const auto found = std::find(names.begin(), names.end(), name);
    return found == names.end() ? nullptr : &properties[std::size_t(found - names.begin())];
  };
  const auto add = [&](const std::string& name) {
    const Property* property = find(name);
    if (!property)
      refuse(path_, "has no property '" + name + "'",
             find("red") || find("diffuse_red") ? "a mesh or a cloud of points"
                                                : std::to_string(names.size()) + " other properties");
    fields_.push_back(*property);
  };
  for (const char* name : kFields) add(name);
  for (int c = 0; c < 3; ++c) add("f_dc_" + std::to_string(c));
  int rest = 0;
  while (find("f_rest_" + std::to_string(rest))) add("f_rest_" + std::to_string(rest++));
  for (degree_ = 0; degree_ <= 3; ++degree_)
    if (rest == 3 * ((degree_ + 1) * (degree_ + 1) - 1)) return;
  refuse(path_, "has harmonics of no degree from 0 to 3", std::to_string(rest) + " properties f_rest",
         "0, 9, 24 or 45 of them");
}

void SplatFile::read_text(std::string_view text) {
  const std::size_t wanted = count_ * stride_;
  if (text.size() / 2 + 1 < wanted)  // a digit and a space each: not even room for them
    refuse(path_, "ends before its last splat", std::to_string(text.size()) + " bytes");
  numbers_.reserve(wanted);
  const char *at = text.data(), *end = at + text.size();
  while (numbers_.size() < wanted) {
    while (at < end && (*at == ' ' || *at == '\t' || *at == '\r' || *at == '\n')) ++at;
    const char* last =
        std::find_if(at, end, [](char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; });
    if (at == end)
      refuse(path_, "ends before its last splat",
             std::to_string(numbers_.size() / stride_) + " of " + std::to_string(count_) + " splats");
    double v = 0;
    const auto [stop, error] = std::from_chars(at, last, v);
    if (stop != last || (error != std::errc() && error != std::errc::result_out_of_range))
      refuse(path_, "has a number that is none, of splat " + std::to_string(numbers_.size() / stride_),
             shown({at, std::size_t(last - at)}));
    numbers_.push_back(v);
    at = last;
  }
}

double SplatFile::value(const std::uint8_t* row, const Property& property) const {
  const std::uint8_t* at = row + property.offset;
  switch (property.type) {
    case 0:
      return as<std::int8_t>(at);
    case 1:
      return as<std::uint8_t>(at);
    case 2:
      return as<std::int16_t>(at);
    case 3:
      return as<std::uint16_t>(at);
    case 4:
      return as<std::int32_t>(at);
    case 5:
      return as<std::uint32_t>(at);
    case 6:
      return as<float>(at);
    default:
      return as<double>(at);
  }
}

bool SplatFile::read(std::size_t i, Splat& out) const {
  const auto field = [&](std::size_t f) {
    return text_ ? numbers_[i * stride_ + fields_[f].offset] : value(rows_ + i * stride_, fields_[f]);
  };
  for (int a = 0; a < 3; ++a) {
    out.place[a] = field(std::size_t(a));
    out.size[a] = std::exp(field(std::size_t(4 + a)));
  }
  out.opacity = sigmoid(field(3)).value;
  double norm = 0;
  for (std::size_t q = 0; q < 4; ++q) {
    out.rotation[q] = field(7 + q);
    norm += out.rotation[q] * out.rotation[q];
  }
  norm = std::sqrt(norm);
  for (double& q : out.rotation) q /= norm;
  out.harmonics = (degree_ + 1) * (degree_ + 1);
  const std::size_t rest = std::size_t(out.harmonics - 1);
  double sum =
      norm + out.opacity + out.place.x + out.place.y + out.place.z + out.size.x + out.size.y + out.size.z;
  for (std::size_t c = 0; c < 3; ++c) {
    out.color[0][int(c)] = field(kFixed + c);
    for (std::size_t j = 0; j < rest; ++j) out.color[j + 1][int(c)] = field(kFixed + 3 + c * rest + j);
    for (std::size_t j = 0; j <= rest; ++j) sum += out.color[j][int(c)];
  }
  return std::isfinite(sum) && norm > 0 && out.size.x > 0 && out.size.y > 0 && out.size.z > 0;
}

}  // namespace splinevox
