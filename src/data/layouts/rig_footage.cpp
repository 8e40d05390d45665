// SPDX-License-Identifier: Apache-2.0
// The pictures and films of cameras that stand still, found by the cameras' names.
#include "data/layouts/rig_footage.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "data/layouts/folder_list.hpp"
#include "data/message_text.hpp"
#include "data/pictures/film_read.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::data {
namespace {

namespace fs = std::filesystem;

/// Where rigs keep the folders of their cameras, and their films.
constexpr const char* kFolderPlaces[] = {"", "images", "frames", "input", "rgb", "ims"};
constexpr const char* kFilmPlaces[] = {"", "videos", "films", "images"};
/// Where they keep the masks: EasyMocap, EasyVolcap, Dynamic 3D Gaussians.
constexpr const char* kMaskPlaces[] = {"mask", "masks", "seg", "schp", "mask-schp", "mask_schp", "mask_cihp"};

/// A name with # for every number in it: what names of one kind have in common.
std::string form_of(const std::string& name) {
  std::string form;
  for (const char c : name) {
    const bool digit = c >= '0' && c <= '9';
    if (!digit || form.empty() || form.back() != '#') form += digit ? '#' : c;
  }
  return form;
}

std::vector<Footage> folders_at(const fs::path& folder, const fs::path& place) {
  std::vector<Footage> found;
  for (const std::string& name : folders_in(folder / place))
    if (!is_no_camera(name))
      if (std::vector<std::string> pictures = pictures_of_camera(folder, place / name); !pictures.empty())
        found.push_back({name, "", std::move(pictures)});
  return found;
}

std::vector<Footage> films_at(const fs::path& folder, const fs::path& place) {
  std::vector<Footage> found;
  for (const std::string& name : files_in(folder / place, FileKind::film))
    found.push_back({fs::path(name).stem().string(), (place / name).generic_string(), {}});
  return found;
}

/// The masks of one camera by the names of its pictures, without ending.
std::map<std::string, std::string> masks_of_camera(const fs::path& folder, const std::string& camera) {
  std::map<std::string, std::string> masks;
  for (const fs::path place : kMaskPlaces)
    for (const std::string& name : files_in(folder / place / camera, FileKind::picture))
      masks.emplace(mask_of(name), (place / camera / name).generic_string());
  return masks;
}

/// One picture per name, whether it is there or not.
std::vector<std::string> asked_for(const Footage& footage, const std::vector<std::string>& names) {
  const fs::path inside = fs::path(footage.pictures.at(0)).parent_path();
  std::set<std::string> stems;
  for (const std::string& path : footage.pictures) stems.insert(fs::path(path).stem().string());
  std::vector<std::string> all = footage.pictures;
  for (const std::string& name : names)
    if (!stems.contains(fs::path(name).stem().string())) all.push_back((inside / name).generic_string());
  return all;
}

void check_numbers(const std::vector<Footage>& footage, const std::string& where) {
  const auto [few, many] = std::minmax_element(
      footage.begin(), footage.end(),
      [](const Footage& a, const Footage& b) { return a.pictures.size() < b.pictures.size(); });
  if (few->pictures.size() < many->pictures.size())
    fail({where, "cameras have different numbers of pictures, with names of their own",
          fmt::format("{}, as {} has", many->pictures.size(), in_quotes(many->camera)),
          fmt::format("{} of {}", few->pictures.size(), in_quotes(few->camera)),
          "give pictures of one moment the same name in every folder"});
}

}  // namespace

std::vector<std::string> shared_names(const std::vector<Footage>& footage) {
  std::map<std::string, int> uses;
  for (const Footage& f : footage)
    for (const std::string& path : f.pictures) ++uses[fs::path(path).filename().string()];
  const auto shared = std::count_if(uses.begin(), uses.end(), [](const auto& u) { return u.second > 1; });
  std::vector<std::string> names;
  if (2 * std::size_t(shared) > uses.size())
    for (const auto& [name, count] : uses) names.push_back(name);
  return names;
}

bool is_no_camera(const std::string& name) {
  const std::string low = lower_case(name);
  return low.starts_with("images") || low.starts_with("sparse") || low.starts_with("colmap") ||
         is_mask_folder(name) || low.find("depth") != std::string::npos;
}

