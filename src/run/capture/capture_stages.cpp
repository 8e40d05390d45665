// SPDX-License-Identifier: Apache-2.0
#include "run/capture/capture_stages.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "core/atomic_file.hpp"
#include "data/message_text.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/data/image_io.hpp"

namespace splinevox::run {
namespace {

namespace fs = std::filesystem;

struct CaptureLens {
  const char *name, *colmap;
};
constexpr CaptureLens kLenses[] = {{"pinhole", "SIMPLE_PINHOLE"},
                                   {"radial", "SIMPLE_RADIAL"},
                                   {"opencv", "OPENCV"},
                                   {"fisheye", "OPENCV_FISHEYE"}};

const char* colmap_lens(const std::string& name, bool rig) {
  for (const CaptureLens& lens : kLenses)
    if (name == lens.name) return lens.colmap;
  return rig ? "SIMPLE_RADIAL" : "OPENCV";  // a rig has few pictures for a lens, and each camera its own
}

std::string threads_of(const CaptureOptions& options) {
  return fmt::format("{}", options.threads > 0 ? options.threads : -1);
}

/// The frames that COLMAP is given, by their numbers: all, but of cameras that stand still those of a few
/// moments. These are of the camera with the most frames; others have the nearest to them.
std::vector<std::size_t> frames_for_colmap(const CaptureState& state, const CaptureOptions& options) {
  std::vector<FrameGroup> cameras;  // the frames of each
  for (int i = 0; i < int(state.frames.size()); ++i) {
    const CaptureFrame& frame = state.frames[std::size_t(i)];
    if (i == 0 || frame.camera != state.frames[std::size_t(i - 1)].camera) cameras.emplace_back(i, i);
    cameras.back().second = i + 1;
  }
  const auto times_of = [&](const FrameGroup& camera) {
    std::vector<double> times;
    for (int i = camera.first; i < camera.second; ++i) times.push_back(state.frames[std::size_t(i)].time);
    return times;
  };
  const auto stands_still = [&](const FrameGroup& camera) {
    return state.of_rig() && !state.of_walk(state.frames[std::size_t(camera.first)]);
  };
  FrameGroup most{0, 0};
  for (const FrameGroup& camera : cameras)
    if (stands_still(camera) && camera.second - camera.first > most.second - most.first) most = camera;
  const std::vector<double> all = times_of(most);
  const std::size_t wanted = std::min(all.size(), std::size_t(options.moments));
  std::vector<double> moments;
  for (std::size_t k = 0; k < wanted; ++k) moments.push_back(all[(2 * k + 1) * all.size() / (2 * wanted)]);
  std::vector<std::size_t> chosen;
  for (const FrameGroup& camera : cameras) {
    if (stands_still(camera))
      for (const FrameGroup& at : frames_at(times_of(camera), moments))
        chosen.push_back(std::size_t(camera.first + at.first));
    else
      for (int i = camera.first; i < camera.second; ++i) chosen.push_back(std::size_t(i));
  }
  return chosen;
}

/// Pictures under the names that COLMAP knows, and masks for it, as long as it looks for features.
void number_pictures(const fs::path& folder, const CaptureState& state,
                     const std::vector<std::size_t>& chosen, const fs::path& numbered) {
  const auto put = [](const fs::path& from, const fs::path& to) {
    fs::create_directories(to.parent_path());
    std::error_code no_links;  // in this file system: then the bytes are there twice for a while
    fs::create_hard_link(from, to, no_links);
    if (no_links) fs::copy_file(from, to);
  };
  fs::remove_all(numbered);
  fs::create_directories(numbered / "masks");
  for (const std::size_t i : chosen) {
    const CaptureFrame& frame = state.frames[i];
    put(folder / "images" / frame.name, numbered / "images" / colmap_name(state, i));
    if (!frame.mask.empty())
      put(folder / "work/masks" / (frame.name + ".png"),
          numbered / "masks" / (colmap_name(state, i) + ".png"));
  }
}

/// Whether all pictures have one size, and so may have one lens.
bool one_size(const fs::path& folder, const CaptureState& state) {
  std::set<std::pair<int, int>> sizes;
  for (const CaptureFrame& frame : state.frames) {
    const PictureSize size = read_picture_size(folder / "images" / frame.name);
    sizes.emplace(size.width, size.height);
  }
  return sizes.size() == 1;
}

/// Pictures of the walk with their neighbours, and those of cameras that stand still with all of the walk and
/// with each other: a line a pair.
std::string pairs_with_walk(const CaptureState& state, const CaptureOptions& options) {
  constexpr std::size_t kNear = 8;
  const std::vector<std::size_t> chosen = frames_for_colmap(state, options);
  std::string pairs;
  for (std::size_t i = 0; i < chosen.size(); ++i)
    for (std::size_t k = i + 1; k < chosen.size(); ++k) {
      if (state.of_walk(state.frames[chosen[i]]) && k - i > kNear) continue;
      pairs += colmap_name(state, chosen[i]) + " " + colmap_name(state, chosen[k]) + "\n";
    }
  return pairs;
}

void require_well(bool well, const std::string& what, const ColmapProgram& colmap) {
  if (!well)
    fail({"splinevox capture", "COLMAP could not " + what, "a command that ends well", colmap.last_lines(),
          "the same command goes on from here; --fresh begins anew"});
}

}  // namespace

std::vector<std::string> capture_lenses() {
  std::vector<std::string> names;
  for (const CaptureLens& lens : kLenses) names.emplace_back(lens.name);
  return names;
}

bool needs_numbers(const CaptureState& state) {
  const auto misread = [](const CaptureFrame& frame) {
    return std::any_of(frame.name.begin(), frame.name.end(),
                       [](char c) { return c == '#' || static_cast<unsigned char>(c) <= ' '; });
  };
  const auto before = [](const CaptureFrame& a, const CaptureFrame& b) { return a.name < b.name; };
  return std::any_of(state.frames.begin(), state.frames.end(), misread) ||
         (!state.of_rig() && !std::is_sorted(state.frames.begin(), state.frames.end(), before));
}

std::string colmap_name(const CaptureState& state, std::size_t frame) {
  const CaptureFrame& named = state.frames.at(frame);
  if (!state.numbered) return named.name;
  const std::string folder = state.of_rig() ? fmt::format("{:03}/", named.camera) : "";
  return fmt::format("{}{:06}{}", folder, frame, fs::path(named.name).extension().string());
}

void name_frames(data::ColmapModel& model, const CaptureState& state) {
  if (!state.numbered) return;
  std::map<std::string, std::string> names;
  for (std::size_t i = 0; i < state.frames.size(); ++i)
    names.emplace(colmap_name(state, i), state.frames[i].name);
  for (data::ColmapImage& image : model.images)
    if (const auto at = names.find(image.name); at != names.end()) image.name = at->second;
}

int pictures_for_colmap(const CaptureState& state, const CaptureOptions& options) {
  return int(frames_for_colmap(state, options).size());
}

void find_features(const fs::path& folder, const CaptureState& state, const CaptureOptions& options,
                   ColmapProgram& colmap, CaptureTalk& talk) {
  // Of a call that was stopped here: COLMAP would give the pictures that are left a lens of their own.
  for (const char* name : {"database.db", "database.db-wal", "database.db-shm"})
    fs::remove(folder / "work" / name);
  const std::vector<std::size_t> chosen = frames_for_colmap(state, options);
  std::string list;
  for (const std::size_t i : chosen) list += colmap_name(state, i) + "\n";
  const fs::path file = folder / "work/pictures.txt", numbered = folder / "work/numbered",
                 masks = state.numbered ? numbered / "masks" : folder / "work/masks";
  write_file(file.string(), {list});
  if (state.numbered) number_pictures(folder, state, chosen, numbered);
  std::vector<ColmapOption> words{
      {"database_path", (folder / "work/database.db").string()},
      {"image_path", ((state.numbered ? numbered : folder) / "images").string()},
      {"image_list_path", file.string()},
      {"ImageReader.camera_model", colmap_lens(options.lens, state.of_rig())},
      {"SiftExtraction.use_gpu|FeatureExtraction.use_gpu", "0"},
      {"SiftExtraction.num_threads|FeatureExtraction.num_threads", threads_of(options)}};
  if (state.of_rig() && !state.has_walk()) {  // few pictures, from directions far apart
    words.push_back({"SiftExtraction.estimate_affine_shape", "1"});
    words.push_back({"SiftExtraction.domain_size_pooling", "1"});
  } else {  // the time to match them grows as the square of their number
    words.push_back({"SiftExtraction.max_num_features", "2048"});
  }
  if (state.of_rig())
    words.push_back({"ImageReader.single_camera_per_folder", "1"});
  else if (one_size(folder, state))
    words.push_back({"ImageReader.single_camera", "1"});
  else
    talk.note("pictures differ in size: each gets a lens of its own");
  if (std::any_of(state.frames.begin(), state.frames.end(), [](const auto& f) { return !f.mask.empty(); }))
    words.push_back({"ImageReader.mask_path", masks.string()});
  require_well(colmap.run("feature_extractor", words), "find features", colmap);
  fs::remove_all(numbered);
}

void match_features(const fs::path& folder, const CaptureState& state, const CaptureOptions& options,
                    ColmapProgram& colmap, bool wide) {
  constexpr int kWideFew = 100;
  const int pictures = pictures_for_colmap(state, options);
  std::vector<ColmapOption> words{
      {"database_path", (folder / "work/database.db").string()},
      {"SiftMatching.use_gpu|FeatureMatching.use_gpu", "0"},
      {"SiftMatching.num_threads|FeatureMatching.num_threads", threads_of(options)}};
  std::string command = "exhaustive_matcher";
  if (state.has_walk()) {
    const fs::path pairs = folder / "work/pairs.txt";
    write_file(pairs.string(), {pairs_with_walk(state, options)});
    command = "matches_importer";
    words.push_back({"match_list_path", pairs.string()});
    words.push_back({"match_type", "pairs"});
  } else if (state.of_rig() || pictures <= (wide ? kWideFew : kAllCompared)) {
    words.push_back({"ExhaustiveMatching.block_size", "10"});
  } else {  // the next ones, and those 16, 32, ... on
    command = "sequential_matcher";
    words.push_back({"SequentialMatching.overlap", wide ? "25" : "8"});
  }
  require_well(colmap.run(command, words, pictures), "compare pictures", colmap);
}

void find_cameras(const fs::path& folder, const CaptureState& state, const CaptureOptions& options,
                  ColmapProgram& colmap) {
  const fs::path models = folder / state.models();
  fs::remove_all(models);
  fs::create_directories(models);
  std::vector<ColmapOption> words{{"database_path", (folder / "work/database.db").string()},
                                  {"image_path", (folder / "images").string()},
                                  {"output_path", models.string()},
                                  {"Mapper.num_threads", threads_of(options)},
                                  {"Mapper.extract_colors", "0"},
                                  {"Mapper.min_model_size", "3"},
                                  {"Mapper.init_min_tri_angle", "4"},
                                  {"Mapper.ba_global_function_tolerance", "1e-6"}};
  if (state.straight) words.push_back({"Mapper.ba_refine_extra_params", "0"});
  if (state.of_rig()) {
    words.push_back({"Mapper.init_min_num_inliers", "40"});
    words.push_back({"Mapper.abs_pose_min_num_inliers", "15"});
  }
  // It ends with an error where it finds no model, which is no fault of its own.
  const bool well = colmap.run("mapper", words, pictures_for_colmap(state, options));
  require_well(well || !largest_model(models), "find cameras", colmap);
}

void fail_placing(const CaptureState& state, const std::string& figures) {
  if (state.of_rig())
    fail(
        {"splinevox capture", "COLMAP could not place the cameras",
         "a third of them at least; neighbours that see much of the same, from directions less than about 20 "
         "degrees apart",
         figures,
         state.has_walk()
             ? "a walk that is slower, and nearer to each camera's own view; things with texture around; or "
               "calibrate with a board, and give intri.yml and extri.yml"
             : "--walk FILM, of any camera that walks slowly from one camera to the next and sees what they "
               "see; or --moments 10; things with texture around; or calibrate with a board, and give "
               "intri.yml and extri.yml"});
  fail({"splinevox capture", "COLMAP could not place the pictures",
        "a third of them at least, of a camera that moves past things that stand still", figures,
        "--frames 300 for a film; film again: walk sideways or around, slowly, and do not just turn; keep "
        "most "
        "of the picture still, near and full of texture; lock focus and exposure; masks of what moves "
        "(docs/capture.md)"});
}

CaptureState read_capture_state(const fs::path& folder) {
  CaptureState state;
  const fs::path path = folder / "work/state.json";
  std::error_code ignored;
  if (!fs::exists(path, ignored)) return state;
  const Json json = read_json(path.string());
  try {
    state.request = json.at("request");
    state.done = json.at("done").get<int>();
    state.wide = json.at("wide").get<bool>();
    state.straight = json.value("straight", false);
    state.numbered = json.value("numbered", false);
    state.rig = json.at("rig").get<std::vector<std::string>>();
    state.notes = json.at("notes").get<std::vector<std::string>>();
    state.seconds = json.at("seconds");
    for (const Json& f : json.at("frames"))
      state.frames.push_back({f.at("name").get<std::string>(), f.at("camera").get<int>(),
                              f.at("time").get<double>(), f.at("mask").get<std::string>()});
  } catch (const nlohmann::json::exception& error) {
    fail({data::printable(path.string()), "this is no state of a capture", "what splinevox capture wrote",
          error.what(), "--fresh begins anew"});
  }
  return state;
}

void write_capture_state(const fs::path& folder, const CaptureState& state) {
  Json frames = Json::array();
  for (const CaptureFrame& f : state.frames)
    frames.push_back({{"name", f.name}, {"camera", f.camera}, {"time", f.time}, {"mask", f.mask}});
  const Json json{{"request", state.request},   {"done", state.done},         {"wide", state.wide},
                  {"straight", state.straight}, {"numbered", state.numbered}, {"rig", state.rig},
                  {"notes", state.notes},       {"seconds", state.seconds},   {"frames", frames}};
  write_file((folder / "work/state.json").string(), {json_text(json, 1) + "\n"});
}

fs::path keep_drawn_masks(const fs::path& folder, const std::string& aside) {
  const fs::path masks = folder / aside / "masks";
  if (!fs::is_directory(masks)) return {};
  std::set<fs::path> written;
  try {
    for (const CaptureFrame& frame : read_capture_state(folder / aside).frames)
      if (!frame.mask.empty()) written.insert((folder / aside / frame.mask).lexically_normal());
  } catch (const Error&) {  // a state that cannot be read says of no mask that it is capture's
  }
  const fs::recursive_directory_iterator all(masks);
  const bool drawn = std::any_of(begin(all), end(all), [&](const fs::directory_entry& entry) {
    return entry.is_regular_file() && !written.contains(entry.path().lexically_normal());
  });
  if (!drawn) return {};
  fs::path kept = folder / "earlier_masks";
  for (int i = 2; fs::exists(kept); ++i) kept = folder / fmt::format("earlier_masks_{}", i);
  fs::rename(masks, kept);
  return kept;
}

}  // namespace splinevox::run
