// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "core/atomic_file.hpp"
#include "core/json_text.hpp"
#include "data/file_bytes.hpp"
#include "data/layouts/masks.hpp"
#include "data/layouts/read_scene.hpp"
#include "data/layouts/transforms.hpp"
#include "data/layouts/transforms_write.hpp"
#include "data/message_text.hpp"
#include "data/pictures/decode.hpp"
#include "data/pictures/encode.hpp"
#include "data/pictures/film_read.hpp"
#include "data/pictures/picture_header.hpp"
#include "data/pictures/pictures.hpp"
#include "data/pictures/premultiply.hpp"
#include "data/times/time_map.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/data/image_io.hpp"

namespace splinevox {
namespace {

namespace fs = std::filesystem;
using namespace data;
using Json = nlohmann::ordered_json;

void make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (!error && fs::is_directory(folder)) return;
  fail_output({printable(folder.string()), "the folder cannot be created", "a folder that can be written",
               error ? error.message() : "a file of that name", "choose another place with --out"});
}

/// A folder that is new or empty, and not within the data set.
void check_target(const fs::path& from, const fs::path& folder) {
  std::error_code ignored;
  if (fs::exists(folder, ignored) && !(fs::is_directory(folder, ignored) && fs::is_empty(folder, ignored)))
    fail({printable(folder.string()), "there is something of that name already",
          "an empty folder, or a name that is free", "", "another folder for --out"});
  const fs::path inside =
      fs::weakly_canonical(folder, ignored).lexically_relative(fs::weakly_canonical(from, ignored));
  if (!inside.empty() && *inside.begin() != "..")
    fail({printable(folder.string()), "the output lies within the data set", "a folder beside it", "",
          "another folder for --out"});
}

std::vector<char> png_of(const Image16& picture, int channels = 3) {
  Image image(picture.width, picture.height, channels);
  for (std::size_t p = 0; p < picture.pixels(); ++p)
    for (int c = 0; c < channels; ++c)
      image.data[std::size_t(channels) * p + std::size_t(c)] =
          float(picture.rgba[4 * p + std::size_t(c)]) / 65535;
  return encode_png(image);
}

void write_bytes(const fs::path& to, const std::vector<char>& bytes) {
  write_file(to.string(), {std::string_view(bytes.data(), bytes.size())});
}

void copy_bytes(const fs::path& from, const fs::path& to) {
  write_file(to.string(), {read_file(from.string(), kLargestFile, Named::by_user)});
}

/// The ending of a picture's name, of letters and digits: a data set may hold any.
std::string ending_of(const fs::path& picture) {
  std::string ending = picture.extension().string();
  for (std::size_t i = 1; i < ending.size(); ++i)
    if (!std::isalnum(static_cast<unsigned char>(ending[i]))) ending[i] = '_';
  return ending;
}

/// Whether a picture is not copied: it is cut out, its alpha becomes a mask, or no reader shall wonder again
/// how it is turned.
bool is_rewritten(const PicturePlan& plan, std::size_t i) {
  return plan.asked[i] != 1 || plan.masks.cuts_out(i) || plan.masks.use.of_alpha;
}

/// How the file of a frame's picture ends.
std::string new_ending(const PicturePlan& plan, std::size_t i) {
  if (plan.film()) return ".png";
  if (!is_rewritten(plan, i)) return ending_of(plan.paths[i]);
  return plan.real[i] ? ".exr" : ".png";
}

/// Where a split's pictures go, relative to the folder, with their endings.
std::vector<std::string> targets(const RawSplit& raw, const PicturePlan& plan) {
  const std::vector<std::string> names = frame_names(raw, plan);
  std::vector<std::string> paths;
  for (std::size_t i = 0; i < names.size(); ++i)
    paths.push_back(fmt::format("./{}/{}{}", raw.name, names[i], new_ending(plan, i)));
  return paths;
}

/// Where its masks go; empty for frames without one. Their names say as much as before.
std::vector<std::string> mask_targets(const RawSplit& raw, const PicturePlan& plan) {
  const std::vector<std::string> names = frame_names(raw, plan);
  const MaskPlan& masks = plan.masks;
  std::vector<std::string> paths(names.size());
  for (std::size_t i = 0; i < masks.files.size(); ++i) {
    if (masks.files[i].empty() || masks.cuts_out(i)) continue;
    const bool as_it_is = !masks.use.used(), dynamic = is_dynamic_mask(masks.files[i]),
               white_moves = as_it_is ? dynamic : masks.use.what == MaskUse::What::moving;
    paths[i] = fmt::format("./masks/{}/{}{}{}", raw.name, white_moves ? "dynamic_mask_" : "", names[i],
                           as_it_is && masks.turns[i] == 1 ? ending_of(masks.files[i]) : ".png");
  }
  return paths;
}

/// Masks that are used become black where they ignore and white where something moves, others stay what they
/// are.
void write_mask(const PicturePlan& plan, std::size_t i, const fs::path& to) {
  const MaskPlan& masks = plan.masks;
  if (!masks.use.used() && masks.turns[i] == 1) return copy_bytes(masks.files[i], to);
  const Mask mask = read_mask(masks, i);
  const bool moving = masks.use.what == MaskUse::What::moving,
             black = masks.use.used() && masks.use.keeps_black(masks.files[i]) != moving;
  Image image(mask.width, mask.height, 1);
  for (std::size_t p = 0; p < image.pixels(); ++p)
    image.data[p] = float(black ? 65535 - mask.white[p] : mask.white[p]) / 65535;
  write_bytes(to, encode_png(image));
}

/// Light and floats keep the numbers of the file, as where it is copied, so that all pictures of the new
/// folder are read alike. Others get 8 bits a channel.
void write_picture(const PicturePlan& plan, std::size_t i, const fs::path& to) {
  if (!is_rewritten(plan, i)) return copy_bytes(plan.paths[i], to);
  FilePixels pixels = kept_pixels(plan, i);
  const bool alpha = plan.masks.cuts_out(i);
  if (plan.real[i]) {
    multiply_by_alpha(pixels.real);
    write_exr(to.string(), {{plan.layer, std::move(pixels.real), {"R", "G", "B", "A"}}});
  } else {
    write_bytes(to, plan.linear[i] ? encode_png16(pixels.whole, alpha) : png_of(pixels.whole, alpha ? 4 : 3));
  }
}

void write_films(const PicturePlan& plan, const std::vector<std::string>& to, const fs::path& folder,
                 const std::function<void()>& done) {
  std::map<fs::path, std::map<int, std::size_t>> of_film;
  for (std::size_t i = 0; i < plan.paths.size(); ++i) of_film[plan.paths[i]][plan.film_frame[i]] = i;
  for (const auto& [path, frames] : of_film) {
    std::vector<int> wanted;
    std::vector<std::size_t> place;
    for (const auto& [number, i] : frames) {
      wanted.push_back(number);
      place.push_back(i);
    }
    const PictureSize& size = plan.sizes[place[0]];
    read_film(
        path, size, plan.turns[place[0]] != 1, wanted,
        [&](std::size_t k, Image16&& image) {
          write_bytes(folder / to[place[k]], png_of(image));
          done();
        },
        plan.where[place[0]]);
  }
}

}  // namespace

