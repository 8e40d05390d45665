// SPDX-License-Identifier: Apache-2.0
#include "data/times/digits.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <optional>

namespace splinevox::data {
namespace {

constexpr std::int64_t kSecond = 1000000000;  // nanoseconds

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }
bool is_hex(char c) { return is_digit(c) || (c >= 'a' && c <= 'f') || (c >= 'A' && c <= 'F'); }
bool is_separator(char c) { return c == '_' || c == '-' || c == '.' || c == ' '; }
char lower(char c) { return c >= 'A' && c <= 'Z' ? char(c + 32) : c; }

bool ends_with_folded(std::string_view text, std::string_view end) {
  return text.size() >= end.size() &&
         std::equal(end.begin(), end.end(), text.end() - std::ptrdiff_t(end.size()),
                    [](char a, char b) { return a == lower(b); });
}

/// The length of an identifier that begins here: a UUID, or at least twelve hexadecimal digits in a row of
/// which two are letters (f1700000000000 is a number behind a word). 0 if there is none.
std::size_t identifier_length(std::string_view text) {
  constexpr std::array<std::size_t, 5> kUuid = {8, 4, 4, 4, 12};
  constexpr std::size_t kShortest = 12;
  const auto run = [&](std::size_t at) {
    std::size_t n = 0;
    while (at + n < text.size() && is_hex(text[at + n])) ++n;
    return n;
  };
  std::size_t at = 0;
  for (std::size_t part = 0; part < kUuid.size(); ++part) {
    if (run(at) != kUuid[part]) break;
    at += kUuid[part];
    if (part + 1 == kUuid.size()) return at;
    if (at >= text.size() || text[at] != '-') break;
    ++at;
  }
  const std::size_t n = run(0);
  const bool digits = std::any_of(text.begin(), text.begin() + std::ptrdiff_t(n), is_digit);
  const bool letters = std::count_if(text.begin(), text.begin() + std::ptrdiff_t(n), is_letter) >= 2;
  const bool ends = n >= text.size() || !is_letter(text[n]);
  return n >= kShortest && digits && letters && ends ? n : 0;
}

/// Whether a group is a unit's number: 1080p, 4k, 2x, 30fps, 35mm.
bool is_unit(std::string_view after) {
  return after == "p" || after == "x" || after == "k" || after == "fps" || after == "mm" || after == "px" ||
         after == "hz" || after == "bit";
}

int digits_at(std::string_view text, std::size_t at, std::size_t count) {
  int value = 0;
  std::from_chars(text.data() + at, text.data() + at + count, value);
  return value;
}

/// Nanoseconds since 1970 of YYYYMMDDHHMMSS and digits of a second behind it, if it is a time at all.
std::optional<std::int64_t> nanoseconds_of(std::string_view digits) {
  if (digits.size() < 14 || digits.size() > 20) return {};
  const int year = digits_at(digits, 0, 4), month = digits_at(digits, 4, 2), day = digits_at(digits, 6, 2),
            hour = digits_at(digits, 8, 2), minute = digits_at(digits, 10, 2),
            second = digits_at(digits, 12, 2);
  const std::chrono::year_month_day date{std::chrono::year(year), std::chrono::month(unsigned(month)),
                                         std::chrono::day(unsigned(day))};
  if (year < 1970 || year > 2100 || !date.ok() || hour > 23 || minute > 59 || second > 59) return {};
  std::int64_t part = 0, unit = kSecond / 10;
  for (const char c : digits.substr(14)) {
    part += unit * (c - '0');
    unit /= 10;
  }
  const std::int64_t days = std::chrono::sys_days(date).time_since_epoch().count();
  return (days * 86400 + hour * 3600 + minute * 60 + second) * kSecond + part;
}

/// The nanoseconds of a whole number of 13, 16 or 19 digits that can be a time since 1970; 0 if it cannot.
std::int64_t since_1970(std::string_view digits) {
  const std::int64_t unit = digits.size() == 13   ? kSecond / 1000
                            : digits.size() == 16 ? kSecond / 1000000
                            : digits.size() == 19 ? 1
                                                  : 0;
  std::int64_t count = 0;
  std::from_chars(digits.data(), digits.data() + digits.size(), count);
  return digits[0] == '0' ? 0 : unit * count;
}

/// A group of digits and where it lies in the text.
struct Span {
  std::size_t begin = 0, end = 0;
};

std::vector<Span> groups_of(std::string_view text) {
  std::vector<Span> groups;
  for (std::size_t at = 0; at < text.size();) {
    const bool starts_word = at == 0 || !(is_letter(text[at - 1]) || is_digit(text[at - 1]));
    if (const std::size_t skip = starts_word ? identifier_length(text.substr(at)) : 0; skip > 0) {
      at += skip;
      continue;
    }
    if (!is_digit(text[at])) {
      ++at;
      continue;
    }
    std::size_t end = at;
    while (end < text.size() && is_digit(text[end])) ++end;
    groups.push_back({at, end});
    at = end;
  }
  return groups;
}

std::string digits_of(std::string_view text, std::size_t begin, std::size_t end) {
  std::string digits;
  for (std::size_t i = begin; i < end; ++i)
    if (is_digit(text[i])) digits += text[i];
  return digits;
}

/// How many groups from `first` on are a date and a time of day together, apart by one character each: a date
/// of one group or three, a time of one or three, then digits of a second. These stand behind a point, or
/// behind what stands between minutes and seconds; elsewhere a camera's number may follow.
std::size_t date_groups(std::string_view text, const std::vector<Span>& groups, std::size_t first) {
  const auto size = [&](std::size_t g) { return g < groups.size() ? groups[g].end - groups[g].begin : 0; };
  const auto gap = [&](std::size_t g) {  // what stands before a group
    return groups[g].begin - groups[g - 1].end == 1 ? text[groups[g].begin - 1] : '\0';
  };
  std::size_t end = first + 1;
  std::size_t of_day = 6;  // digits that are still wanted; milli- or microseconds may follow
  if (size(first) == 4 && size(first + 1) == 2 && size(first + 2) == 2)
    end += 2;
  else if (size(first) >= 14)
    of_day = 0;
  else if (size(first) != 8)
    return 0;
  if (of_day > 0 && (size(end) == of_day || size(end) == of_day + 3 || size(end) == of_day + 6))
    end += 1;
  else if (of_day > 0 && size(end) == 2 && size(end + 1) == 2 && size(end + 2) >= 2)
    end += 3;
  else if (of_day > 0)
    return 0;
  for (std::size_t g = first + 1; g < end; ++g)
    if (gap(g) == '\0') return 0;
  const auto is_time = [&](std::size_t last) {
    return nanoseconds_of(digits_of(text, groups[first].begin, groups[last - 1].end)).has_value();
  };
  if (!is_time(end)) return 0;
  const bool part = end < groups.size() && gap(end) != '\0' &&
                    (gap(end) == '.' || (size(end) >= 3 && size(end - 1) == 2 && gap(end) == gap(end - 1)));
  return part && is_time(end + 1) ? end + 1 - first : end - first;
}

/// The letters that end right before `at`, separators between left out.
std::string word_before(std::string_view text, std::size_t at) {
  while (at > 0 && is_separator(text[at - 1])) --at;
  std::string word;
  for (; at > 0 && is_letter(text[at - 1]); --at) word.insert(word.begin(), lower(text[at - 1]));
  return word;
}

std::string word_after(std::string_view text, std::size_t at) {
  std::string word;
  for (; at < text.size() && is_letter(text[at]); ++at) word += lower(text[at]);
  return word;
}

/// Whether two groups of digits from `g` on have a point between them and may be a decimal: 1.2.3 and
/// 0001.005 are none.
bool is_decimal(std::string_view text, const std::vector<Span>& groups, std::size_t g) {
  const auto point_behind = [&](std::size_t i) {
    return i + 1 < groups.size() && groups[i + 1].begin == groups[i].end + 1 && text[groups[i].end] == '.';
  };
  const bool padded = text[groups[g].begin] == '0' && groups[g].end - groups[g].begin > 1;
  return point_behind(g) && !padded && !point_behind(g + 1) && !(g > 0 && point_behind(g - 1)) &&
         since_1970(text.substr(groups[g + 1].begin, groups[g + 1].end - groups[g + 1].begin)) == 0;
}

void take(std::string_view text, bool decimals, std::vector<NameNumber>& numbers, std::string& rest) {
  const std::vector<Span> groups = groups_of(text);
  std::size_t done = 0;
  for (std::size_t g = 0; g < groups.size();) {
    std::size_t used = 1;
    NameNumber n;
    n.before = word_before(text, groups[g].begin);
    const std::string_view first = text.substr(groups[g].begin, groups[g].end - groups[g].begin);
    if (const std::size_t date = date_groups(text, groups, g); date > 0) {
      used = date;
      n.kind = NameNumber::Kind::clock;
      n.nanoseconds = *nanoseconds_of(digits_of(text, groups[g].begin, groups[g + date - 1].end));
      n.value = double(n.nanoseconds) / kSecond;
    } else if (since_1970(first) > 0) {
      n.kind = NameNumber::Kind::clock;
      n.nanoseconds = since_1970(first);
      n.value = double(n.nanoseconds) / kSecond;
    } else if (decimals && is_decimal(text, groups, g)) {
      used = 2;
      n.kind = NameNumber::Kind::decimal;
      std::from_chars(text.data() + groups[g].begin, text.data() + groups[g + 1].end, n.value);
    } else {
      std::from_chars(first.data(), first.data() + first.size(), n.value);
    }
    const std::size_t end = groups[g + used - 1].end;
    n.digits = std::string(text.substr(groups[g].begin, end - groups[g].begin));
    n.after = word_after(text, end);
    g += used;
    if (is_unit(n.after)) continue;  // stays in the text
    rest += text.substr(done, end - n.digits.size() - done);
    rest += '#';
    done = end;
    numbers.push_back(std::move(n));
  }
  rest += text.substr(done);
}

/// Without the number that a copy of a file gets: "a (1)".
std::string_view without_copy_number(std::string_view stem) {
  if (stem.empty() || stem.back() != ')') return stem;
  std::size_t at = stem.size() - 1;
  while (at > 0 && is_digit(stem[at - 1])) --at;
  return at >= 2 && at < stem.size() - 1 && stem[at - 1] == '(' && stem[at - 2] == ' '
             ? stem.substr(0, at - 2)
             : stem;
}

}  // namespace

