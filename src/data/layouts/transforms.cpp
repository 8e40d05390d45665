// SPDX-License-Identifier: Apache-2.0
#include "data/layouts/transforms.hpp"

#include <algorithm>
#include <cmath>

#include "data/json_file.hpp"
#include "data/layouts/axes.hpp"
#include "data/layouts/folder_list.hpp"
#include "data/layouts/near_miss.hpp"
#include "data/message_text.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::data {

using nlohmann::json;

std::string shown(const json& value) {
  if (value.is_number()) return number(value.get<double>());
  if (value.is_string()) return "the text " + in_quotes(value.get_ref<const std::string&>());
  if (value.is_array()) return "an array of " + std::to_string(value.size());
  return value.is_object() ? "an object" : value.is_null() ? "null" : "true or false";
}

std::optional<double> number_field(const json& object, const char* field, const std::string& where) {
  const auto found = object.find(field);
  if (found == object.end()) return {};
  if (!found->is_number())
    fail({where, std::string("'") + field + "' is not a number", "a finite number", shown(*found), ""});
  return found->get<double>();
}

std::vector<double> matrix_numbers(const json& value, std::size_t rows, std::size_t columns,
                                   const std::string& name, const std::string& where) {
  const std::string shape = std::to_string(rows) + " rows of " + std::to_string(columns) + " finite numbers";
  if (!value.is_array() || value.size() != rows)
    fail({where, name + " has the wrong shape", shape, shown(value), ""});
  std::vector<double> numbers;
  for (const json& row : value) {
    if (!row.is_array() || row.size() != columns)
      fail({where, name + " has a row of the wrong shape", shape, shown(row), ""});
    for (const json& element : row) {
      if (!element.is_number())
        fail({where, name + " holds something else than numbers", shape, shown(element), ""});
      numbers.push_back(element.get<double>());
    }
  }
  return numbers;
}

const json& needed_field(const json& object, const char* field, const std::string& expected,
                         const std::string& where) {
  if (!object.is_object()) fail({where, "this is no object with fields", expected, shown(object), ""});
  const auto found = object.find(field);
  if (found == object.end())
    fail({where, std::string("'") + field + "' is missing", expected, "no such field", ""});
  return *found;
}

namespace {

/// What to say of a field that is missing: that it is, and what may be meant for it.
std::string no_field(const UnreadFields& unread, const std::vector<std::string>& wanted) {
  const std::string meant = unread.meant_for(wanted);
  return meant.empty() ? "no such field" : "no such field, but " + meant;
}

std::string read_file_path(const json& frame, const std::string& where, const UnreadFields& unread) {
  const auto found = frame.find("file_path");
  if (found == frame.end())
    fail({where, "'file_path' is missing", "the picture's path within the folder",
          no_field(unread, {"file_path"}), ""});
  if (!found->is_string() || found->get_ref<const std::string&>().empty())
    fail({where, "'file_path' is not a path", "the picture's path within the folder", shown(*found), ""});
  return found->get<std::string>();
}

}  // namespace

std::array<double, 16> read_matrix(const json& frame, const std::string& where, const UnreadFields& unread) {
  const auto found = frame.find("transform_matrix");
  if (found == frame.end())
    fail({where, "'transform_matrix' is missing", "4 rows of 4 numbers",
          no_field(unread, {"transform_matrix"}), ""});
  if (!found->is_array() || (found->size() != 4 && found->size() != 3))
    fail({where, "'transform_matrix' has the wrong shape", "4 rows of 4 numbers, or 3 without 0 0 0 1",
          shown(*found), ""});
  std::array<double, 16> m{};
  m[15] = 1;
  for (std::size_t row = 0; row < found->size(); ++row) {
    const json& values = (*found)[row];
    const std::string name = "'transform_matrix' row " + std::to_string(row);
    if (!values.is_array() || values.size() != 4)
      fail({where, name + " has the wrong shape", "4 numbers", shown(values), ""});
    for (std::size_t col = 0; col < 4; ++col) {
      if (!values[col].is_number())
        fail({where, name + ", column " + std::to_string(col) + " is not a number", "a finite number",
              shown(values[col]), ""});
      m[4 * row + col] = values[col].get<double>();
    }
  }
  return m;
}

