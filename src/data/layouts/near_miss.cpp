// SPDX-License-Identifier: Apache-2.0
#include "data/layouts/near_miss.hpp"

#include <algorithm>
#include <iterator>

#include "data/layouts/folder_list.hpp"
#include "data/layouts/transforms.hpp"
#include "data/message_text.hpp"

namespace splinevox::data {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Fields of transforms files that are read, beside kLensMatrixFields.
constexpr const char* kRead[] = {"file_path",
                                 "transform_matrix",
                                 "scene_box",
                                 "depth_file_path",
                                 "depth_unit_scale_factor",
                                 "tracks_file_path",
                                 "camera_model",
                                 "is_fisheye",
                                 "camera_angle_x",
                                 "camera_angle_y",
                                 "fl_x",
                                 "fl_y",
                                 "cx",
                                 "cy",
                                 "w",
                                 "h",
                                 "k1",
                                 "k2",
                                 "k3",
                                 "k4",
                                 "p1",
                                 "p2",
                                 "train_filenames",
                                 "val_filenames",
                                 "test_filenames"};

/// Fields that would change the camera and are not read, and what to give in their place.
struct Unread {
  const char *name, *advice;
};
constexpr const char* kGiveK = "give k1, k2, p1, p2 and k3, each a field of its own";
constexpr const char* kUndistort = "undistort the pictures first";
constexpr const char* kCallTime = "call it 'time', or 'timestep' in NeRFlow's files, if it is the time";
constexpr Unread kUnread[] = {
    {"timestep", "call it 'time', if it is the time"},
    {"time", "call it 'timestep', if it is the time"},
    {"timestamp", kCallTime},
    {"time_stamp", kCallTime},
    {"frame_time", kCallTime},
    {"t", kCallTime},
    {"distortion", kGiveK},
    {"distortions", kGiveK},
    {"distortion_params", kGiveK},
    {"distortion_coefficients", kGiveK},
    {"dist_coeffs", kGiveK},
    {"dist", kGiveK},
    {"k5", kUndistort},
    {"k6", kUndistort},
    {"skew", kUndistort},
    {"b1", kUndistort},
    {"b2", kUndistort},
    {"fisheye_crop_radius", "what lies outside its circle is trained: mask it (--masks ignore)"},
    {"rolling_shutter", "rows are taken to be of one moment"},
    {"white_transparent", "white is taken as white: make it alpha"},
    {"depth_path", "call it 'depth_file_path', and its unit 'depth_unit_scale_factor'"}};

/// Without what people write in different ways: case, underscores and hyphens.
std::string folded_name(std::string_view text) {
  std::string name = lower_case(text);
  std::erase_if(name, [](char c) { return c == '_' || c == '-' || c == ' '; });
  return name;
}

/// All fields of transforms files that are read.
const std::vector<std::string>& known_fields() {
  static const std::vector<std::string> fields = [] {
    std::vector<std::string> all(std::begin(kRead), std::end(kRead));
    all.insert(all.end(), std::begin(kLensMatrixFields), std::end(kLensMatrixFields));
    return all;
  }();
  return fields;
}

/// The known field that a name may be meant for; empty if the name is known, or none is near.
std::string meant_field(const std::string& name) {
  constexpr std::size_t kShortest = 4;  // of shorter names every other is one letter off
  std::string near;
  for (const std::string& known : known_fields()) {
    if (name == known) return {};
    if (folded_name(name) == folded_name(known) ||
        (std::min(name.size(), known.size()) >= kShortest && edits(name, known) == 1))
      near = known;
  }
  return near;
}

/// Whether a value says something: no zero, no array of zeros, not false.
bool says_something(const json& value) {
  if (value.is_number()) return value.get<double>() != 0;
  if (value.is_boolean()) return value.get<bool>();
  if (value.is_array()) return std::any_of(value.begin(), value.end(), says_something);
  return !value.is_null();
}

bool holds(const fs::path& folder, const char* name) {
  std::error_code ignored;
  return fs::exists(folder / name, ignored);
}

bool looks_known(const fs::path& folder) {
  for (const char* name : {"transforms_train.json", "transforms.json", "transform_train.json",
                           "poses_bounds.npy", "precomputed.json", "dataset.json", "train_meta.json",
                           "intri.yml", "sparse", "colmap_sparse", "cameras.bin", "cameras.txt"})
    if (holds(folder, name)) return true;
  return false;
}

/// The file's name that one of the folder's is nearly; empty if none is near.
std::string meant_file(const std::string& name) {
  const std::string ending = lower_case(fs::path(name).extension().string());
  if (ending == ".json" || ending == ".npy" || ending == ".yml" || ending == ".yaml")
    for (const std::string known : {"transforms.json", "transforms_train.json", "transforms_val.json",
                                    "transforms_test.json", "poses_bounds.npy", "precomputed.json",
                                    "dataset.json", "train_meta.json", "intri.yml", "extri.yml"}) {
      const std::string a = folded_name(name), b = folded_name(known);
      if (a == b || edits(a, b) <= 2) return known;
    }
  return lower_case(name).starts_with("poses_bounds") ? "poses_bounds.npy" : "";
}

bool has_cameras(const fs::path& folder) {
  for (const char* inside : {"sparse/0", "sparse", "."})
    for (const char* name : {"cameras.bin", "cameras.txt"})
      if (holds(folder / inside, name)) return true;
  return false;
}

/// Of a folder that holds films or pictures, in it or in its folders; empty: neither.
std::string bare_hint(const fs::path& folder, const std::vector<std::string>& folders) {
  if (!files_in(folder, FileKind::film).empty())
    return "these are films without cameras: " + how_to_capture(folder);
  for (const std::string& name : folders)
    if (const std::string low = lower_case(name); low == "pose" || low == "poses")
      for (const std::string& file : files_in(folder / name))
        if (fs::path(file).extension() == ".txt")
          return "pictures with a text file of a pose each (ScanNet) are not read: put the matrices into "
                 "transforms.json (docs/data.md); OpenCV's axes take their second and third column negated";
  bool pictures = !files_in(folder, FileKind::picture).empty();
  for (const std::string& name : folders) {
    pictures |= !files_in(folder / name, FileKind::picture).empty();
    if (!pictures && !files_in(folder / name, FileKind::film).empty())
      return "there are films without cameras in it: " + how_to_capture(folder / name);
  }
  return pictures ? "these are pictures without cameras: " + how_to_capture(folder) : "";
}

/// Of files that are nearly a data set; empty: none are.
std::string hint_for(const fs::path& folder, const std::vector<std::string>& files,
                     const std::vector<std::string>& folders) {
  for (const std::string& name : files)
    if (const std::string meant = meant_file(name); !meant.empty() && meant != name)
      return in_quotes(name) + " looks like " + meant + ": rename it";
  for (const std::string& name : folders)
    if (looks_known(folder / name)) return "give the folder in it: " + printable((folder / name).string());
  if (holds(folder, "config.toml") && holds(folder, "model.vdb"))
    return "this is a run: its data set is named in " + printable((folder / "config.toml").string()) +
           ", and splinevox train DATASET --out RUN --resume goes on with it";
  if (has_cameras(folder))
    return "the COLMAP model has cameras and no images file: copy it again, as a whole";
  for (const std::string& name : files)
    if (const std::string end = lower_case(fs::path(name).extension().string());
        end == ".zip" || end == ".tar" || end == ".gz" || end == ".7z" || end == ".xz")
      return "unpack " + in_quotes(name) + " first";
  for (const std::string& name : files)
    if (lower_case(fs::path(name).extension().string()) == ".db")
      return "COLMAP's database has no cameras' places yet: let COLMAP reconstruct into sparse/0";
  return {};
}

}  // namespace

