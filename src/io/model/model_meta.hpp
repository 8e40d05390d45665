// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <string>

#include "field/columns.hpp"
#include "io/vdb/vdb_file.hpp"
#include "splinevox/field/model.hpp"

namespace splinevox {

inline constexpr int kModelFormat = 2;       ///< version of model.vdb as training writes it
inline constexpr int kEditedFormat = 3;      ///< the same with a time curve or a basis that only `edit` makes
inline constexpr int kBackgroundFormat = 4;  ///< with a learned background
inline constexpr int kSurroundingsFormat = 5;  ///< with surroundings
/// Readers refuse later ones.
inline constexpr int kNewestFormat = std::max(kSurroundingsFormat, newest_column_format());

/// A metadata table and what to call it in an error message.
struct NamedMeta {
  std::string where;
  const VdbMeta& meta;
};

/// Lattice and row width of a field.
struct FieldShape {
  Lattice lattice;
  int width = 0;
};

/// What is not a voxel value, as entries of the file and of its grids. Floats go through exact_text: no bit
/// is lost.
VdbMeta model_meta(const VoxelModel& model);
VdbMeta radiance_meta(const RadianceField& radiance);
VdbMeta motion_meta(const MotionField& motion);  ///< of its first level
VdbMeta surroundings_meta(const Surroundings& surroundings);

/// The inverses: fill everything but the channels. Throw Error (Fault::input) naming table and entry.
void parse_model_meta(const NamedMeta& in, VoxelModel& model);
FieldShape parse_radiance_meta(const NamedMeta& in, RadianceField& radiance);
FieldShape parse_motion_meta(const NamedMeta& in, MotionField& motion);
FieldShape parse_surroundings_meta(const NamedMeta& in, Surroundings& surroundings);
/// @}

/// The grids of surroundings: places in contracted space, so other programs show them as a cube of 4 units.
std::vector<Column> surroundings_columns();

}  // namespace splinevox
