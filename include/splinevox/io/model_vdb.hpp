// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>

#include "splinevox/core/file_digest.hpp"
#include "splinevox/field/model.hpp"

namespace splinevox {

/// Anything a caller wants to keep with a model, e.g. {"dataset", "lego"}. Any bytes, at most 16 MiB each.
using ModelNotes = std::map<std::string, std::string>;

/// Writes a model as named OpenVDB grids that any VDB program opens:
///
///     density                 float   raw; sigma = scale * softplus(raw + shift), see the grid's metadata
///     rgb                     Vec3s   raw; colour = sigmoid(raw)
///     sh0, sh1, ...           float   coefficients of the view rescale 1 - sigmoid(sum_j sh_j Y_j(d)) / 2
///     control_0, control_1, ...  Vec3s   scene units; control_0 only where it is not pinned to zero
///     rigidity                float   raw; r = sigmoid(raw + offset): 1 moves, 0 is static
///
/// What the model lacks is absent from the file. Voxel ijk sits at its vertex' position. Raw parameters are
/// stored because activation comes after interpolation; with half = false a reloaded model renders the same
/// bits. Throws Error (Fault::output) if it cannot be written; an older file then stays.
/// @pre at most one motion level: Trainer::model() and collapse() give that. Columns past the ones listed are
/// padding.
FileDigest save_model(const std::string& path, const VoxelModel& model, const ModelNotes& notes = {},
                      bool half = false);

/// Reads what save_model wrote. Throws Error (Fault::input) naming file, grid and entry otherwise.
VoxelModel load_model(const std::string& path, ModelNotes* notes = nullptr);

}  // namespace splinevox
