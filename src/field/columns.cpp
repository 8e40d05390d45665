// SPDX-License-Identifier: Apache-2.0
#include "field/columns.hpp"

#include <algorithm>
#include <utility>

namespace splinevox {
namespace {

constexpr bool in_order() {
  int scalars = 0;
  for (int i = 0; i < int(std::size(kColumns)); ++i) {
    const ColumnFacts& c = kColumns[i];
    if (int(c.kind) != i) return false;
    if (is_scalar(c) && c.slice != kSliceScalars + scalars++) return false;
  }
  return true;
}
static_assert(in_order(), "kinds stand in the table as in the enum, curves of one number as in a slice");

/// "density", "sh3", "light_3". Appends, because g++ 12 sees an overlap in "_" + text that is not there.
Column column(const ColumnFacts& facts, int first, int number) {
  std::string grid = facts.name;
  if (facts.repeat == Repeat::point) grid += '_';
  if (facts.repeat != Repeat::once) grid += std::to_string(number);
  return {facts.kind, std::move(grid), first, facts.width, facts.role, facts.activation};
}

}  // namespace

std::vector<Column> radiance_columns(const RadianceField& radiance) {
  std::vector<Column> columns;
  for (const ColumnFacts& c : kColumns) {
    if (c.of_motion()) continue;
    const int count = c.repeat == Repeat::harmonic ? radiance.sh_count() : 1;
    for (int j = 0; j < count; ++j) columns.push_back(column(c, first_column(c.kind) + j, j));
  }
  return columns;
}

std::vector<Column> motion_columns(const MotionField& motion) {
  std::vector<Column> columns;
  const MotionLayout layout(motion);
  const int stored = motion.stored_points(), skipped = motion.points - stored;
  int in_point = 0, once = layout.rigidity_column;
  for (const ColumnFacts& c : kColumns) {
    if (!c.of_motion() || !(motion.*c.stored)) continue;
    const bool curve = c.repeat == Repeat::point;
    int& place = curve ? in_point : once;
    for (int k = 0; k < (curve ? stored : 1); ++k)
      columns.push_back(column(c, place + (curve ? layout.stride * k : 0), k + skipped));
    place += c.width;
  }
  return columns;
}

std::vector<Column> columns_of(const VoxelModel& model, ColumnKind kind) {
  std::vector<Column> columns;
  if (!facts_of(kind).of_motion())
    columns = radiance_columns(model.radiance);
  else if (!model.motion.levels.empty())
    columns = motion_columns(model.motion);
  std::erase_if(columns, [kind](const Column& c) { return c.kind != kind; });
  return columns;
}

int padded_width(const std::vector<Column>& columns) {
  int width = 0;
  for (const Column& column : columns) width = std::max(width, column.first + column.width);
  return padded_width(width);
}

int MotionField::stride() const { return MotionLayout(*this).stride; }
int MotionField::rigidity_column() const { return MotionLayout(*this).rigidity_column; }
int MotionField::width() const { return MotionLayout(*this).width; }

MotionLayout::MotionLayout(const MotionField& motion)
    : displaces(motion.displaces), rigidity(motion.displaces && motion.rigidity) {
  int once = 0;
  for (const ColumnFacts& c : kColumns) {
    if (!c.of_motion()) continue;
    const bool stored = motion.*c.stored;
    if (is_scalar(c)) scalar[scalar_index(c.kind)] = stored ? stride : -1;
    if (c.repeat == Repeat::point)
      stride += stored ? c.width : 0;
    else
      once += c.width;  // has room in every row
  }
  rigidity_column = stride * motion.stored_points();
  width = padded_width(rigidity_column + once);
}

}  // namespace splinevox
