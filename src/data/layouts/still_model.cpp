// SPDX-License-Identifier: Apache-2.0
#include "data/layouts/still_model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "data/layouts/rig_footage.hpp"
#include "data/message_text.hpp"
#include "data/times/digits.hpp"

namespace splinevox::data {
namespace {

namespace fs = std::filesystem;

/// What a model calls its cameras, in three ways.
constexpr std::string (*kNamings[])(const RawFrame&) = {
    [](const RawFrame& frame) { return frame.camera; },
    [](const RawFrame& frame) { return fs::path(frame.file_path).stem().string(); },
    [](const RawFrame& frame) {
      const fs::path inside = fs::path(frame.file_path).parent_path();
      return (inside.filename() == "images" ? inside.parent_path() : inside).filename().string();
    }};

/// The names of all frames' cameras; empty unless every one has a name of its own.
std::vector<std::string> names_by(const RawScene& scene, std::string (*naming)(const RawFrame&)) {
  std::set<std::string> names;
  std::size_t frames = 0;
  for (const RawSplit& split : scene.splits)
    for (const RawFrame& frame : split.frames) {
      names.insert(naming(frame));
      ++frames;
    }
  if (names.size() < frames || names.contains("")) return {};
  return {names.begin(), names.end()};
}

/// Keeps pictures of the form that the model's own pictures have, where folders hold these: depth maps and
/// the like lie beside them.
void keep_form(const RawScene& scene, std::vector<Footage>& footage) {
  const auto form = [](const std::string& path) { return take_apart(path, false).stem_text; };
  const auto name = [](const std::string& path) {
    return std::string(bare_name(fs::path(path).filename().string()));
  };
  std::set<std::string> own, forms;
  for (const RawSplit& split : scene.splits)
    for (const RawFrame& frame : split.frames) own.insert(name(frame.file_path));
  for (const Footage& f : footage)
    for (const std::string& path : f.pictures)
      if (own.contains(name(path))) forms.insert(form(path));
  if (forms.empty()) return;
  for (Footage& f : footage)
    std::erase_if(f.pictures, [&](const std::string& path) { return !forms.contains(form(path)); });
}

/// Leaves out a photograph's own film (IMG_0042.MOV beside IMG_0042.JPG), which telephones take with it while
/// they are held in the hand. @return one of them; empty: there is none
std::string drop_live_photographs(const RawScene& scene, std::vector<Footage>& footage) {
  const auto of_telephone = [](const NameNumber& n) {
    return n.before == "img" || n.before == "pxl" || n.before == "mvimg";
  };
  std::set<std::string> own;
  for (const RawSplit& split : scene.splits)
    for (const RawFrame& frame : split.frames) {
      const std::vector<NameNumber> numbers = take_apart(frame.file_path, false).stem;
      if (std::any_of(numbers.begin(), numbers.end(), of_telephone))
        own.insert(std::string(bare_name(frame.file_path)));
    }
  std::string first;
  std::erase_if(footage, [&](const Footage& f) {
    const std::string name = fs::path(f.film).replace_extension().generic_string();
    const bool live = !f.film.empty() && own.contains(std::string(bare_name(name)));
    if (live && first.empty()) first = f.film;
    return live;
  });
  return first;
}

bool is_one_moment(const RawScene& scene) {
  for (const RawSplit& split : scene.splits)
    for (const RawFrame& frame : split.frames)
      if (frame.time != scene.splits[0].frames[0].time) return false;
  return true;
}

}  // namespace

bool take_still_model(const fs::path& folder, RawScene& scene) {
  if (!is_one_moment(scene)) return false;
  for (const auto naming : kNamings) {
    const std::vector<std::string> names = names_by(scene, naming);
    if (names.size() < 2) continue;
    constexpr std::size_t kLeast = 2;
    std::vector<Footage> footage = find_footage(folder, names, kLeast);
    keep_form(scene, footage);
    if (const std::string film = drop_live_photographs(scene, footage); !film.empty())
      scene.notes.push_back(fmt::format(
          "films beside photographs of their names, such as {}, are taken for theirs and are not read; "
          "those of cameras that stand still belong into a folder of their own",
          in_quotes(film)));
    std::erase_if(footage, [](const Footage& f) { return f.film.empty() && f.pictures.size() < kLeast; });
    const auto named = std::find_if(footage.begin(), footage.end(), [&](const Footage& f) {
      return std::binary_search(names.begin(), names.end(), f.camera);
    });
    if (named == footage.end()) continue;
    scene.notes.push_back(fmt::format(
        "{} has one pose for every camera, which stands still: its pictures are those of the {} with its "
        "name, "
        "such as {}",
        scene.splits[0].file, named->film.empty() ? "folder" : "film",
        in_quotes(named->film.empty() ? fs::path(named->pictures[0]).parent_path().generic_string()
                                      : named->film)));
    for (RawSplit& split : scene.splits)
      for (RawFrame& frame : split.frames) frame.camera = naming(frame);
    take_footage(folder, footage, scene);
    return true;
  }
  return false;
}

}  // namespace splinevox::data
