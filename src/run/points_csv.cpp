// SPDX-License-Identifier: Apache-2.0
#include "run/points_csv.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string_view>

#include "core/atomic_file.hpp"
#include "core/byte_order_mark.hpp"
#include "core/number_text.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::run {
namespace {

constexpr std::uint64_t kLargestTable = std::uint64_t(1) << 30;  ///< bytes

std::string_view trimmed(std::string_view text) {
  const auto space = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
  while (!text.empty() && space(text.front())) text.remove_prefix(1);
  while (!text.empty() && space(text.back())) text.remove_suffix(1);
  return text;
}

std::vector<std::string_view> fields(std::string_view line) {
  std::vector<std::string_view> out;
  for (std::size_t at = 0; at <= line.size();) {
    const std::size_t comma = std::min(line.find(',', at), line.size());
    out.push_back(trimmed(line.substr(at, comma - at)));
    at = comma + 1;
  }
  return out;
}

struct Columns {
  int x = -1, y = -1, z = -1, time = -1, id = -1;
  int last() const { return std::max({x, y, z, time, id}); }
};

Columns find_columns(const std::string& path, std::string_view header) {
  Columns c;
  const std::vector<std::string_view> names = fields(header);
  for (int i = 0; i < int(names.size()); ++i)
    for (auto [name, column] :
         {std::pair{"x", &c.x}, {"y", &c.y}, {"z", &c.z}, {"time", &c.time}, {"id", &c.id}}) {
      if (names[i] != name) continue;
      if (*column >= 0)
        fail({path, fmt::format("there are two columns '{}'", name), "each name once", std::string(header),
              ""});
      *column = i;
    }
  if (c.x < 0 || c.y < 0 || c.z < 0)
    fail({path, "the first line does not name the columns", "x,y,z and if wanted time,id",
          std::string(header.substr(0, 200)), ""});
  return c;
}

double number(const std::string& path, std::size_t line, const char* column, std::string_view text) {
  const auto value = parse_number<double>(text);
  if (!value || !std::isfinite(*value))
    fail({fmt::format("{}, line {}", path, line), fmt::format("'{}' is not a number", column),
          "a finite number such as -0.25", std::string(text.substr(0, 100)), ""});
  return *value;
}

}  // namespace

PointTable read_points(const std::string& path) {
  std::istringstream in(read_file(path, kLargestTable, Named::by_user));
  PointTable out;
  std::string line;
  Columns columns;
  bool named = false;
  for (std::size_t n = 1; std::getline(in, line); ++n) {
    const std::string_view text = trimmed(std::string_view(line).substr(n == 1 ? byte_order_mark(line) : 0));
    if (text.empty() || text.front() == '#') continue;
    if (!named) {
      columns = find_columns(path, text);
      named = true;
      continue;
    }
    const std::vector<std::string_view> f = fields(text);
    if (int(f.size()) <= columns.last())
      fail({fmt::format("{}, line {}", path, n), "there are too few fields",
            fmt::format("at least {}", columns.last() + 1), std::string(text.substr(0, 100)), ""});
    const auto value = [&](const char* name, int column) { return number(path, n, name, f[column]); };
    out.position.push_back(
        {float(value("x", columns.x)), float(value("y", columns.y)), float(value("z", columns.z))});
    if (columns.time >= 0) out.time.push_back(value("time", columns.time));
    if (columns.time >= 0 && !(out.time.back() >= 0 && out.time.back() <= 1))
      fail({fmt::format("{}, line {}", path, n), "there is no such time in the model", "a time in [0, 1]",
            fmt::format("{}", out.time.back()), ""});
    if (columns.id >= 0) out.id.emplace_back(f[columns.id]);
  }
  if (out.position.empty())
    fail({path, "there is not one point in it", "a line of names and a line per point", "", ""});
  return out;
}

}  // namespace splinevox::run
