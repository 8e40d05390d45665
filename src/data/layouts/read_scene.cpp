// SPDX-License-Identifier: Apache-2.0
#include "data/layouts/read_scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "data/layouts/folder_list.hpp"
#include "data/layouts/near_miss.hpp"
#include "data/layouts/transforms.hpp"
#include "data/message_text.hpp"
#include "data/rig_cameras.hpp"
#include "data/times/between.hpp"
#include "data/times/settle.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox {
namespace {

namespace fs = std::filesystem;
using namespace data;
constexpr const char* kSplits[] = {"train", "val", "test"};
constexpr const char* kLookedFor =
    "transforms_train.json, transforms_val.json or transforms_test.json (NeRF / D-NeRF), transforms.json "
    "(nerfstudio, instant-ngp), "
    "transform_train.json (NeRFlow), train_meta.json (Dynamic 3D Gaussians), info.json with train_videos "
    "(PINF), dataset.json with camera/ (Nerfies, HyperNeRF), precomputed.json "
    "(NR-NeRF), intri.yml with extri.yml (EasyMocap), poses_bounds.npy (LLFF; with "
    "a film or a folder of pictures per camera DyNeRF), sparse/0/cameras.bin or .txt (COLMAP)";

bool named(const std::vector<std::string>& list, const std::string& split) {
  return std::find(list.begin(), list.end(), split) != list.end();
}

bool has_split(const fs::path& folder, const std::string& split) {
  std::error_code ignored;
  return fs::exists(folder / transforms_name(split), ignored);
}

bool is_dnerf(const fs::path& folder) {
  return std::any_of(std::begin(kSplits), std::end(kSplits),
                     [&](const char* split) { return has_split(folder, split); });
}

/// One kind of folder. The D-NeRF layout alone reads its splits one by one.
struct Layout {
  const char* name;
  bool (*is)(const fs::path&);
  RawScene (*read)(const fs::path&);
};

/// In the order in which they are tried: what somebody made on purpose before what a program left in the same
/// folder.
constexpr Layout kLayouts[] = {{"NeRF / D-NeRF", is_dnerf, nullptr},
                               {"nerfstudio / instant-ngp", is_nerfstudio, read_nerfstudio},
                               {"NeRFlow (Gibson)", is_gibson, read_gibson},
                               {"Dynamic 3D Gaussians", is_dynamic_gaussians, read_dynamic_gaussians},
                               {"PINF", is_pinf, read_pinf},
                               {"Nerfies / HyperNeRF", is_nerfies, read_nerfies},
                               {"NR-NeRF", is_nrnerf, read_nrnerf},
                               {"EasyMocap", is_easymocap, read_easymocap},
                               {"DyNeRF", is_dynerf, read_dynerf},
                               {"LLFF", is_llff, read_llff},
                               {"COLMAP", is_colmap, read_colmap}};

const Layout& recognise(const fs::path& folder) {
  const std::string where = printable(folder.string());
  std::error_code error;
  if (!fs::exists(folder, error))
    fail({where.empty() ? "''" : where, "the data set does not exist",
          "a folder with " + std::string(kLookedFor), error ? error.message() : "no such folder", ""});
  if (!fs::is_directory(folder, error)) {
    if (kind_of(folder) == FileKind::film)
      fail({where, "a film has no cameras: " + how_to_capture(folder), "", "", ""});
    fail({where, "the data set is not a folder", "a folder with " + std::string(kLookedFor), "a file",
          "give the folder that holds it"});
  }
  for (const Layout& layout : kLayouts)
    if (layout.is(folder)) return layout;
  const NearMiss near = near_miss(folder);
  if (near.bare)
    fail({where, "no known kind of data set is in this folder; " + near.hint, "", near.found,
          "of a data set, the folder with " + std::string(kLookedFor)});
  fail({where, "no known kind of data set is in this folder", kLookedFor, "none of them, but " + near.found,
        near.hint});
}

/// The splits to read, train first.
std::vector<std::string> choose_splits(const fs::path& folder, const std::vector<std::string>& there,
                                       bool dnerf, const LoadOptions& options) {
  for (const std::string& split : options.splits) {
    if (std::find(std::begin(kSplits), std::end(kSplits), split) == std::end(kSplits))
      fail(
          {printable(folder.string()), "there is no such split", "train, val or test", in_quotes(split), ""});
    if (!named(there, split))
      fail(
          {printable((dnerf ? folder / transforms_name(split) : folder).string()),
           "the " + split + " split was asked for and is not there",
           dnerf ? transforms_name(split) : fmt::format("{}", fmt::join(there, " or ")),
           dnerf ? "no such file" : split,
           options.rules.hold_out == "none" ? "--split train: with --hold-out none all pictures train" : ""});
  }
  std::vector<std::string> chosen;
  for (const std::string& split : there)
    if (options.splits.empty() || named(options.splits, split) || named(options.if_there, split))
      chosen.push_back(split);
  return chosen;
}

/// The splits of a NeRF / D-NeRF folder, each with the one its file is named after. nerfstudio's own have
/// train and val alone: where test is asked for, val serves as it.
std::vector<std::pair<std::string, std::string>> dnerf_splits(const fs::path& folder,
                                                              const LoadOptions& options,
                                                              std::vector<std::string>& notes) {
  std::vector<std::pair<std::string, std::string>> splits;
  for (const char* name : kSplits)
    if (has_split(folder, name)) splits.emplace_back(name, name);
  if (!named(options.splits, "test") || has_split(folder, "test") || !has_split(folder, "val")) return splits;
  if (!named(options.splits, "val")) splits.pop_back();
  splits.emplace_back("test", "val");
  notes.push_back("there is no " + transforms_name("test") + ": " + transforms_name("val") +
                  " is the test split");
  return splits;
}

/// The splits that are needed: those asked for and the train split, whose times serve all. Where they have no
/// times of their own, all, because names are understood over the whole set.
RawScene read_dnerf(const fs::path& folder, const LoadOptions& options, const TimesChoice& times) {
  std::vector<std::string> notes, there;
  const auto files = dnerf_splits(folder, options, notes);
  for (const auto& [name, file] : files) there.push_back(name);
  const std::vector<std::string> chosen = choose_splits(folder, there, true, options);
  const auto read = [&](const auto& wanted) {
    RawScene scene;
    scene.notes = notes;
    for (const auto& [name, file] : files)
      if (wanted(name))
        scene.splits.push_back(read_transforms(folder, file, name, name == "train" ? &scene.box : nullptr));
    return scene;
  };
  const bool map = !options.time_map && !named(chosen, "train");
  RawScene scene =
      read([&](const std::string& name) { return named(chosen, name) || (map && name == "train"); });
  const bool timed = std::all_of(scene.splits.begin(), scene.splits.end(),
                                 [](const RawSplit& split) { return split.timed; });
  if (scene.splits.size() < there.size() && !(timed && times.source == TimesChoice::Source::automatic))
    scene = read([](const std::string&) { return true; });
  return scene;
}

/// Where test is asked for and the data has val alone, val serves as it.
void val_as_test(RawScene& scene, const LoadOptions& options) {
  const auto split_of = [&](const char* name) {
    return std::find_if(scene.splits.begin(), scene.splits.end(),
                        [&](const RawSplit& s) { return s.name == name; });
  };
  if (!named(options.splits, "test") || named(options.splits, "val") ||
      split_of("test") != scene.splits.end() || split_of("val") == scene.splits.end())
    return;
  split_of("val")->name = "test";
  scene.notes.push_back("the data names no test split: val is the test split");
}

[[noreturn]] void refuse_hold_out(const fs::path& folder, const RawScene& scene, const std::string& rule) {
  std::vector<std::string> names;
  for (const RawSplit& split : scene.splits) names.push_back(split.name);
  fail({printable(folder.string()), "--hold-out is for data that names no splits", "one list of pictures",
        list_of(names), "leave --hold-out " + rule + " out"});
}

/// A picture that two frames have: of two splits it counts twice, of one list of all once (hold_out).
void note_repeats(RawScene& scene) {
  std::map<std::pair<std::string, int>, std::string> taken;
  std::size_t all = 0, again = 0;
  std::string first;
  for (const RawSplit& split : scene.splits)
    for (const RawFrame& frame : split.frames) {
      ++all;
      const std::string path = fs::path(frame.file_path).lexically_normal().generic_string();
      const auto [at, fresh] = taken.try_emplace({path, frame.film_frame}, split.name);
      if (!fresh && ++again == 1) first = in_quotes(path) + " (" + at->second + " and " + split.name + ")";
    }
  if (again > 0)
    scene.notes.push_back(
        fmt::format("{} of {} frames have a picture that another frame has, such as {}", again, all, first));
}

/// Sets RawFrame::order. @return how many there are
std::size_t number_in_time(std::vector<RawSplit>& splits) {
  std::vector<RawFrame*> all;
  for (RawSplit& split : splits)
    for (RawFrame& frame : split.frames) all.push_back(&frame);
  std::stable_sort(all.begin(), all.end(),
                   [](const RawFrame* a, const RawFrame* b) { return a->time < b->time; });
  for (std::size_t i = 0; i < all.size(); ++i) all[i]->order = i;
  return all.size();
}

}  // namespace

