// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "splinevox/field/model.hpp"

/// The columns of a model's rows, each in one place. Files, the page of `view`, Python, rates, priors and
/// kernels take from here where a column stands and what it is called.
namespace splinevox {

/// What a column holds. In the order of a file's grids, and of the curves of a control point.
enum class ColumnKind { density, color, sh, control, rigidity, light, presence };

/// How often a row has a column.
enum class Repeat {
  once,
  harmonic,  ///< for each coefficient of the view rescale
  point      ///< for each stored control point: a curve
};

inline constexpr const char* kDensityActivation = "softplus";
inline constexpr int kSliceScalars = 4;  ///< where the curves of one number begin in a row of a slice

/// All there is to know of a kind of column, but for how it is learned (train/rates.hpp).
struct ColumnFacts {
  using Switch = bool MotionField::*;

  ColumnKind kind;
  const char* name;   ///< of its grid, before the number if there are several
  const char* array;  ///< of its view in Python
  Repeat repeat;
  int width;               ///< floats: 1, or 3 of a vector
  bool length = false;     ///< its values are lengths in scene units; the others have no unit
  float first = 0;         ///< raw value before training, where configuration and pictures do not say another
  int format = 2;          ///< first version of model.vdb that can have it
  const char* activation;  ///< what makes a value of what is stored
  const char* role;        ///< for people who open the file elsewhere
  const char* about;       ///< for people who look at the array: what follows its shape

  // Of a column of motion only.
  Switch stored = nullptr;            ///< whether a model has it; null: a column of radiance
  int slice = -1;                     ///< its place in a row of a slice (lattice/slice.hpp)
  const char* file_switch = nullptr;  ///< metadata that says whether a file has it
  std::optional<bool> unsaid = {};    ///< what a file without that means; none: there is no such file

