// SPDX-License-Identifier: Apache-2.0
#include "data/times/names.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <optional>
#include <set>

#include "data/message_text.hpp"
#include "data/times/digits.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::data {
namespace {

using Verdict = NamesRead::Verdict;

/// One group of digits, down all names.
struct Column {
  std::vector<NameNumber> numbers;  ///< one per picture
  bool in_folder = false;
  std::size_t distinct() const {
    std::set<double> values;
    for (const NameNumber& n : numbers) values.insert(n.value);
    return values.size();
  }
  bool clock() const { return kind_is(NameNumber::Kind::clock); }
  bool decimal() const { return kind_is(NameNumber::Kind::decimal); }

 private:
  bool kind_is(NameNumber::Kind kind) const {
    return std::all_of(numbers.begin(), numbers.end(), [&](const NameNumber& n) { return n.kind == kind; });
  }
};

/// All names, taken apart alike.
struct Table {
  std::vector<Column> columns;             ///< those whose values differ
  std::vector<std::string> folders;        ///< the folder of each picture
  std::vector<std::string> stem_texts;     ///< the text of each picture's own name
  std::optional<std::size_t> odd_one_out;  ///< a picture whose name has another form than most
};

bool is_one_of(const std::string& word, std::initializer_list<const char*> words) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

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

/// The names that cameras give to photographs, one after the other.
bool names_photograph(const NameNumber& n) {
  return is_one_of(n.before, {"img", "dsc", "dscn", "dscf", "mg", "imgp", "pict", "dji", "gopr", "gp", "sam",
                              "cimg", "photo", "pxl", "hpim"});
}

bool all_of(const Column& column, bool (*is)(const NameNumber&)) {
  return std::all_of(column.numbers.begin(), column.numbers.end(), is);
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

/// Of columns that count the same thing the one that tells most: a clock, decimals, else the last.
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

/// Whether a camera that stands still has several values of this column.
bool varies_at_one_place(const Column& column, const std::vector<NamedPicture>& pictures) {
  std::map<std::size_t, double> first;
  for (std::size_t i = 0; i < pictures.size(); ++i)
    if (first.try_emplace(pictures[i].place, column.numbers[i].value).first->second !=
        column.numbers[i].value)
      return true;
  return false;
}

std::size_t places_of(const std::vector<NamedPicture>& pictures) {
  std::set<std::size_t> places;
  for (const NamedPicture& p : pictures) places.insert(p.place);
  return places.size();
}

/// Whether splits of a data set each count from the start: train/r_000 and test/r_000. Within a split every
/// number stands once, else they are moments that several cameras see.
bool splits_restart(const Column& column, const std::vector<NamedPicture>& pictures) {
  std::map<double, std::size_t> split_of;
  std::set<std::pair<std::size_t, double>> taken;
  std::size_t shared = 0;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const double value = column.numbers[i].value;
    if (!taken.emplace(pictures[i].split, value).second) return false;
    shared += split_of.try_emplace(value, pictures[i].split).first->second != pictures[i].split ? 1 : 0;
  }
  return shared * 4 > pictures.size();
}

std::string example(const NamedPicture& picture) { return in_quotes(picture.path); }

std::string text_of(const NameNumber& n) {
  return n.kind == NameNumber::Kind::clock ? n.digits : number(n.value);
}

NamesRead unclear(std::string reason) { return {Verdict::unclear, false, {}, std::move(reason)}; }

NamesRead one_moment(bool sure, std::string reason) {
  return {Verdict::one_moment, sure, {}, std::move(reason)};
}

/// Times from a column, unless one lies so far off that all others would fall together.
NamesRead times_from(const Column& column, const std::vector<NamedPicture>& pictures, bool sure,
                     const std::string& why) {
  constexpr double kFarOff = 10;  // a gap this many times as wide as everything else together
  constexpr std::size_t kEnough = 5;
  std::map<double, std::size_t> first_at;
  NamesRead read{Verdict::times, sure, {}, {}};
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    read.times.push_back(column.numbers[i].value);
    first_at.try_emplace(read.times.back(), i);
  }
  const double range = first_at.rbegin()->first - first_at.begin()->first;
  double widest = 0;
  auto after = first_at.begin();
  for (auto it = std::next(first_at.begin()); it != first_at.end(); ++it)
    if (it->first - std::prev(it)->first > widest) {
      widest = it->first - std::prev(it)->first;
      after = it;
    }
  if (first_at.size() >= kEnough && widest > kFarOff * (range - widest))
    return unclear(fmt::format("{} and {} lie further apart than all others together",
                               example(pictures[std::prev(after)->second]),
                               example(pictures[after->second])));
  const std::size_t last = first_at.rbegin()->second, first = first_at.begin()->second;
  read.reason =
      fmt::format("{} is at {}, {} at {} ({})", example(pictures[first]), text_of(column.numbers[first]),
                  example(pictures[last]), text_of(column.numbers[last]), why);
  return read;
}