void convert_dataset(const std::string& path, const std::string& target, const ConvertProgress& progress,
                     const ConvertOptions& options) {
  const auto& [shift, scale, rules, on_note] = options;
  if (!(std::isfinite(scale) && scale > 0))
    fail({"--scale", "this is no scale", "a finite number above 0", fmt::format("{}", scale), ""});
  for (int a = 0; a < 3; ++a)
    if (!std::isfinite(shift[a]))
      fail({"--shift", "this is no place", "three finite numbers", fmt::format("{}", shift[a]), ""});
  const fs::path folder(target);
  check_target(path, folder);
  OpenScene open = open_scene(path, {.rules = rules});
  // A part of the time becomes all of it, as in a run.
  const auto train = std::find_if(open.scene.splits.begin(), open.scene.splits.end(),
                                  [](const RawSplit& s) { return s.name == "train"; });
  const bool part = !rules.between.empty();
  TimeMap map;
  std::vector<std::string> notes = open.scene.notes;
  if (part)
    map =
        choose_time_map(train == open.scene.splits.end() ? nullptr : &*train, open.scene.splits, notes, true);
  std::vector<PicturePlan> plans;
  std::vector<Json> files;
  int done = 0, total = 0;
  for (const RawSplit& raw : open.scene.splits) {
    plans.push_back(plan_pictures(path, raw, 1, rules));
    PicturePlan& plan = plans.back();
    plan.masks = plan_masks(path, raw, open.mask_use, plan.sizes, plan.turns);
    const std::vector<std::string> to = targets(raw, plan), masks = mask_targets(raw, plan);
    Json frames = Json::array();
    for (std::size_t i = 0; i < raw.frames.size(); ++i) {
      const Camera camera = pinhole(raw.frames[i].lens, raw.frames[i].pose, plan.sizes[i].width,
                                    plan.sizes[i].height, raw.where(i));
      Json frame{{"file_path", to[i]}, {"time", part ? model_time(raw, i, map) : raw.frames[i].time}};
      if (raw.frames[i].camera_id >= 0)
        frame["camera_id"] = open.scene.cameras[std::size_t(raw.frames[i].camera_id)].name;
      if (!masks[i].empty()) frame["mask_path"] = masks[i];
      frame.update(lens_json(camera));
      frame["transform_matrix"] = matrix_json(raw.frames[i].matrix, shift, scale);
      frames.push_back(std::move(frame));
    }
    Json file{{"source", open.format}};
    if (shift != Vec3d{}) file["shift"] = {shift.x, shift.y, shift.z};
    if (scale != 1) file["scale"] = scale;
    if (raw.name == "train" && open.scene.box) {
      const Box& b = *open.scene.box;
      const auto corner = [&](const Vec3& c) {
        return Json::array({scale * (c.x + shift.x), scale * (c.y + shift.y), scale * (c.z + shift.z)});
      };
      file["scene_box"] = {corner(b.lo), corner(b.hi)};
    }
    if (!raw.tracks.empty()) notes.push_back("tracks of points are not written");
    if (std::any_of(raw.frames.begin(), raw.frames.end(), [](const RawFrame& f) { return !f.depth.empty(); }))
      notes.push_back(raw.name + ": depth maps are not written");
    file["frames"] = std::move(frames);
    files.push_back(std::move(file));
    total += int(raw.frames.size());
  }
  if (open.mask_use.of_alpha)
    notes.emplace_back("alpha becomes masks: the new folder is read with --masks ignore");
  if (on_note)
    for (const std::string& note : notes) on_note(note);
  const auto count = [&] {
    if (progress) progress(++done, total);
  };
  make_folder(folder);
  for (std::size_t s = 0; s < plans.size(); ++s) {
    make_folder(folder / open.scene.splits[s].name);
    const std::vector<std::string> to = targets(open.scene.splits[s], plans[s]);
    if (plans[s].film()) {
      write_films(plans[s], to, folder, count);
      continue;
    }
    const std::vector<std::string> masks = mask_targets(open.scene.splits[s], plans[s]);
    if (std::any_of(masks.begin(), masks.end(), [](const std::string& m) { return !m.empty(); }))
      make_folder(folder / "masks" / open.scene.splits[s].name);
    for (std::size_t i = 0; i < to.size(); ++i) {
      write_picture(plans[s], i, folder / to[i]);
      if (!masks[i].empty()) write_mask(plans[s], i, folder / masks[i]);
      count();
    }
  }
  for (std::size_t s = 0; s < files.size(); ++s)
    write_file((folder / transforms_name(open.scene.splits[s].name)).string(),
               {dump_json(files[s], 1) + "\n"});
}

}  // namespace splinevox
