// SPDX-License-Identifier: Apache-2.0
#include "run/capture/capture_input.hpp"

#include <algorithm>
#include <set>

#include "data/layouts/folder_list.hpp"
#include "data/layouts/masks.hpp"
#include "data/layouts/rig_footage.hpp"
#include "data/message_text.hpp"
#include "data/pictures/picture_header.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::run {
namespace {

namespace fs = std::filesystem;
using namespace data;

constexpr const char* kWanted =
    "a film (.mp4, .mov, .mkv, ...), a folder of PNG or JPEG, or a film or a folder per camera";
/// Where a folder that holds no pictures itself may have them.
constexpr const char* kPicturePlaces[] = {"images", "input", "frames", "rgb"};
constexpr const char* kFilmPlaces[] = {"", "videos", "films"};

bool is_picture_place(const std::string& name) {
  return std::find(std::begin(kPicturePlaces), std::end(kPicturePlaces), name) != std::end(kPicturePlaces);
}

/// The pictures in a folder, which are no masks.
std::vector<fs::path> pictures_in(const fs::path& folder) {
  std::vector<fs::path> paths;
  for (const std::string& name : without_masks(files_in(folder, FileKind::picture)))
    paths.push_back(folder / name);
  for (const fs::path& path : paths)
    if (const std::string end = lower_case(path.extension().string());
        end != ".png" && end != ".jpg" && end != ".jpeg")
      fail({printable(path.string()), "COLMAP is given PNG and JPEG alone", "pictures as a screen shows them",
            in_quotes(end), how_to_convert(path)});
  return paths;
}

CaptureCamera camera_of_film(const fs::path& film) { return {film.stem().string(), film, {}, {}}; }

CaptureCamera camera_of_folder(const fs::path& folder, std::vector<fs::path> pictures) {
  fs::path own = fs::path(folder.lexically_normal() / "").parent_path();
  const bool place = is_picture_place(own.filename().string());
  if (place) own = own.parent_path();
  const std::string name = own.filename().string();
  return {name.empty() || name == "." || name == ".." ? "camera" : name,
          {},
          std::move(pictures),
          own.empty() ? fs::path(".") : own};
}

/// Pictures of the folder itself, or in its images.
std::vector<fs::path> own_pictures(const fs::path& folder) {
  std::vector<fs::path> pictures = pictures_in(folder);
  for (const char* place : kPicturePlaces)
    if (pictures.empty()) pictures = pictures_in(folder / place);
  return pictures;
}

/// Of folders with a film each, as cameras leave them: by the folders' names, since films may have one name.
std::vector<CaptureCamera> cameras_of_film_folders(const fs::path& folder) {
  std::vector<CaptureCamera> out;
  for (const std::string& name : folders_in(folder)) {
    if (is_no_camera(name)) continue;
    const std::vector<std::string> films = files_in(folder / name, FileKind::film);
    if (films.empty()) continue;
    if (films.size() > 1)
      fail({printable((folder / name).string()), "this folder of a camera has several films", "one film",
            list_of(films),
            "join what one camera took one after the other: ffmpeg -f concat -i LIST -c copy FILM"});
    out.push_back(camera_of_film(folder / name / films[0]));
    out.back().name = name;
  }
  return out;
}

/// Data sets that say where their cameras are would lose them, and their splits would be taken for cameras.
/// A folder that capture itself made is another matter (plan_capture).
void refuse_posed(const fs::path& folder) {
  if (std::error_code ignored; fs::exists(folder / "capture.json", ignored)) return;
  for (const char* file : {"transforms.json", "transforms_train.json", "poses_bounds.npy"})
    if (std::error_code ignored; fs::exists(folder / file, ignored))
      fail({printable(folder.string()), "this data set has cameras", "films or bare pictures",
            in_quotes(file),
            "splinevox train " + printable(folder.string()) +
                "; to find cameras anew, give the films, or the folder of the pictures"});
}

std::vector<CaptureCamera> cameras_in(const fs::path& folder) {
  refuse_posed(folder);
  std::vector<CaptureCamera> films, folders;
  for (const char* place : kFilmPlaces)
    if (films.empty())
      for (const std::string& name : files_in(folder / place, FileKind::film))
        films.push_back(camera_of_film(folder / place / name));
  std::vector<fs::path> own = own_pictures(folder);
  if (films.empty() && own.empty()) films = cameras_of_film_folders(folder);
  std::vector<fs::path> places{folder};
  for (const char* place : kPicturePlaces) places.push_back(folder / place);
  for (const fs::path& place : places)
    if (own.empty() && folders.empty())
      for (const std::string& name : folders_in(place))
        if (!is_no_camera(name) && !is_picture_place(name))
          if (std::vector<fs::path> pictures = own_pictures(place / name); !pictures.empty()) {
            folders.push_back(camera_of_folder(place / name, std::move(pictures)));
            folders.back().root = folder;
          }
  if (!own.empty()) folders.push_back(camera_of_folder(folder, std::move(own)));
  if (!films.empty() && !folders.empty())
    fail({printable(folder.string()), "there are films and pictures in this folder", kWanted,
          in_quotes(films[0].film.filename().string()) + " and " +
              in_quotes(folders[0].pictures[0].filename().string()),
          "splinevox capture " + printable(films[0].film.string()) +
              " ..., or a folder of the pictures alone"});
  std::vector<CaptureCamera> found = films.empty() ? std::move(folders) : std::move(films);
  if (found.empty()) {
    const std::vector<std::string> others = files_in(folder, FileKind::other_picture);
    fail({printable(folder.string()), "there are no films and no pictures in this folder", kWanted,
          list_of(files_in(folder)), others.empty() ? "" : how_to_convert(others[0])});
  }
  return found;
}

}  // namespace