/// Several numbers count: which is the time?
NamesRead choose(std::vector<Column> columns, const std::vector<NamedPicture>& pictures) {
  const std::size_t places = places_of(pictures);
  if (places < pictures.size()) {
    std::vector<Column> moving;
    std::copy_if(columns.begin(), columns.end(), std::back_inserter(moving),
                 [&](const Column& c) { return varies_at_one_place(c, pictures); });
    if (moving.size() == 1 && places * 2 <= pictures.size())
      return times_from(moving[0], pictures, true, "cameras that stand still have several of these numbers");
    if (!moving.empty()) columns = moving;
  }
  std::vector<Column> timed, others;
  for (const Column& c : columns) {
    if (all_of(c, names_time)) timed.push_back(c);
    if (!all_of(c, names_camera)) others.push_back(c);
  }
  if (timed.size() == 1) return times_from(timed[0], pictures, true, "the word beside the number says so");
  if (others.size() == 1 && columns.size() > 1)
    return times_from(others[0], pictures, true, "the other numbers are those of cameras");
  std::vector<Column> in_names;
  std::copy_if(others.begin(), others.end(), std::back_inserter(in_names),
               [](const Column& c) { return !c.in_folder; });
  if (in_names.size() == 1 && others.size() == 2) {
    const Column& folder = others[0].in_folder ? others[0] : others[1];
    if (in_names[0].distinct() > folder.distinct())
      return times_from(in_names[0], pictures, false, "every folder is taken as a camera");
  }
  std::vector<Column> unique;
  std::copy_if(others.begin(), others.end(), std::back_inserter(unique),
               [&](const Column& c) { return c.distinct() == pictures.size(); });
  if (unique.size() == 1)
    return times_from(unique[0], pictures, false, "no two pictures have the same of these numbers");
  return unclear(fmt::format("several numbers count in them, in {}: {}", example(pictures[0]),
                             list_groups(pictures[0].path)));
}

/// One number counts: moments, cameras, or photographs?
NamesRead weigh(const Column& column, const std::vector<NamedPicture>& pictures) {
  const bool distinct_places = places_of(pictures) == pictures.size();
  if (!distinct_places && varies_at_one_place(column, pictures))
    return times_from(column, pictures, true, "cameras that stand still have several of these numbers");
  if (all_of(column, names_camera))
    return one_moment(true, fmt::format("the number in {} is a camera's", example(pictures[0])));
  if (splits_restart(column, pictures))
    return one_moment(false, "every split counts its pictures from the start again");
  if (all_of(column, names_photograph))
    return one_moment(
        false, fmt::format("{} is the name of a photograph, which counts no time", example(pictures[0])));
  return times_from(column, pictures, all_of(column, names_time), "the only number that counts up");
}