const json& frames_of(const json& file, const std::string& where) {
  if (!file.is_object())
    fail({where, "this is not a transforms file", "an object with 'frames'", shown(file), ""});
  const auto frames = file.find("frames");
  if (frames == file.end()) {
    std::string got = "no such field";
    for (const auto& [name, value] : file.items())
      if (edits(lower_case(name), "frames") <= 1)
        got += ", but " + in_quotes(name) + ", which may be meant for it";
    fail({where, "'frames' is missing", "an array of frames", got, ""});
  }
  if (!frames->is_array())
    fail({where, "'frames' is not an array", "an array of frames", shown(*frames), ""});
  if (frames->empty()) fail({where, "the split is empty", "at least one frame", "'frames' with none", ""});
  return *frames;
}

void read_times(const json& frames, const char* field, RawSplit& split) {
  const std::string name = std::string("'") + field + "'";
  std::size_t timed = 0;
  for (const json& frame : frames) timed += frame.contains(field) ? 1 : 0;
  split.timed = timed > 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const auto time = number_field(frames[i], field, split.where(i));
    if (split.timed && !time)
      fail({split.where(i), name + " is missing", "a finite number, as other frames have",
            std::to_string(timed) + " of " + std::to_string(frames.size()) + " frames with " + name,
            "give every frame a time, or none"});
    if (time && !(std::abs(*time) <= 1e12))
      fail({split.where(i), name + " is not finite or too large", "at most 1e12", number(*time), ""});
    split.frames[i].time = time.value_or(0);
  }
}

namespace {

bool inside(const std::filesystem::path& root, const std::filesystem::path& path) {
  const std::filesystem::path relative = path.lexically_relative(root);
  return !relative.empty() && *relative.begin() != ".." && relative != ".";
}

/// Scene units of one of the numbers in depth maps, where the file says that.
std::optional<double> read_depth_unit(const json& file, const std::string& where) {
  const auto unit = number_field(file, "depth_unit_scale_factor", where);
  if (unit && !(*unit > 0 && *unit < 1e12))
    fail({where, "'depth_unit_scale_factor' is out of range", "a number above 0: scene units of one number",
          number(*unit), ""});
  return unit;
}

}  // namespace

std::string transforms_name(const std::string& split) { return "transforms_" + split + ".json"; }

RawSplit read_frames(const json& file, const std::string& where, const std::string& time) {
  RawSplit split{"train", where, true, {}};
  const json& frames = frames_of(file, split.file);
  if (const std::string matrix = lens_matrix_field(file); file.contains("fl_x") && !matrix.empty())
    split.notes.push_back(where + ": '" + matrix + "' is not read, because there is 'fl_x'");
  UnreadFields unread(time);
  unread.look_at(file);
  for (const json& frame : frames) unread.look_at(frame);
  const Lens shared = read_lens(file, split.file);
  const std::optional<double> depth_unit = read_depth_unit(file, split.file);
  if (const auto tracks = file.find("tracks_file_path"); tracks != file.end()) {
    if (!tracks->is_string())
      fail({split.file, "'tracks_file_path' is not a path",
            "the path of a .npy or .npz file within the folder", shown(*tracks), ""});
    split.tracks = tracks->get<std::string>();
  }
  std::vector<std::array<double, 16>> matrices;
  for (const json& frame : frames) {
    const std::string at = split.where(split.frames.size());
    if (!frame.is_object()) fail({at, "this is not a frame", "an object", shown(frame), ""});
    RawFrame raw;
    raw.file_path = read_file_path(frame, at, unread);
    matrices.push_back(read_matrix(frame, at, unread));
    raw.lens = merge(shared, read_lens(frame, at));
    if (const auto mask = frame.find("mask_path"); mask != frame.end() && mask->is_string())
      raw.mask = mask->get<std::string>();
    if (const auto depth = frame.find("depth_file_path"); depth != frame.end() && depth->is_string()) {
      raw.depth = depth->get<std::string>();
      raw.depth_unit = depth_unit;
    }
    if (const auto id = frame.find("camera_id"); id != frame.end() && (id->is_string() || id->is_number()))
      raw.camera = id->is_string() ? id->get<std::string>() : id->dump();
    const std::string meant = unread.meant_for({"fl_x", "camera_angle_x", "K"});
    if (!raw.lens.fl_x && !raw.lens.camera_angle_x && !meant.empty())
      fail({at, "there is no focal length", "'camera_angle_x' (radians) or 'fl_x' (pixels)", meant,
            "give the field its right name"});
    split.frames.push_back(std::move(raw));
  }
  if (const std::string note = take_last_rows(matrices); !note.empty())
    split.notes.push_back(where + ": " + note);
  for (std::size_t i = 0; i < matrices.size(); ++i) set_pose(split.frames[i], matrices[i], split.where(i));
  for (std::string& note : unread.notes(where)) split.notes.push_back(std::move(note));
  return split;
}