void count_from_first(std::vector<NameNumber>& clocks) {
  if (clocks.empty()) return;
  const std::int64_t first = std::min_element(clocks.begin(), clocks.end(), [](const auto& a, const auto& b) {
                               return a.nanoseconds < b.nanoseconds;
                             })->nanoseconds;
  for (NameNumber& n : clocks) n.value = double(n.nanoseconds - first) / kSecond;
}

std::string_view bare_name(std::string_view path) {
  while (path.starts_with("./")) path.remove_prefix(2);
  for (const std::string_view end : {".png", ".jpg", ".jpeg", ".exr", ".tif", ".tiff", ".webp"})
    if (path.size() > end.size() && ends_with_folded(path, end)) {
      path.remove_suffix(end.size());
      break;
    }
  return path;
}

NameParts take_apart(std::string_view path, bool decimals) {
  path = bare_name(path);
  const std::size_t slash = path.find_last_of("/\\");
  NameParts parts;
  if (slash != std::string_view::npos) {
    std::string_view folders = path.substr(0, slash);
    while (true) {  // a word belongs to one folder
      const std::size_t next = folders.find_first_of("/\\");
      take(folders.substr(0, next), decimals, parts.folder, parts.folder_text);
      parts.folder_text += '/';
      if (next == std::string_view::npos) break;
      folders.remove_prefix(next + 1);
    }
    path.remove_prefix(slash + 1);
  }
  take(without_copy_number(path), decimals, parts.stem, parts.stem_text);
  return parts;
}

}  // namespace splinevox::data