/// Whether decimals make sense: two groups with a point between them are a camera and a frame if every
/// camera has every frame.
bool point_is_decimal(const std::vector<NamedPicture>& pictures) {
  const Table apart = table_of(pictures, false), joined = table_of(pictures, true);
  const auto decimal =
      std::find_if(joined.columns.begin(), joined.columns.end(), [](const Column& c) { return c.decimal(); });
  if (decimal == joined.columns.end()) return false;
  std::set<std::string> whole, parts;
  for (const NameNumber& n : decimal->numbers) {
    whole.insert(n.digits.substr(0, n.digits.find('.')));
    parts.insert(n.digits.substr(n.digits.find('.') + 1));
  }
  return whole.size() == 1 || whole.size() * parts.size() != decimal->distinct();
}

}  // namespace

NamesRead read_names(const std::vector<NamedPicture>& pictures) {
  if (pictures.size() < 2) return one_moment(true, "there is one picture");
  Table table = table_of(pictures, point_is_decimal(pictures));
  if (table.odd_one_out)
    return unclear(example(pictures[*table.odd_one_out]) + " has another form than the other names");
  std::vector<Column>& columns = table.columns;
  drop_repeats(columns);
  if (columns.empty()) {
    const bool same_names = std::all_of(table.stem_texts.begin(), table.stem_texts.end(),
                                        [&](const std::string& s) { return s == table.stem_texts[0]; });
    if (same_names && std::set(table.folders.begin(), table.folders.end()).size() == pictures.size())
      return one_moment(true, "every folder has one picture, of the same name");
    return unclear(fmt::format("no number counts up in them, such as {}", example(pictures[0])));
  }
  for (const auto& [is, why] : {std::pair{&Column::clock, "a date and time of day"},
                                std::pair{&Column::decimal, "a number with decimals"}}) {
    std::vector<Column> found;
    std::copy_if(columns.begin(), columns.end(), std::back_inserter(found),
                 [&, test = is](const Column& c) { return (c.*test)(); });
    if (found.size() == 1) return times_from(found[0], pictures, true, why);
  }
  return columns.size() == 1 ? weigh(columns[0], pictures) : choose(columns, pictures);
}

std::vector<double> times_of_group(const std::vector<NamedPicture>& pictures, int group) {
  const bool decimals = point_is_decimal(pictures);
  std::vector<double> times;
  for (const NamedPicture& p : pictures) {
    NameParts parts = take_apart(p.path, decimals);
    parts.folder.insert(parts.folder.end(), parts.stem.begin(), parts.stem.end());
    const std::ptrdiff_t n = std::ptrdiff_t(parts.folder.size()), at = group > 0 ? group - 1 : n + group;
    if (group == 0 || at < 0 || at >= n)
      fail({in_quotes(p.path), "this name has no such group of digits",
            "--times name:GROUP, from 1 at the left or from -1 at the right", std::to_string(group),
            n == 0 ? "there are none" : "there are " + list_groups(p.path)});
    times.push_back(parts.folder[std::size_t(at)].value);
  }
  return times;
}

std::string list_groups(const std::string& path) {
  NameParts parts = take_apart(path, false);
  parts.folder.insert(parts.folder.end(), parts.stem.begin(), parts.stem.end());
  std::string text;
  for (std::size_t g = 0; g < parts.folder.size(); ++g)
    text += fmt::format("{}{}: {}", g == 0 ? "" : ", ", g + 1, parts.folder[g].digits);
  return text;
}

bool natural_less(const std::string& a, const std::string& b) {
  std::size_t i = 0, k = 0;
  const auto digit = [](char c) { return c >= '0' && c <= '9'; };
  while (i < a.size() && k < b.size()) {
    if (!digit(a[i]) || !digit(b[k])) {
      if (a[i] != b[k]) return a[i] < b[k];
      ++i;
      ++k;
      continue;
    }
    const auto run = [&](const std::string& s, std::size_t& at) {
      while (at < s.size() && s[at] == '0') ++at;
      const std::size_t begin = at;
      while (at < s.size() && digit(s[at])) ++at;
      return s.substr(begin, at - begin);
    };
    const std::string x = run(a, i), y = run(b, k);
    if (x.size() != y.size()) return x.size() < y.size();
    if (x != y) return x < y;
  }
  return a.size() - i != b.size() - k ? a.size() - i < b.size() - k : a < b;
}

}  // namespace splinevox::data
