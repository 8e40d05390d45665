// SPDX-License-Identifier: Apache-2.0
#include "data/times/names.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <optional>
#include <set>

#include "data/message_text.hpp"
#include "data/times/digits.hpp"
#include "data/times/name_table.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::data {
namespace {

using Verdict = NamesRead::Verdict;

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
  NamesRead read{Verdict::times, sure && !column.after_midnight(), {}, {}};
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
NamesRead choose(const std::vector<Column>& columns, const std::vector<NamedPicture>& pictures) {
  std::vector<Column> timed, others;
  for (const Column& c : columns) {
    if (all_of(c, names_time)) timed.push_back(c);
    if (!all_of(c, names_camera)) others.push_back(c);
  }
  if (timed.size() == 1)
    return times_from(timed[0], pictures, is_shared(timed[0]), "the word beside the number says so");
  if (others.size() == 1)
    return times_from(others[0], pictures, is_shared(others[0]), "the other numbers are those of cameras");
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

/// One number counts, and few cameras stand still: moments, cameras, or photographs?
NamesRead weigh(const Column& column, const std::vector<NamedPicture>& pictures) {
  if (all_of(column, names_camera) && !varies_at_one_place(column, pictures))
    return one_moment(false, fmt::format("the number in {} is a camera's", example(pictures[0])));
  if (splits_restart(column, pictures))
    return one_moment(false, "every split counts its pictures from the start again");
  if (all_of(column, names_photograph))
    return one_moment(
        false, fmt::format("{} is the name of a photograph, which counts no time", example(pictures[0])));
  return times_from(column, pictures, false, "the only number that counts up");
}

/// Of a decimal only the word before it speaks: in 1.25frame_0007 it is the frame's.
bool word_says_time(const NameNumber& n) {
  NameNumber alone = n;
  alone.after.clear();
  return names_time(alone);
}

/// A number that is a time by its form, if there is one, and no word says that another is.
std::optional<NamesRead> time_by_form(const std::vector<Column>& columns,
                                      const std::vector<NamedPicture>& pictures) {
  for (const auto& [is, why] : {std::pair{&Column::clock, "a date and time of day"},
                                std::pair{&Column::decimal, "a number with decimals"}}) {
    const Column* found = nullptr;
    std::size_t forms = 0, cameras = 0, timed = 0;
    for (const Column& c : columns) {
      const bool camera = all_of(c, names_camera), form = (c.*is)() && !camera;
      forms += form ? 1 : 0;
      cameras += camera ? 1 : 0;
      timed += !form && all_of(c, names_time) ? 1 : 0;
      if (form) found = &c;
    }
    if (forms != 1 || timed > 0) continue;
    // a camera's folder may be named after the start of its film, a view after its angle; t1.004 may be
    // camera 4
    const bool alone = cameras + 1 == columns.size();
    const double whole = std::floor(found->numbers[0].value);
    const bool many = std::any_of(found->numbers.begin(), found->numbers.end(),
                                  [&](const NameNumber& n) { return std::floor(n.value) != whole; });
    const bool plain = found->clock() && found->numbers[0].digits.find('.') == std::string::npos;
    const bool said = found->clock() || all_of(*found, word_says_time);
    return times_from(*found, pictures, alone && (plain || (many && said)), why);
  }
  return {};
}

NamesRead read_numbers(const std::vector<NamedPicture>& pictures) {
  const Point point = point_in(pictures);
  const bool plain = point == Point::none || point == Point::decimal;
  Table table = table_of(pictures, is_decimal(point));
  if (table.odd_one_out)
    return unclear(example(pictures[*table.odd_one_out]) + " has another form than the other names");
  std::vector<Column>& columns = table.columns;
  if (std::any_of(columns.begin(), columns.end(), [](const Column& c) { return c.mixed(); }))
    return unclear(fmt::format("a number is a date, or has decimals, in some of the names only, as in {}",
                               example(pictures[0])));
  drop_repeats(columns);
  if (columns.empty()) {
    const bool same_names = std::all_of(table.stem_texts.begin(), table.stem_texts.end(),
                                        [&](const std::string& s) { return s == table.stem_texts[0]; });
    if (same_names && std::set(table.folders.begin(), table.folders.end()).size() == pictures.size())
      return one_moment(true, "every folder has one picture, of the same name");
    return unclear(fmt::format("no number counts up in them, such as {}", example(pictures[0])));
  }
  std::vector<Column> moving;
  std::copy_if(columns.begin(), columns.end(), std::back_inserter(moving),
               [&](const Column& c) { return varies_at_one_place(c, pictures); });
  const std::size_t places = places_of(pictures);
  if (moving.size() == 1 && 2 * places <= pictures.size())
    return times_from(moving[0], pictures, places == 1 ? plain : is_shared(moving[0]),
                      "cameras that stand still have several of these numbers");
  if (!moving.empty()) columns = moving;
  std::optional<NamesRead> by_form = time_by_form(columns, pictures);
  NamesRead read = by_form               ? *by_form
                   : columns.size() == 1 ? weigh(columns[0], pictures)
                                         : choose(columns, pictures);
  read.sure &= plain;  // 1.25 and 2.25, 1.50 and 2.50 may be four decimals
  return read;
}

}  // namespace

NamesRead read_names(const std::vector<NamedPicture>& pictures) {
  if (pictures.size() < 2) return one_moment(true, "there is one picture");
  NamesRead read = read_numbers(pictures);
  if (read.verdict != Verdict::times) return read;
  std::map<std::pair<std::size_t, double>, std::size_t> taken;
  for (std::size_t i = 0; i < pictures.size(); ++i)
    if (const auto [at, fresh] = taken.try_emplace({pictures[i].place, read.times[i]}, i);
        !fresh && pictures[at->second].path != pictures[i].path)  // one picture may be listed twice
      return unclear(fmt::format("{} and {} would be of one camera and one moment",
                                 example(pictures[at->second]), example(pictures[i])));
  return read;
}

std::vector<double> times_of_group(const std::vector<NamedPicture>& pictures, int group) {
  const bool decimals = is_decimal(point_in(pictures));
  Column column;
  for (const NamedPicture& p : pictures) {
    NameParts parts = take_apart(p.path, decimals);
    parts.folder.insert(parts.folder.end(), parts.stem.begin(), parts.stem.end());
    const std::ptrdiff_t n = std::ptrdiff_t(parts.folder.size()), at = group > 0 ? group - 1 : n + group;
    if (group == 0 || at < 0 || at >= n)
      fail({in_quotes(p.path), "this name has no such group of digits",
            "--times name:GROUP, from 1 at the left or from -1 at the right", std::to_string(group),
            n == 0 ? "there are none" : "there are " + list_groups(p.path)});
    column.numbers.push_back(parts.folder[std::size_t(at)]);
  }
  if (!pictures.empty() && column.clock()) count_from_first(column.numbers);
  std::vector<double> times;
  for (const NameNumber& n : column.numbers) times.push_back(n.value);
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
