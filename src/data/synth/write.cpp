// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <set>

#include "core/atomic_file.hpp"
#include "core/json_text.hpp"
#include "core/parallel.hpp"
#include "core/rng.hpp"
#include "data/fingerprint.hpp"
#include "data/layouts/npy_file.hpp"
#include "data/synth/view.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/data/image_io.hpp"

namespace splinevox {
namespace {

namespace fs = std::filesystem;
using data::SynthShot;

/// Runs make(i) for every shot on all threads and reports each as it is done, one at a time.
template <class Make>
void for_each_shot(std::size_t count, const SynthProgress& progress, const Make& make) {
  std::mutex mutex;
  int done = 0;
  parallel_for(int(count), [&](int i) {
    make(std::size_t(i));
    if (!progress) return;
    const std::lock_guard lock(mutex);
    progress(++done, int(count));
  });
}

Image16 image16(const Image& image) {
  Image16 out{image.width, image.height, {}};
  out.rgba.reserve(image.data.size());
  for (float v : image.data) out.rgba.push_back(std::uint16_t(257 * std::lround(v * 255.0f)));
  return out;
}

void make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (!error && fs::is_directory(folder)) return;
  fail_output({.where = folder.string(),
               .what = "the folder cannot be created",
               .expected = "a folder that can be written",
               .got = error ? error.message() : "a file of that name",
               .hint = "choose another place with --out"});
}

data::Drawn picture_of(const SynthScene& world, const SynthShot& shot, const SynthOptions& options) {
  const SynthMoment moment = world.at(shot.time + shot.late);
  return data::draw(moment, shot.camera, options.look.opaque, shot.gain,
                    options.rig.movers ? data::moving_mask(world) : data::subject_mask(moment));
}

/// What training pictures say of depth, if that is asked for.
bool has_depth(const SynthShot& shot, const SynthOptions& options) {
  return options.depth && shot.split == "train";
}

Image depth_of(const SynthScene& world, const SynthShot& shot, std::size_t number,
               const SynthOptions& options) {
  return data::draw_depth(world.at(shot.time + shot.late), shot.camera, *options.depth,
                          hash64(options.seed ^ hash64(number)));
}

/// What gas alone, or several cameras, cannot have.
void check_solid(const SynthScene& world, const SynthOptions& options) {
  if (options.depth && world.at(0).bodies() == 0)
    fail({"--depth", "this scene is gas alone, which has no depth", "a scene with something solid", "", ""});
  if (options.tracks && world.at(0).bodies() == 0)
    fail({"--tracks", "this scene is gas alone, which has no points to follow",
          "a scene with something solid", "", ""});
  if (options.tracks && options.rig.cameras > 0)
    fail({"--tracks", "points are followed through the pictures of one camera", "no --cameras",
          std::to_string(options.rig.cameras) + " cameras", ""});
}

constexpr const char* kTracks = "tracks.npy";

/// Points by pictures in the order of time; not a number where a point is not seen.
void write_tracks(const fs::path& folder, const SynthScene& world, const std::vector<SynthShot>& shots) {
  const std::vector<std::vector<VisiblePoint>> seen = data::follow_points(world, shots);
  std::vector<std::size_t> train;
  std::size_t points = 0;
  for (std::size_t i = 0; i < shots.size(); ++i) {
    if (shots[i].split == "train") train.push_back(i);
    if (!seen[i].empty()) points = std::max(points, std::size_t(seen[i].back().point) + 1);
  }
  std::vector<float> places(points * train.size() * 2, std::numeric_limits<float>::quiet_NaN());
  for (std::size_t t = 0; t < train.size(); ++t)
    for (const VisiblePoint& p : seen[train[t]]) {
      const std::size_t at = 2 * (std::size_t(p.point) * train.size() + t);
      places[at] = p.u;
      places[at + 1] = p.v;
    }
  write_file((folder / kTracks).string(), {data::npy_bytes({points, train.size(), 2}, places)});
}

nlohmann::ordered_json frame_json(const SynthShot& shot, const SynthOptions& options) {
  const Camera& c = shot.camera;
  nlohmann::ordered_json matrix = nlohmann::ordered_json::array();
  for (int row = 0; row < 3; ++row)
    matrix.push_back({c.axes[0][row], c.axes[1][row], c.axes[2][row], c.position[row]});
  matrix.push_back({0.0, 0.0, 0.0, 1.0});
  nlohmann::ordered_json frame{
      {"file_path", "./" + shot.split + "/" + shot.name}, {"time", shot.time}, {"transform_matrix", matrix}};
  if (shot.camera_id >= 0) frame["camera_id"] = data::synth_camera_name(shot.camera_id);
  if (options.rig.masks) frame["mask_path"] = "masks/" + shot.split + "/" + shot.name + ".png";
  if (has_depth(shot, options)) frame["depth_file_path"] = "depth/" + shot.split + "/" + shot.name + ".exr";
  return frame;
}

void write_transforms(const fs::path& folder, const std::string& split, const std::vector<SynthShot>& shots,
                      const SynthOptions& options) {
  nlohmann::ordered_json frames = nlohmann::ordered_json::array();
  for (const SynthShot& shot : shots)
    if (shot.split == split) frames.push_back(frame_json(shot, options));
  nlohmann::ordered_json file{{"camera_angle_x", data::camera_angle(options.look)}};
  if (options.tracks && split == "train") file["tracks_file_path"] = kTracks;
  if (options.depth == DepthKind::metric) file["depth_unit_scale_factor"] = 1.0;
  file["frames"] = frames;
  const std::string text = dump_json(file, 1) + "\n";
  write_file((folder / ("transforms_" + split + ".json")).string(), {text});
}

/// The gains of every training picture, where they drift.
void write_gains(const fs::path& folder, const std::vector<SynthShot>& shots) {
  nlohmann::ordered_json gains;
  for (const SynthShot& shot : shots)
    if (shot.split == "train") gains[shot.name] = {shot.gain.x, shot.gain.y, shot.gain.z};
  const nlohmann::ordered_json file{
      {"what",
       "picture = plain picture (8-bit display values) * gain per channel, rounded and clipped at 255"},
      {"gains_of_pictures", gains}};
  write_file((folder / "truth_gains.json").string(), {dump_json(file, 1) + "\n"});
}

/// What a rig's pictures hide: gains, clocks and the box.
void write_truth(const fs::path& folder, const SynthOptions& options, const SynthScene& world,
                 const std::vector<SynthShot>& shots) {
  const double interval = 1.0 / (options.frames - 1);
  nlohmann::ordered_json gains, offsets, intervals;
  for (const SynthShot& shot : shots) {
    const std::string name = data::synth_camera_name(shot.camera_id);
    gains[name] = {shot.gain.x, shot.gain.y, shot.gain.z};
    offsets[name] = shot.late;
    intervals[name] = shot.late / interval;
  }
  const Box box = world.box();
  nlohmann::ordered_json file{
      {"what",
       "picture = plain picture (8-bit display values) * gain per channel, rounded and clipped at 255; a "
       "camera "
       "shows the moment time + time_offset"},
      {"gains", gains},
      {"interval", interval},
      {"time_offset", offsets},
      {"time_offset_intervals", intervals},
      {"scene_box", {{box.lo.x, box.lo.y, box.lo.z}, {box.hi.x, box.hi.y, box.hi.z}}}};
  if (options.drift > 0) file.erase("gains");  // truth_gains.json has them
  write_file((folder / "truth.json").string(), {dump_json(file, 1) + "\n"});
}

/// The rig's cameras in the order of their numbers, as the data set has them.
std::vector<RigCamera> rig_of(const std::vector<SynthShot>& shots) {
  std::map<int, std::set<double>> moments;
  for (const SynthShot& shot : shots)
    if (shot.camera_id >= 0) moments[shot.camera_id].insert(shot.time);
  std::vector<RigCamera> cameras;
  for (const auto& [id, times] : moments) cameras.push_back({data::synth_camera_name(id), times.size() > 1});
  return cameras;
}

std::uint64_t fingerprint_of(const std::string& scene, const Split& train) {
  data::Fingerprint hash;
  for (const char letter : scene) hash.add(std::uint64_t(letter));
  for (const Frame& frame : train.frames) {
    hash.add(frame.time);
    for (int i = 0; i < 3; ++i) hash.add(frame.camera.position[i]);
    for (std::size_t p = 0; p < frame.image.pixels(); ++p)
      for (const std::uint16_t value : frame.image.pixel(p)) hash.add(std::uint64_t(value));
  }
  return hash.value();
}

}  // namespace