std::vector<std::string> pictures_of_camera(const fs::path& folder, const fs::path& camera) {
  for (const fs::path& inside : {camera / "images", camera}) {
    std::vector<std::string> paths = without_masks(files_in(folder / inside, FileKind::picture));
    for (std::string& path : paths) path = (inside / path).generic_string();
    if (!paths.empty()) return paths;
  }
  return {};
}

int add_film(const fs::path& folder, const RawFrame& camera, const std::string& film, double& rate,
             std::vector<RawFrame>& frames, std::vector<std::string>& notes) {
  RawFrame frame = camera;
  frame.label = "film " + printable(film);
  frame.file_path = film;
  const FilmFacts facts = film_facts(folder / film, printable((folder / film).string()));
  frame.film_size = {facts.width, facts.height};
  frame.film_turn = facts.orientation();
  for (const std::string& odd : oddities_of(facts))
    if (std::none_of(notes.begin(), notes.end(), [&](const std::string& n) { return n.ends_with(odd); }))
      notes.push_back(printable(film) + ": " + odd);
  if (rate == 0) rate = facts.rate;
  for (frame.film_frame = 0; frame.film_frame < facts.frames(); ++frame.film_frame) {
    const double time = rate * facts.times[std::size_t(frame.film_frame)], whole = std::round(time);
    frame.time = std::abs(time - whole) < 1e-6 ? whole : time;
    frame.name = fmt::format("{}_{:04}", fs::path(film).stem().string(), frame.film_frame);
    frames.push_back(frame);
  }
  return facts.frames();
}

void add_pictures(const RawFrame& camera, const std::vector<std::string>& pictures,
                  std::vector<RawFrame>& frames) {
  for (const std::string& path : pictures) {
    RawFrame frame = camera;
    frame.file_path = path;
    frame.label = "picture " + printable(path);
    frame.name = camera.camera + "_" + fs::path(path).stem().string();
    frames.push_back(std::move(frame));
  }
}

std::string note_on_lengths(int fewest, int most) {
  if (fewest >= most) return {};
  return fmt::format("films have from {} to {} frames; their first frames are taken at the same time", fewest,
                     most);
}

std::vector<Footage> find_footage(const fs::path& folder, const std::vector<std::string>& cameras,
                                  std::size_t least) {
  std::vector<Footage> best;
  std::ptrdiff_t most = 1;
  const auto offer = [&](std::vector<Footage> found) {
    std::erase_if(found, [&](const Footage& f) { return f.film.empty() && f.pictures.size() < least; });
    const auto matches = std::count_if(found.begin(), found.end(), [&](const Footage& f) {
      return std::find(cameras.begin(), cameras.end(), f.camera) != cameras.end();
    });
    if (matches <= most) return;
    most = matches;
    best = std::move(found);
  };
  for (const char* place : kFolderPlaces) offer(folders_at(folder, place));
  for (const char* place : kFilmPlaces) offer(films_at(folder, place));
  return best;
}

