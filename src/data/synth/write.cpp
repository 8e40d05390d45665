// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <filesystem>
#include <mutex>
#include <nlohmann/json.hpp>

#include "core/atomic_file.hpp"
#include "core/json_text.hpp"
#include "core/parallel.hpp"
#include "data/fingerprint.hpp"
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

nlohmann::ordered_json frame_json(const SynthShot& shot) {
  const Camera& c = shot.camera;
  nlohmann::ordered_json matrix = nlohmann::ordered_json::array();
  for (int row = 0; row < 3; ++row)
    matrix.push_back({c.axes[0][row], c.axes[1][row], c.axes[2][row], c.position[row]});
  matrix.push_back({0.0, 0.0, 0.0, 1.0});
  return {
      {"file_path", "./" + shot.split + "/" + shot.name}, {"time", shot.time}, {"transform_matrix", matrix}};
}

void write_transforms(const fs::path& folder, const std::string& split, const std::vector<SynthShot>& shots) {
  nlohmann::ordered_json frames = nlohmann::ordered_json::array();
  for (const SynthShot& shot : shots)
    if (shot.split == split) frames.push_back(frame_json(shot));
  const nlohmann::ordered_json file{{"camera_angle_x", data::kCameraAngle}, {"frames", frames}};
  const std::string text = dump_json(file, 1) + "\n";
  write_file((folder / ("transforms_" + split + ".json")).string(), {text});
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
  std::vector<Picture> images(shots.size());
  for_each_shot(shots.size(), progress, [&](std::size_t i) {
    images[i] = image16(data::draw(world.at(shots[i].time), shots[i].camera, options.look.opaque));
  });
  Dataset dataset;
  dataset.path = "synth:" + scene;
  for (std::size_t i = 0; i < shots.size(); ++i) {
    if (dataset.splits.empty() || dataset.splits.back().name != shots[i].split)
      dataset.splits.push_back({shots[i].split, {}});
    dataset.splits.back().frames.push_back(
        {shots[i].name, shots[i].camera, shots[i].time, std::move(images[i])});
  }
  dataset.has_alpha = !options.look.opaque;
  dataset.fingerprint = fingerprint_of(scene, dataset.splits.front());
  return dataset;
}

void write_synth(const std::string& scene, const std::string& folder, const SynthOptions& options,
                 const SynthProgress& progress) {
  const SynthScene world = SynthScene::open(scene, options.look);
  const std::vector<SynthShot> shots = data::plan_shots(options);
  const fs::path root(folder);
  for (const char* name : {"train", "val", "test", "truth"}) make_folder(root / name);
  for_each_shot(shots.size(), progress, [&](std::size_t i) {
    const SynthShot& shot = shots[i];
    const SynthMoment moment = world.at(shot.time);
    write_png((root / shot.split / (shot.name + ".png")).string(),
              data::draw(moment, shot.camera, options.look.opaque));
    if (shot.split == "test")
      write_exr((root / "truth" / (shot.name + "_0000.exr")).string(), data::draw_truth(moment, shot.camera));
  });
  for (const char* split : {"train", "val", "test"}) write_transforms(root, split, shots);
}

}  // namespace splinevox