Dataset make_synth(const std::string& scene, const SynthOptions& options, const SynthProgress& progress) {
  const SynthScene world = SynthScene::open(scene, options.look);
  const std::vector<SynthShot> shots = data::plan_shots(options);
  check_solid(world, options);
  std::vector<Picture> images(shots.size());
  std::vector<DepthMap> depths(shots.size());
  for_each_shot(shots.size(), progress, [&](std::size_t i) {
    images[i] = image16(picture_of(world, shots[i], options).picture);
    if (!has_depth(shots[i], options)) return;
    const Image depth = depth_of(world, shots[i], i, options);
    depths[i] = {depth.width, depth.height, depth.data, *options.depth};
  });
  std::vector<std::vector<VisiblePoint>> tracks(shots.size());
  if (options.tracks) tracks = data::follow_points(world, shots);
  Dataset dataset;
  dataset.path = "synth:" + scene;
  for (std::size_t i = 0; i < shots.size(); ++i) {
    if (dataset.splits.empty() || dataset.splits.back().name != shots[i].split)
      dataset.splits.push_back({shots[i].split, {}});
    dataset.splits.back().frames.push_back(
        {shots[i].name, shots[i].camera, shots[i].time, std::move(images[i]), shots[i].camera_id});
    dataset.splits.back().frames.back().depth = std::move(depths[i]);
    dataset.splits.back().frames.back().tracks = std::move(tracks[i]);
  }
  dataset.cameras = rig_of(shots);
  dataset.has_alpha = !options.look.opaque && !options.look.room;
  dataset.fingerprint = fingerprint_of(scene, dataset.splits.front());
  return dataset;
}

