// SPDX-License-Identifier: Apache-2.0
#include "data/times/name_table.hpp"

#include <cmath>
#include <functional>
#include <map>
#include <string_view>

namespace splinevox::data {
namespace {

bool is_one_of(const std::string& word, std::initializer_list<const char*> words) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

std::string folder_of(const std::string& path) {
  const std::size_t slash = path.find_last_of("/\\");
  return slash == std::string::npos ? "" : path.substr(0, slash);
}

/// Columns of one side of the names: none where the numbers of groups differ.
void add_columns(const std::vector<NameParts>& parts, bool in_folder, std::vector<Column>& columns) {
  const auto side = [&](std::size_t i) -> const std::vector<NameNumber>& {
    return in_folder ? parts[i].folder : parts[i].stem;
  };
  const std::size_t groups = side(0).size();
  for (std::size_t i = 0; i < parts.size(); ++i)
    if (side(i).size() != groups) return;
  for (std::size_t g = 0; g < groups; ++g) {
    Column column{{}, in_folder};
    for (std::size_t i = 0; i < parts.size(); ++i) column.numbers.push_back(side(i)[g]);
    if (column.clock()) count_from_first(column.numbers);
    if (column.distinct() > 1) columns.push_back(std::move(column));
  }
}

/// A picture whose name has another text or another number of groups than nearly all.
std::optional<std::size_t> find_odd(const std::vector<NameParts>& parts) {
  std::map<std::string, std::pair<std::size_t, std::size_t>> forms;  // count, first
  for (std::size_t i = 0; i < parts.size(); ++i)
    ++forms.try_emplace(parts[i].stem_text, 0, i).first->second.first;
  const auto most = std::max_element(forms.begin(), forms.end(), [](const auto& a, const auto& b) {
    return a.second.first < b.second.first;
  });
  if (most->second.first * 5 < parts.size() * 4) return {};
  for (const auto& [text, count] : forms)
    if (count.first <= 2 && count.first < most->second.first) return count.second;
  return {};
}

/// Whether `b` grows with `a` and has one value for each of its: they count the same thing.
bool count_together(const Column& a, const Column& b) {
  std::map<double, double> of;
  for (std::size_t i = 0; i < a.numbers.size(); ++i)
    if (of.try_emplace(a.numbers[i].value, b.numbers[i].value).first->second != b.numbers[i].value)
      return false;
  std::vector<double> values;
  for (const auto& [key, value] : of) values.push_back(value);
  return std::adjacent_find(values.begin(), values.end(), std::greater_equal<>()) == values.end();
}

bool has_point(std::string_view path) {
  const auto digit = [](char c) { return c >= '0' && c <= '9'; };
  path = bare_name(path);
  for (std::size_t i = 1; i + 1 < path.size(); ++i)
    if (path[i] == '.' && digit(path[i - 1]) && digit(path[i + 1])) return true;
  return false;
}

}  // namespace

bool names_camera(const NameNumber& n) {
  const auto camera = [](const std::string& word) {
    return is_one_of(word, {"cam", "camera", "cams", "cameras", "c", "view", "views", "viewpoint", "kinect",
                            "sensor", "lens", "device", "gopro", "rig"});
  };
  return camera(n.before) || camera(n.after);
}

bool names_time(const NameNumber& n) {
  const auto time = [](const std::string& word) {
    return is_one_of(
        word, {"frame", "frames", "f", "fr", "t", "time", "timestep", "step", "moment", "tick", "frm"});
  };
  return time(n.before) || time(n.after);
}

bool names_photograph(const NameNumber& n) {
  return is_one_of(n.before, {"img", "dsc", "dscn", "dscf", "mg", "imgp", "pict", "dji", "gopr", "gp", "sam",
                              "cimg", "photo", "pxl", "hpim"});
}

Table table_of(const std::vector<NamedPicture>& pictures, bool decimals) {
  Table table;
  std::vector<NameParts> parts;
  for (const NamedPicture& p : pictures) {
    parts.push_back(take_apart(p.path, decimals));
    table.folders.push_back(folder_of(p.path));
    table.stem_texts.push_back(parts.back().stem_text);
  }
  table.odd_one_out = find_odd(parts);
  add_columns(parts, true, table.columns);
  add_columns(parts, false, table.columns);
  return table;
}

void drop_repeats(std::vector<Column>& columns) {
  const auto worth = [](const Column& c) { return c.clock() ? 2 : c.decimal() ? 1 : 0; };
  for (std::size_t i = 0; i < columns.size(); ++i)
    for (std::size_t k = i + 1; k < columns.size();) {
      if (!count_together(columns[i], columns[k])) {
        ++k;
        continue;
      }
      const std::size_t drop = worth(columns[i]) > worth(columns[k]) ? k : i;
      columns.erase(columns.begin() + std::ptrdiff_t(drop));
      k = i + 1;
    }
}

bool is_shared(const Column& column) {
  std::map<double, std::size_t> count;
  for (const NameNumber& n : column.numbers) ++count[n.value];
  std::size_t shared = 0;
  for (const auto& [value, pictures] : count) shared += pictures > 1 ? pictures : 0;
  return 2 * shared >= column.numbers.size();
}

Point point_in(const std::vector<NamedPicture>& pictures) {
  if (std::none_of(pictures.begin(), pictures.end(), [](const NamedPicture& p) { return has_point(p.path); }))
    return Point::none;
  const Table joined = table_of(pictures, true);
  const auto decimal = std::find_if(joined.columns.begin(), joined.columns.end(), [](const Column& c) {
    return c.decimal() ||
           (c.clock() && std::all_of(c.numbers.begin(), c.numbers.end(), [](const NameNumber& n) {
              return n.digits.find('.') != std::string::npos;
            }));
  });
  if (decimal == joined.columns.end()) return Point::between;
  std::set<std::string> whole, parts;
  std::set<double> values;
  std::set<std::size_t> lengths;
  for (const NameNumber& n : decimal->numbers) {
    values.insert(n.value);
    whole.insert(n.digits.substr(0, n.digits.rfind('.')));
    parts.insert(n.digits.substr(n.digits.rfind('.') + 1));
  }
  for (const std::string& part : parts) lengths.insert(part.size());
  if (whole.size() == 1 && lengths.size() > 1) {
    const bool counted = std::none_of(parts.begin(), parts.end(), [](const std::string& part) {
      return part.size() > 1 && part[0] == '0';
    });
    return !counted ? Point::decimal : whole.begin()->size() > 1 ? Point::between : Point::maybe;
  }
  const double step =
      (*values.rbegin() - *values.begin()) / double(std::max<std::size_t>(values.size() - 1, 1));
  const bool evenly = std::adjacent_find(values.begin(), values.end(), [&](double a, double b) {
                        return std::abs(b - a - step) > 1e-6 * step;
                      }) == values.end();
  const bool grid = whole.size() > 1 && whole.size() * parts.size() == values.size();
  if (evenly) return Point::decimal;
  if (grid) return Point::between;
  return decimal->clock() ? Point::decimal : Point::maybe;  // moment and camera, some of them missing
}

}  // namespace splinevox::data
