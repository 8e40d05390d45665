// SPDX-License-Identifier: Apache-2.0
#include "splinevox/data/posed_pictures.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "data/fingerprint.hpp"
#include "data/layouts/raw_scene.hpp"
#include "data/message_text.hpp"
#include "data/pictures/decode.hpp"
#include "data/rig_cameras.hpp"
#include "data/scene_notes.hpp"
#include "data/times/time_map.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox {
namespace {

using namespace data;

constexpr double kLatest = 1e12;

void check(const PosedPicture& p, const std::string& where) {
  if (!p.image.has_values() || p.image.pixels() == 0)
    fail({where, "there are no pixels", "a picture", size_text({p.image.width, p.image.height}), ""});
  if (p.ignored.pixels() > 0 && (p.ignored.width() != p.image.width || p.ignored.height() != p.image.height))
    fail({where, "the mask is not of the picture's size", size_text({p.image.width, p.image.height}),
          size_text({p.ignored.width(), p.ignored.height()}), ""});
  if (p.ignored.pixels() > 0 && p.ignored.all())
    fail({where, "every pixel is ignored", "some that are not", "", "leave the picture out"});
  if (!(std::abs(p.time) <= kLatest))
    fail({where, "the time is not finite or too large", "at most 1e12", number(p.time), ""});
}

RawFrame raw_frame(const PosedPicture& p, const std::string& where) {
  RawFrame frame;
  frame.file_path = frame.name = frame.label = p.name;
  frame.camera = p.camera;
  frame.time = p.time;
  frame.matrix = p.camera_to_world;
  frame.pose = rigid_pose(p.camera_to_world, where);
  frame.lens.fl_x = p.fx;
  frame.lens.fl_y = p.fy;
  frame.lens.cx = p.cx;
  frame.lens.cy = p.cy;
  return frame;
}

}  // namespace

Dataset dataset_of(std::vector<PosedSplit> splits, const std::string& name, std::optional<Box> box) {
  RawScene scene;
  scene.box = box;
  scene.one_list = splits.size() == 1 && splits[0].name.empty();
  std::map<std::string, PosedPicture*> pictures;
  for (PosedSplit& split : splits) {
    const std::string called = scene.one_list ? "train" : split.name;
    if (called != "train" && called != "val" && called != "test")
      fail({name, "there is no such split", "train, val or test", split.name, ""});
    for (const RawSplit& before : scene.splits)
      if (before.name == called) fail({name, "two splits have one name", "each name once", called, ""});
    if (split.pictures.empty()) fail({name, "the " + called + " split is empty", "pictures", "none", ""});
    RawSplit raw{called, name, true, {}};
    for (PosedPicture& p : split.pictures) {
      const std::string where = name + ", picture " + p.name;
      if (!pictures.emplace(p.name, &p).second)
        fail({where, "two pictures have one name", "names of their own", p.name, ""});
      check(p, where);
      raw.frames.push_back(raw_frame(p, where));
    }
    scene.splits.push_back(std::move(raw));
  }
  if (scene.splits.empty() || scene.splits[0].name != "train")
    fail({name, "there is no train split", "pictures to train on, first", "", ""});
  scene.cameras = settle_cameras(scene.splits);
  if (scene.one_list) hold_out(scene, "");

  Dataset dataset;
  dataset.path = name;
  dataset.format = "arrays";
  dataset.box = scene.box;
  dataset.cameras = scene.cameras;
  dataset.notes = scene.notes;
  dataset.time_map = choose_time_map(&scene.splits[0], scene.splits, dataset.notes);
  for (const RawSplit& raw : scene.splits) {
    Split split{raw.name, {}};
    std::vector<PictureFacts> facts;
    for (std::size_t i = 0; i < raw.frames.size(); ++i) {
      const RawFrame& frame = raw.frames[i];
      PosedPicture& p = *pictures.at(frame.name);
      facts.push_back(facts_of(p.image));
      dataset.has_alpha |= raw.name == "train" && facts.back().see_through;
      const Camera camera = pinhole(frame.lens, frame.pose, p.image.width, p.image.height, raw.where(i));
      split.frames.push_back({p.name, camera, model_time(raw, i, dataset.time_map), std::move(p.image),
                              frame.camera_id, std::move(p.ignored)});
    }
    note_times(raw, dataset.time_map, dataset.notes);
    note_cameras(raw, dataset.notes);
    note_facts(split, facts, dataset.notes);
    if (raw.name == "train") dataset.fingerprint = fingerprint_of(raw, split, facts);
    for (const Frame& f : split.frames)
      dataset.pictures_in_memory += double(f.image.layout().size(f.image.pixels()));
    dataset.splits.push_back(std::move(split));
  }
  return dataset;
}

}  // namespace splinevox
