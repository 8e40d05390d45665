// SPDX-License-Identifier: Apache-2.0
#include "torture/mutate.hpp"

#include <algorithm>
#include <cstring>

#include "torture/draw.hpp"

namespace splinevox::torture {
namespace {

constexpr std::size_t kLongest = std::size_t(1) << 20;  ///< bytes of a mutated file

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// Replaces a number that is written in digits by one that parsers stumble over.
void replace_number(std::string& file, Draw& draw) {
  static const char* const kNumbers[] = {"0",
                                         "-0",
                                         "-1",
                                         "1e999",
                                         "-1e999",
                                         "1e-400",
                                         "NaN",
                                         "Infinity",
                                         "4294967296",
                                         "18446744073709551616",
                                         "-9223372036854775809",
                                         "1e300",
                                         "3.4028236e38",
                                         "0x10",
                                         "1.",
                                         ".5",
                                         "1e",
                                         "00",
                                         "null",
                                         "\"1\"",
                                         "[]",
                                         ""};
  std::size_t at = draw.below(file.size());
  while (at < file.size() && !is_digit(file[at])) ++at;
  if (at == file.size()) return;
  std::size_t end = at;
  while (at > 0 && (is_digit(file[at - 1]) || file[at - 1] == '.' || file[at - 1] == '-')) --at;
  while (end < file.size() && (is_digit(file[end]) || file[end] == '.')) ++end;
  file.replace(at, end - at, kNumbers[draw.below(std::size(kNumbers))]);
}

/// Overwrites 1, 2, 4 or 8 bytes by a number at the edge of a type, in either byte order.
void replace_binary(std::string& file, Draw& draw) {
  static const std::uint64_t kEdges[] = {0,
                                         1,
                                         0x7f,
                                         0x80,
                                         0xff,
                                         0x7fff,
                                         0x8000,
                                         0xffff,
                                         0x10000,
                                         0x7fffffff,
                                         0x80000000,
                                         0xffffffff,
                                         0x100000000,
                                         0x7fffffffffffffff,
                                         0x8000000000000000,
                                         ~0ull};
  const std::size_t bytes = std::size_t(1) << draw.below(4);
  if (file.size() < bytes) return;
  const std::uint64_t value = kEdges[draw.below(std::size(kEdges))];
  char raw[8];
  std::memcpy(raw, &value, 8);
  if (draw.below(2)) std::reverse(raw, raw + bytes);
  std::memcpy(file.data() + draw.below(file.size() - bytes + 1), raw, bytes);
}

void once(std::string& file, const std::vector<std::string>& seeds, Draw& draw) {
  const std::size_t at = draw.below(file.size());
  const std::size_t part =
      std::min(file.size() - at, draw.below(4) ? 1 + draw.below(16) : 1 + draw.below(file.size()));
  switch (draw.below(9)) {
    case 0:
      if (!file.empty()) file[at] = char(file[at] ^ (1 << draw.below(8)));
      break;
    case 1:
      if (!file.empty()) file[at] = char(draw.bits());
      break;
    case 2:
      replace_number(file, draw);
      break;
    case 3:
      replace_binary(file, draw);
      break;
    case 4:
      file.erase(at, part);
      break;
    case 5:
      file.insert(draw.below(file.size()), file.substr(at, part));
      break;
    case 6:
      file.resize(at);
      break;
    case 7: {
      const std::string& other = seeds[draw.below(seeds.size())];
      file = file.substr(0, at) + other.substr(draw.below(other.size()));
      break;
    }
    default:
      file.insert(at, draw.below(8) ? 1 + draw.below(8) : 1 + draw.below(5000),
                  "[{\"(,:\x00\xff\n 9-"[draw.below(13)]);
  }
}

}  // namespace

std::string mutate(const fuzz::Target& target, const std::vector<std::string>& seeds, std::uint64_t seed,
                   std::uint64_t index) {
  Draw draw(seed, index);
  std::string file = seeds[draw.below(seeds.size())];
  for (std::size_t n = 1 + draw.below(5); n > 0; --n) once(file, seeds, draw);
  if (file.size() > kLongest) file.resize(kLongest);
  if (target.mend && draw.below(4)) target.mend(file);
  return file;
}

}  // namespace splinevox::torture
