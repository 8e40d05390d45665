// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "data/layouts/raw_scene.hpp"

namespace splinevox::data {

class UnreadFields;

/// The name of a split's file within the folder: "transforms_train.json".
std::string transforms_name(const std::string& split);

/// Reads and checks one split of a NeRF / D-NeRF folder. Throws Error (Fault::input).
/// @param folder   as the user gave it; messages begin with it.
/// @param file_of  the split that the file is named after. @param name  the split it serves as.
/// @param box      takes the file's scene_box, if it has one
RawSplit read_transforms(const std::filesystem::path& folder, const std::string& file_of,
                         const std::string& name, std::optional<Box>* box = nullptr);

/// The box that a transforms file may give as 'scene_box': [[lo x, y, z], [hi x, y, z]]. Throws Error
/// (Fault::input).
std::optional<Box> read_scene_box(const nlohmann::json& file, const std::string& where);

/// What the transforms files of all programs have in common, for their readers. All throw Error
/// (Fault::input).
/// @{
std::string shown(const nlohmann::json& value);  ///< a short description for "got"
std::optional<double> number_field(const nlohmann::json& object, const char* field, const std::string& where);
/// The numbers of a matrix, row by row. @param name  how messages call it, as "'k'"
std::vector<double> matrix_numbers(const nlohmann::json& value, std::size_t rows, std::size_t columns,
                                   const std::string& name, const std::string& where);
/// A field that must be there.
const nlohmann::json& needed_field(const nlohmann::json& object, const char* field,
                                   const std::string& expected, const std::string& where);
/// The lens of a file or a frame, from fields of its own or a matrix in "K", "intrinsics" ... of numbers in
/// pixels.
Lens read_lens(const nlohmann::json& object, const std::string& where);
/// Fields that may hold such a matrix: the first that is there counts.
inline constexpr const char* kLensMatrixFields[] = {"K",         "intrinsics",       "camera_intrinsics",
                                                    "intrinsic", "intrinsic_matrix", "camera_matrix"};
/// The one of them with such a matrix; empty if there is none. It is read where there is no fl_x.
std::string lens_matrix_field(const nlohmann::json& object);
const nlohmann::json& frames_of(const nlohmann::json& file, const std::string& where);
/// The 'transform_matrix' of a frame, row by row. Where it has three rows the fourth is 0 0 0 1. Any other
/// fourth row is kept: take_last_rows (axes.hpp) needs those of all frames.
/// @param unread  of the file and its frames: tells what may be meant for a matrix that is missing
std::array<double, 16> read_matrix(const nlohmann::json& frame, const std::string& where,
                                   const UnreadFields& unread);
/// Fills in the times: all frames have one, or none has and the split is not timed.
void read_times(const nlohmann::json& frames, const char* field, RawSplit& split);
/// All frames of a file but their times: matrices are camera to world, OpenGL axes.
RawSplit read_frames(const nlohmann::json& file, const std::string& where, const std::string& time = "time");
/// @}

/// The picture a frame names: file_path itself, or, if it has no such ending, with .png, .jpg or .jpeg added.
/// Must lie in the folder, links resolved, and must not be a device or pipe.
/// @param root  the folder in canonical form. @return an absolute path; empty if there is no such picture.
/// Throws Error (Fault::input).
std::optional<std::filesystem::path> find_image(const std::filesystem::path& root,
                                                const std::string& file_path, const std::string& where);
/// What to say of a picture that find_image does not find: whether it is there as EXR, TIFF ...
Error image_missing(const std::filesystem::path& root, const std::string& file_path,
                    const std::string& where);

/// Paths that another machine wrote (backslashes, drive letters, from the root on): where the same number of
/// leading folders left out makes those of pictures paths within the folder, they become these, and so do
/// those of masks, depth maps and tracks. Absolute paths into the folder become those within it, without a
/// note. @return a note; empty if nothing else was changed.
std::string take_foreign_paths(const std::filesystem::path& root, std::vector<RawSplit>& splits);

}  // namespace splinevox::data