namespace data {

OpenScene open_scene(const fs::path& folder, const LoadOptions& options) {
  const TimesChoice times = parse_times(options.rules.times);
  const std::optional<Between> between = parse_between(options.rules.between);
  MaskUse mask_use = parse_masks(options.rules.masks);
  const Layout& layout = recognise(folder);
  RawScene scene = layout.read ? layout.read(folder) : read_dnerf(folder, options, times);
  const fs::path root = fs::canonical(folder);
  for (RawSplit& split : scene.splits)
    for (std::string& note : split.notes) scene.notes.push_back(std::move(note));
  if (const std::string note = take_foreign_paths(root, scene.splits); !note.empty())
    scene.notes.push_back(note);
  leave_out(scene, options.rules, [&](RawFrame& frame, const std::string& where) -> std::optional<Error> {
    std::optional<fs::path> found = find_image(root, frame.file_path, where);
    if (!found) return image_missing(root, frame.file_path, where);
    frame.found = std::move(*found);
    return {};
  });
  note_repeats(scene);
  const std::optional<MaskSearch> of_alpha = masks_of_alpha(scene, mask_use);
  const MaskSearch masks = of_alpha ? *of_alpha : find_masks(root, scene);
  require_masks(scene, mask_use, masks, options.rules);
  settle_times(folder, times, scene.splits, scene.notes);
  scene.cameras = settle_cameras(scene.splits);
  if (layout.read)
    for (RawSplit& split : scene.splits) sort_by_time(split);
  const std::size_t pictures = layout.read ? number_in_time(scene.splits) : 0;
  if (between) keep_between(*between, options.splits, scene.splits, scene.notes);
  if (const std::string& rule = options.rules.hold_out; scene.one_list)
    hold_out(scene, rule);
  else if (!rule.empty())
    refuse_hold_out(folder, scene, rule);
  val_as_test(scene, options);
  OpenScene open{layout.name, {}, {}, mask_use, masks, pictures};
  open.scene.box = scene.box;
  open.scene.cameras = scene.cameras;
  open.scene.notes = scene.notes;
  std::vector<std::string> there;
  for (const RawSplit& split : scene.splits) there.push_back(split.name);
  const std::vector<std::string> chosen = choose_splits(folder, there, !layout.read, options);
  for (RawSplit& split : scene.splits)
    if (std::find(chosen.begin(), chosen.end(), split.name) != chosen.end())
      open.scene.splits.push_back(std::move(split));
    else if (split.name == "train" && !options.time_map)
      open.train = std::move(split);
  return open;
}

}  // namespace data

std::vector<std::string> dataset_formats() {
  std::vector<std::string> names;
  for (const Layout& layout : kLayouts) names.emplace_back(layout.name);
  return names;
}

}  // namespace splinevox
