// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "data/times/digits.hpp"
#include "data/times/names.hpp"

namespace splinevox::data {

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
  /// Whether all are of the hour after midnight, as a date with a count of six digits behind it is.
  bool after_midnight() const {
    constexpr std::int64_t kHour = 3600'000'000'000, kDay = 24 * kHour;
    return clock() && std::all_of(numbers.begin(), numbers.end(),
                                  [](const NameNumber& n) { return n.nanoseconds % kDay < kHour; });
  }
  bool mixed() const { return !kind_is(numbers[0].kind); }

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

/// @param decimals  whether two groups with a point between them are one number.
Table table_of(const std::vector<NamedPicture>& pictures, bool decimals);

/// What the words beside a number say. A photograph's are those that cameras give to pictures one after the
/// other.
/// @{
bool names_camera(const NameNumber& n);
bool names_time(const NameNumber& n);
bool names_photograph(const NameNumber& n);
inline bool all_of(const Column& column, bool (*is)(const NameNumber&)) {
  return std::all_of(column.numbers.begin(), column.numbers.end(), is);
}
/// @}

/// Of columns that count the same thing the one that tells most: a clock, decimals, else the last.
void drop_repeats(std::vector<Column>& columns);

/// Whether at least half of the pictures have another's number, as moments have that several cameras see.
/// Where none has, the number may count pictures.
bool is_shared(const Column& column);

/// What a point between two groups of digits is.
enum class Point {
  none,     ///< there is none
  decimal,  ///< a decimal point
  maybe,    ///< taken as one
  between   ///< it stands between two numbers
};

/// The groups are a camera and a frame, or a constant and a count, if every whole number has every part,
/// unless all count up evenly, or if the parts are written without zeros in front and behind a constant of
/// two digits or more (kinect42.7, kinect42.11).
Point point_in(const std::vector<NamedPicture>& pictures);
/// Whether the groups on both sides of it are one number.
inline bool is_decimal(Point point) { return point == Point::decimal || point == Point::maybe; }

}  // namespace splinevox::data