std::size_t edits(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before, last(b.size() + 1), now(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) last[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    now[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      now[j] = std::min({last[j] + 1, now[j - 1] + 1, last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        now[j] = std::min(now[j], before[j - 2] + 1);
    }
    before = last;
    last = now;
  }
  return last[b.size()];
}

void UnreadFields::look_at(const json& object) {
  if (!object.is_object()) return;
  constexpr std::size_t kMost = 64;  // different names; a file may have any number
  for (const auto& [name, value] : object.items()) {
    if (name == time_) continue;
    auto field = std::find_if(fields_.begin(), fields_.end(),
                              [&, &key = name](const Field& f) { return f.name == key; });
    if (field == fields_.end()) {
      if (fields_.size() >= kMost) continue;
      fields_.push_back({name, name.size() < 40 ? meant_field(name) : "", ""});
      field = fields_.end() - 1;
    }
    for (const Unread& unread : kUnread)
      if (name == unread.name && says_something(value)) field->advice = unread.advice;
    ++field->count;
  }
}

std::string UnreadFields::meant_for(const std::vector<std::string>& wanted) const {
  for (const Field& field : fields_)
    if (std::find(wanted.begin(), wanted.end(), field.meant) != wanted.end())
      return in_quotes(field.name) + ", which may be meant for '" + field.meant + "'";
  return {};
}

std::vector<std::string> UnreadFields::notes(const std::string& where) const {
  std::vector<std::string> notes;
  for (const Field& field : fields_) {
    if (!field.meant.empty())
      notes.push_back(where + ": " + in_quotes(field.name) + " is not read; '" + field.meant +
                      "' may be meant");
    else if (!field.advice.empty())
      notes.push_back(where + ": " + in_quotes(field.name) + " is not read: " + field.advice);
  }
  return notes;
}

std::string how_to_capture(const fs::path& source) {
  return "splinevox capture " + printable(source.string()) +
         " --out NEW finds them with COLMAP (docs/capture.md)";
}

NearMiss near_miss(const fs::path& folder) {
  const std::vector<std::string> files = files_in(folder), folders = folders_in(folder);
  std::vector<std::string> all = folders;
  for (std::string& name : all) name += '/';
  all.insert(all.end(), files.begin(), files.end());
  if (const std::string hint = hint_for(folder, files, folders); !hint.empty()) return {list_of(all), hint};
  if (const std::string hint = bare_hint(folder, folders); !hint.empty()) return {list_of(all), hint, true};
  return {list_of(all), "give the folder that holds them"};
}

}  // namespace splinevox::data