namespace {

/// What each named camera took.
using Takes = std::map<std::string, const Footage*>;

/// Replaces every camera of the scene that took something by its frames. @return names of the others
template <class Take>
std::vector<std::string> replace_cameras(RawScene& scene, const Takes& takes, const Take& take) {
  std::vector<std::string> without;
  bool depth = false;
  for (RawSplit& split : scene.splits)
    for (RawFrame& camera : std::exchange(split.frames, {})) {
      camera.mask.clear();
      depth |= !camera.depth.empty();
      camera.depth.clear();
      camera.depth_unit.reset();
      if (const auto found = takes.find(camera.camera); found != takes.end())
        take(camera, *found->second, split.frames);
      else
        without.push_back(camera.camera);
    }
  if (depth) scene.notes.push_back("depth maps of the cameras' poses are not used: they are of one moment");
  return without;
}

/// The most frames of a film.
std::size_t most_frames(const std::map<std::string, int>& lengths, RawScene& scene) {
  const auto shorter = [](const auto& a, const auto& b) { return a.second < b.second; };
  const auto [few, many] = std::minmax_element(lengths.begin(), lengths.end(), shorter);
  if (10 * few->second < 9 * many->second)
    fail({scene.splits[0].file, "films differ in length by more than a tenth",
          fmt::format("{} frames, as in {}", many->second, in_quotes(many->first)),
          fmt::format("{} in {}", few->second, in_quotes(few->first)), "cut them to the same moments"});
  if (const std::string note = note_on_lengths(few->second, many->second); !note.empty())
    scene.notes.push_back(note);
  return std::size_t(many->second);
}

/// A frame for each moment of a camera that cannot be used, so that what is lost is counted.
void add_faults(const std::string& camera, std::size_t moments, const Problem& problem, RawSplit& split) {
  RawFrame frame;
  frame.label = "camera " + printable(camera);
  frame.fault = Error(problem, Fault::input);
  split.frames.insert(split.frames.end(), moments, frame);
}

/// Pictures without a camera: faults where they are named as cameras are, else a note.
void add_strangers(const std::vector<Footage>& footage, const std::set<std::string>& cameras,
                   std::size_t moments, RawScene& scene) {
  std::set<std::string> forms;
  for (const std::string& name : cameras) forms.insert(form_of(name));
  std::vector<std::string> others;
  RawSplit& split = scene.splits[0];
  for (const Footage& f : footage) {
    if (cameras.contains(f.camera)) continue;
    if (forms.contains(form_of(f.camera)))
      add_faults(f.camera, moments,
                 {split.file, fmt::format("there are pictures of {} and no camera", in_quotes(f.camera)),
                  "a pose for every camera", list_of({cameras.begin(), cameras.end()}),
                  "add its pose, or take its pictures away"},
                 split);
    else
      others.push_back(f.camera);
  }
  if (!others.empty()) scene.notes.push_back("not read, for no camera has its name: " + list_of(others));
}

}  // namespace

void take_footage(const fs::path& folder, const std::vector<Footage>& footage, RawScene& scene) {
  std::set<std::string> cameras;
  for (const RawSplit& split : scene.splits)
    for (const RawFrame& frame : split.frames) cameras.insert(frame.camera);
  std::vector<Footage> used;
  std::copy_if(footage.begin(), footage.end(), std::back_inserter(used),
               [&](const Footage& f) { return cameras.contains(f.camera); });
  Takes takes;
  for (const Footage& f : used) takes.emplace(f.camera, &f);
  const bool films = !used.at(0).film.empty();
  for (RawSplit& split : scene.splits) split.timed = films;
  std::vector<std::string> without;
  std::size_t moments = 0;
  if (films) {
    double rate = 0;
    std::map<std::string, int> lengths;
    without = replace_cameras(scene, takes, [&](const RawFrame& camera, const Footage& f, auto& frames) {
      lengths[f.film] = add_film(folder, camera, f.film, rate, frames, scene.notes);
    });
    moments = most_frames(lengths, scene);
  } else {
    const std::vector<std::string> names = shared_names(used);
    if (names.empty()) check_numbers(used, scene.splits[0].file);
    without = replace_cameras(scene, takes, [&](const RawFrame& camera, const Footage& f, auto& frames) {
      const std::size_t first = frames.size();
      add_pictures(camera, asked_for(f, names), frames);
      const std::map<std::string, std::string> masks = masks_of_camera(folder, camera.camera);
      for (std::size_t i = first; i < frames.size(); ++i)
        if (const auto mask = masks.find(fs::path(frames[i].file_path).stem().string()); mask != masks.end())
          frames[i].mask = mask->second;
    });
    moments = std::max(names.size(), used[0].pictures.size());
  }
  for (const std::string& name : without)
    add_faults(name, moments,
               {scene.splits[0].file, fmt::format("there are no pictures of camera {}", in_quotes(name)),
                "a folder or a film for every camera", "none of its name",
                "copy them, or take the camera out of the poses"},
               scene.splits[0]);
  add_strangers(footage, cameras, moments, scene);
  std::erase_if(scene.splits, [](const RawSplit& split) { return split.frames.empty(); });
}

}  // namespace splinevox::data