void write_synth(const std::string& scene, const std::string& folder, const SynthOptions& options,
                 const SynthProgress& progress) {
  const SynthScene world = SynthScene::open(scene, options.look);
  const std::vector<SynthShot> shots = data::plan_shots(options);
  check_solid(world, options);
  const fs::path root(folder);
  const bool solid = world.at(0).bodies() > 0;  // gas has no surface
  for (const char* name : {"train", "val", "test"}) make_folder(root / name);
  if (solid) make_folder(root / "truth");
  if (options.depth) make_folder(root / "depth" / "train");
  if (options.rig.masks)
    for (const char* name : {"train", "val", "test"}) make_folder(root / "masks" / name);
  for_each_shot(shots.size(), progress, [&](std::size_t i) {
    const SynthShot& shot = shots[i];
    const data::Drawn drawn = picture_of(world, shot, options);
    const std::string name = shot.name + ".png";
    write_png((root / shot.split / name).string(), drawn.picture);
    if (options.rig.masks) write_png((root / "masks" / shot.split / name).string(), drawn.mask);
    if (has_depth(shot, options))
      write_exr((root / "depth" / shot.split / (shot.name + ".exr")).string(),
                {{"", depth_of(world, shot, i, options), {"Z"}}});
    if (solid && shot.split == "test")
      write_exr((root / "truth" / (shot.name + "_0000.exr")).string(),
                data::draw_truth(world.at(shot.time), shot.camera));
  });
  if (options.rig.cameras > 0) write_truth(root, options, world, shots);
  if (options.drift > 0) write_gains(root, shots);
  if (options.tracks) write_tracks(root, world, shots);
  for (const char* split : {"train", "val", "test"}) write_transforms(root, split, shots, options);
}

}  // namespace splinevox