  constexpr bool of_motion() const { return stored != nullptr; }
};

inline constexpr ColumnFacts kColumns[] = {
    {.kind = ColumnKind::density,
     .name = "density",
     .array = "density",
     .repeat = Repeat::once,
     .width = 1,
     .activation = kDensityActivation,
     .role = "density before its activation",
     .about = ", raw: density is scale * softplus(raw + shift). A view that may be written, as all of them "
              "are; rows 0 to 511 stand for everything absent. A Renderer made before a change may skip what "
              "was empty then."},
    {.kind = ColumnKind::color,
     .name = "rgb",
     .array = "rgb",
     .repeat = Repeat::once,
     .width = 3,
     .activation = "sigmoid",
     .role = "colour before the sigmoid",
     .about = ", raw: colour is sigmoid(raw). A view."},
    {.kind = ColumnKind::sh,
     .name = "sh",
     .array = "sh",
     .repeat = Repeat::harmonic,
     .width = 1,
     .activation = "linear",
     .role = "spherical-harmonic coefficient of the view rescale",
     .about = " of the view rescale; None without view dependence. A view."},
    {.kind = ColumnKind::control,
     .name = "control",
     .array = "control_points",
     .repeat = Repeat::point,
     .width = 3,
     .length = true,
     .activation = "linear",
     .role = "control point of the displacement to canonical, scene units",
     .about =
         ", scene units; None where nothing moves. A view; a Renderer made before a change may skip what "
         "was zero then.",
     .stored = &MotionField::displaces,
     .slice = 0,
     .file_switch = "displacement_switch",
     .unsaid = true},
    {.kind = ColumnKind::rigidity,
     .name = "rigidity",
     .array = "rigidity",
     .repeat = Repeat::once,
     .width = 1,
     .activation = "sigmoid",
     .role = "rigidity before the sigmoid: 1 moves, 0 is static",
     .about = ", raw: 1 moves and 0 is static after the sigmoid; None if it has none. A view.",
     .stored = &MotionField::rigidity,
     .slice = 3,
     .file_switch = "rigidity_switch"},
    {.kind = ColumnKind::light,
     .name = "light",
     .array = "light",
     .repeat = Repeat::point,
     .width = 1,
     .activation = "2 sigmoid",
     .role = "control point of the light before its gain 2 sigmoid",
     .about = ", raw: the gain is 2 sigmoid; None where the light does not change. A view.",
     .stored = &MotionField::light,
     .slice = kSliceScalars,
     .file_switch = "light_switch"},
    {.kind = ColumnKind::presence,
     .name = "presence",
     .array = "presence",
     .repeat = Repeat::point,
     .width = 1,
     .format = 6,
     .activation = "linear, less its mean over time",
     .role = "control point of what is added to the density before its activation",
     .about = ", raw: what is added to the raw density, less its mean over time; None where matter is always "
              "there. A view.",
     .stored = &MotionField::presence,
     .slice = kSliceScalars + 1,
     .file_switch = "presence_switch",
     .unsaid = false},
};

constexpr const ColumnFacts& facts_of(ColumnKind kind) { return kColumns[int(kind)]; }

/// First column of a kind of radiance: those of one number come one after the other, the harmonics last.
constexpr int first_column(ColumnKind kind) {
  int first = 0;
  for (const ColumnFacts& c : kColumns)
    if (!c.of_motion() && c.kind < kind) first += c.width;
  return first;
}
/// Floats per radiance row for a harmonic order, a whole number of registers.
constexpr int radiance_width(int sh_order) {
  return padded_width(first_column(ColumnKind::sh) + (sh_order + 1) * (sh_order + 1));
}

/// Whether a column is a curve of one number over time, as the light is.
constexpr bool is_scalar(const ColumnFacts& c) { return c.repeat == Repeat::point && c.width == 1; }
/// Kinds of curves, and those of one number among them.
constexpr int count_curves(bool scalars_only) {
  int n = 0;
  for (const ColumnFacts& c : kColumns) n += c.repeat == Repeat::point && (is_scalar(c) || !scalars_only);
  return n;
}
/// Number of such a curve among them.
constexpr int scalar_index(ColumnKind kind) { return facts_of(kind).slice - kSliceScalars; }
inline constexpr int kCurves = count_curves(false), kScalars = count_curves(true);
inline constexpr int kLight = scalar_index(ColumnKind::light), kPresence = scalar_index(ColumnKind::presence);
/// Floats of a row of a slice that have a meaning.
inline constexpr int kSliceUsed = kSliceScalars + kScalars;

/// The widest row that a number of points can lead to, every column stored.
constexpr int widest_motion(int points) {
  int width = 0;
  for (const ColumnFacts& c : kColumns)
    if (c.of_motion()) width += c.repeat == Repeat::point ? points * c.width : c.width;
  return padded_width(width);
}

constexpr int newest_column_format() {
  int format = 0;
  for (const ColumnFacts& c : kColumns) format = c.format > format ? c.format : format;
  return format;
}

/// A column of the rows of one model.
struct Column {
  ColumnKind kind;
  std::string grid;        ///< name of its grid in model.vdb
  int first = 0;           ///< place in the row of its (first) component
  int width = 1;           ///< floats: 1, or 3 of a vector
  std::string role;        ///< see ColumnFacts; so is this
  std::string activation;  ///< and this
};

/// The columns of a row in the order of a file's grids.
std::vector<Column> radiance_columns(const RadianceField& radiance);
std::vector<Column> motion_columns(const MotionField& motion);

/// Those of one kind: none if the model lacks it.
std::vector<Column> columns_of(const VoxelModel& model, ColumnKind kind);

/// Floats per row that these columns need, a whole number of registers.
int padded_width(const std::vector<Column>& columns);

/// Where the columns of motion stand, as plain numbers for kernels. A row has one point after the other, each
/// with all its curves, and then what it has once.
struct MotionLayout {
  bool displaces, rigidity;
  int stride = 0;           ///< floats of a point
  int rigidity_column = 0;  ///< the first after the points
  int width = 0;            ///< floats per row, a whole number of registers
  int scalar[kScalars];     ///< within a point, of each curve of one number; -1: not stored

  explicit MotionLayout(const MotionField& motion);
};

}  // namespace splinevox