std::vector<CaptureCamera> find_capture_input(const std::vector<std::string>& sources) {
  std::vector<CaptureCamera> cameras;
  for (const std::string& source : sources) {
    std::error_code error;
    const fs::path path(source);
    const std::string where = printable(source);
    if (!fs::exists(path, error)) fail({where, "there is no such film or folder", kWanted, "", ""});
    if (!fs::is_directory(path, error)) {
      if (kind_of(path) != FileKind::film)
        fail({where, "this is no film", kWanted, in_quotes(path.filename().string()),
              "give the folder of the pictures, not one of them"});
      cameras.push_back(camera_of_film(path));
      continue;
    }
    std::vector<CaptureCamera> found = cameras_in(path);
    if (sources.size() > 1 && found.size() > 1)
      fail({where, "this folder has several cameras", "a film or a folder of pictures per camera",
            std::to_string(found.size()) + " of them", "give this folder alone"});
    if (sources.size() > 1) found[0].name = camera_of_folder(path, {}).name;
    std::move(found.begin(), found.end(), std::back_inserter(cameras));
  }
  if (cameras.size() == 1) {
    cameras[0].name.clear();
    return cameras;
  }
  std::set<std::string> names;
  for (const CaptureCamera& camera : cameras) {
    if (!names.insert(camera.name).second)
      fail({printable(camera.name), "two cameras have this name", "names of films or folders that differ", "",
            "rename one of them"});
    if (camera.is_film() != cameras[0].is_film())
      fail(
          {printable(camera.name), "some cameras have films and others pictures", "the same of all", "", ""});
  }
  return cameras;
}

MaskPlan find_capture_masks(const CaptureCamera& camera, const std::string& text) {
  const MaskUse use = parse_masks(text.empty() ? "ignore" : text);
  if (!use.used()) return {};
  if (camera.is_film()) {
    if (text.empty()) return {};
    fail({"--masks", "masks of films are not read", "a folder of pictures with masks beside them",
          printable(camera.film.string()), "take the film apart: ffmpeg -i FILM frames/%05d.png"});
  }
  const fs::path root = fs::canonical(camera.root);
  RawScene scene;
  scene.splits.push_back({"train", printable(camera.root.string()), false, {}});
  std::vector<PictureSize> sizes;
  std::vector<int> turns;
  for (const fs::path& picture : camera.pictures) {
    RawFrame frame;
    frame.found = fs::canonical(picture);
    // A link stands where its masks are looked for.
    frame.file_path =
        (fs::canonical(picture.parent_path()) / picture.filename()).lexically_relative(root).generic_string();
    scene.splits[0].frames.push_back(std::move(frame));
    const PictureHeader header = read_picture_header(picture);
    turns.push_back(header.orientation);
    sizes.push_back(turned(header.size, header.orientation));
  }
  const MaskSearch search = find_masks(root, scene);
  if (search.found == 0 && text.empty()) return {};
  if (search.found == 0 || !search.shared.empty()) require_masks(scene, use, search, {});
  return plan_masks(root, scene.splits[0], use, sizes, turns);
}

Image feature_mask(const MaskPlan& masks, std::size_t i) {
  const Mask mask = read_mask(masks, i);
  const bool around = masks.use.what == MaskUse::What::subject,
             black = masks.use.keeps_black(masks.files[i]) != around;
  Image image(mask.width, mask.height, 1);
  for (std::size_t p = 0; p < image.pixels(); ++p)
    image.data[p] = (mask.white[p] >= 32768) != black ? 1.0f : 0.0f;
  return image;
}

}  // namespace splinevox::run
