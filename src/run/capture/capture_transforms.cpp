// SPDX-License-Identifier: Apache-2.0
// The data set that is written: transforms.json as nerfstudio has it.
#include "core/atomic_file.hpp"
#include "data/layouts/transforms_write.hpp"
#include "run/capture/capture_stages.hpp"
#include "splinevox/data/scene.hpp"

namespace splinevox::run {

void write_transforms(const std::filesystem::path& folder, const CaptureState& state,
                      const CapturedScene& scene) {
  Json frames = Json::array();
  const std::string path = (folder / "transforms.json").string();
  for (const CapturedScene::Placed& placed : scene.frames) {
    const CaptureFrame& of = state.frames[placed.frame];
    Json frame{{"file_path", "images/" + of.name}, {"time", of.time}};
    if (!of.mask.empty()) frame["mask_path"] = of.mask;
    if (state.of_rig()) frame["camera_id"] = state.rig[std::size_t(of.camera)];
    frame.update(data::lens_json(placed.camera));
    frame["transform_matrix"] = data::matrix_json(placed.matrix);
    frames.push_back(std::move(frame));
  }
  const Box& b = scene.box;
  const Json file{{"source", std::string("splinevox capture ") + kVersion},
                  {"scene_box", {{b.lo.x, b.lo.y, b.lo.z}, {b.hi.x, b.hi.y, b.hi.z}}},
                  {"frames", std::move(frames)}};
  write_file(path, {json_text(file, 1) + "\n"});
  load_dataset(folder.string(), {.pixels = false});  // what it would refuse is better known now
}

}  // namespace splinevox::run