RawSplit read_transforms(const std::filesystem::path& folder, const std::string& file_of,
                         const std::string& name, std::optional<Box>* box) {
  const std::filesystem::path path = folder / transforms_name(file_of);
  const std::string where = printable(path.string());
  const json file = read_json(path, where);
  RawSplit split = read_frames(file, where);
  split.name = name;
  read_times(frames_of(file, where), "time", split);
  if (box) *box = read_scene_box(file, where);
  return split;
}

std::optional<Box> read_scene_box(const json& file, const std::string& where) {
  const auto found = file.is_object() ? file.find("scene_box") : file.end();
  if (found == file.end()) return {};
  Box box;
  bool good = found->is_array() && found->size() == 2;
  for (int corner = 0; good && corner < 2; ++corner) {
    const json& values = (*found)[std::size_t(corner)];
    good = values.is_array() && values.size() == 3;
    for (int axis = 0; good && axis < 3; ++axis) {
      good = values[std::size_t(axis)].is_number();
      if (good) (corner == 0 ? box.lo : box.hi)[axis] = values[std::size_t(axis)].get<float>();
    }
  }
  for (int axis = 0; good && axis < 3; ++axis)
    good = box.lo[axis] < box.hi[axis] && std::abs(box.lo[axis]) < 1e12f && std::abs(box.hi[axis]) < 1e12f;
  if (!good)
    fail({where, "'scene_box' is no box", "[[x, y, z], [x, y, z]], the lower corner first", shown(*found),
          ""});
  return box;
}

std::optional<std::filesystem::path> find_image(const std::filesystem::path& root,
                                                const std::string& file_path, const std::string& where) {
  namespace fs = std::filesystem;
  if (file_path.find('\0') != std::string::npos)
    fail({where, "'file_path' holds a zero byte", "the picture's path within the folder",
          in_quotes(file_path), ""});
  std::vector<std::string> candidates{file_path};
  if (kind_of(file_path) != FileKind::picture)  // NAME.png.png would be a mask
    for (const char* ending :
         {".png", ".jpg", ".jpeg", ".PNG", ".JPG", ".JPEG", ".exr", ".tif", ".tiff", ".TIF", ".TIFF"})
      candidates.push_back(file_path + ending);
  for (const std::string& candidate : candidates) {
    std::error_code error;
    const fs::path path = fs::weakly_canonical(root / candidate, error);
    if (error)
      fail({where, "'file_path' cannot be looked up", "the picture's path within the folder",
            in_quotes(candidate) + ": " + error.message(), ""});
    if (!inside(root, path))
      fail({where, "'file_path' leads out of the data set's folder", "a path inside it, links resolved",
            in_quotes(file_path), "copy the picture into the folder"});
    if (fs::is_regular_file(path, error)) return path;
  }
  return {};
}

Error image_missing(const std::filesystem::path& root, const std::string& file_path,
                    const std::string& where) {
  for (const char* ending : {".png", ".PNG", ".jpg", ".JPG", ".jpeg", ".JPEG", ".exr", ".EXR", ".hdr", ".tif",
                             ".TIF", ".tiff", ".TIFF", ".webp", ".bmp", ".heic", ".HEIC"}) {
    std::filesystem::path other(file_path);
    if (kind_of(other) == FileKind::picture)
      other.replace_extension(ending);
    else
      other += ending;
    std::error_code ignored;
    if (inside(root, std::filesystem::weakly_canonical(root / other, ignored)) &&
        std::filesystem::is_regular_file(root / other, ignored)) {
      if (kind_of(other) == FileKind::picture)
        return Error(
            {where, "the picture has another ending", in_quotes(file_path), in_quotes(other.string()),
             "write " + in_quotes(other.string()) + " as its 'file_path'"},
            Fault::input);
      return Error({where, "the picture is of a kind that is not read", "PNG or JPEG",
                    in_quotes(other.string()), how_to_convert(other)},
                   Fault::input);
    }
  }
  return Error({where, "the image is missing", in_quotes(file_path) + ", also with .png, .jpg or .jpeg added",
                "no such file", "check 'file_path' and that the pictures were copied"},
               Fault::input);
}

}  // namespace splinevox::data
