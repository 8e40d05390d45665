// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "core/parallel.hpp"
#include "core/printable.hpp"
#include "core/process.hpp"
#include "data/layouts/read_scene.hpp"
#include "data/lens_notes.hpp"
#include "data/mask_notes.hpp"
#include "data/message_text.hpp"
#include "data/pictures/decode.hpp"
#include "data/pictures/depth_read.hpp"
#include "data/pictures/picture_cache.hpp"
#include "data/pictures/picture_header.hpp"
#include "data/pictures/pictures.hpp"
#include "data/scene_notes.hpp"
#include "data/times/time_map.hpp"
#include "data/tracks/tracks_read.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/data/image_io.hpp"
#include "splinevox/data/scene.hpp"

namespace splinevox {
namespace {

namespace fs = std::filesystem;
using namespace data;

/// The run's map if it gave one, else the train split's.
TimeMap map_of(const OpenScene& open, const LoadOptions& options, std::vector<std::string>& notes) {
  if (options.time_map) return *options.time_map;
  const std::vector<RawSplit>& raw = open.scene.splits;
  const RawSplit* const train = open.train ? &*open.train : raw[0].name == "train" ? &raw[0] : nullptr;
  return choose_time_map(train, raw, notes, !options.rules.between.empty());
}

Camera camera_of(const RawSplit& raw, std::size_t i, const PicturePlan& plan) {
  return area_downscale(pinhole(raw.frames[i].lens, raw.frames[i].pose, plan.sizes[i].width,
                                plan.sizes[i].height, raw.where(i)),
                        plan.downscale);
}

/// As Frame::source. The bytes tell pictures of one name in two data sets apart. @param root  canonical
std::string source_of(const RawFrame& frame, const fs::path& root) {
  std::error_code unknown;
  const std::uintmax_t bytes = fs::file_size(frame.found, unknown);
  std::string source =
      fmt::format("{}, {} bytes", all_printable(frame.found.lexically_relative(root).generic_string()),
                  unknown ? 0 : bytes);
  if (frame.film_frame >= 0) source += fmt::format(", picture {}", frame.film_frame);
  return source;
}

/// Frames with everything but their pictures. @param root  of the data set, canonical
Split frames_of(const RawSplit& raw, const PicturePlan& plan, const TimeMap& map, const fs::path& root) {
  Split split{raw.name, {}};
  const std::vector<std::string> names = frame_names(raw, plan);
  for (std::size_t i = 0; i < raw.frames.size(); ++i) {
    const RawFrame& frame = raw.frames[i];
    split.frames.push_back(
        {names[i], camera_of(raw, i, plan), model_time(raw, i, map), {}, frame.camera_id, {}, {}});
    split.frames.back().source = source_of(frame, root);
  }
  return split;
}

void note_turns(const RawSplit& raw, const PicturePlan& plan, std::vector<std::string>& notes) {
  const auto turns = [](int t) { return t != 1; };
  const auto turned = std::count_if(plan.turns.begin(), plan.turns.end(), turns),
             not_turned = std::count_if(plan.asked.begin(), plan.asked.end(), turns) - turned;
  const std::string all = " of " + std::to_string(plan.turns.size()) + " pictures ",
                    says = plan.film() ? "as their film says" : "as their EXIF says";
  if (turned > 0)
    notes.push_back(raw.name + ": " + std::to_string(turned) + all + "are turned upright, " + says);
  if (not_turned > 0)
    notes.push_back(raw.name + ": " + std::to_string(not_turned) + all + "are taken as stored, not turned " +
                    says +
                    (plan.guessed ? "; their size does not tell whether their cameras are for that"
                                  : ": their cameras are for the stored pixels"));
  if (plan.masks.guessed > 0)
    notes.push_back(raw.name + ": " + std::to_string(plan.masks.guessed) +
                    " masks are turned as their pictures are; their size does not tell whether they were "
                    "upright already");
}

/// Decodes one split's pictures into memory.
std::vector<PictureFacts> fill_pictures(Split& split, const PicturePlan& plan, bool keep) {
  std::vector<PictureFacts> facts(plan.paths.size());
  decode(plan, [&](std::size_t i, Picture&& picture, const PictureFacts& f) {
    facts[i] = f;
    if (keep) split.frames[i].image = std::move(picture);
  });
  return facts;
}

std::string gigabytes(double bytes) { return fmt::format("{:.{}f} GB", bytes / 1e9, bytes < 1e9 ? 2 : 1); }

/// Whether the pictures must live in a file. `depths`: bytes of depth maps. Throws Error (input) if not even
/// those that are decoded at once fit into memory.
bool outgrow(const std::vector<PicturePlan>& plans, double depths, const Dataset& dataset,
             const LoadOptions& options, std::vector<std::string>& notes) {
  PictureMemory all;
  double bits = 0;  // of masks, in memory always
  for (const PicturePlan& plan : plans) {
    const PictureMemory one = memory_for(plan, thread_count());
    all.kept += one.kept;
    all.passing = std::max(all.passing, one.passing);
    if (plan.masks.use.what == MaskUse::What::ignore) bits += one.pixels;
  }
  const double room = (options.room ? options.room(dataset) : usable_memory()) - bits / 8 - depths;
  const bool outgrown = options.keep && all.kept > room;
  if (all.passing > room)
    fail({plans[0].where[0], "the pictures that are decoded at once do not fit into memory",
          "at most " + gigabytes(room), gigabytes(all.passing),
          "--downscale " + std::to_string(2 * plans[0].downscale) + ", fewer --threads, or more --memory"});
  if (outgrown)
    notes.push_back(
        fmt::format("pictures of {} are more than the {} of memory that are left for them: they are "
                    "kept in files of a cache",
                    gigabytes(all.kept), gigabytes(room)));
  return outgrown;
}

/// The same through a file.
std::vector<PictureFacts> map_pictures(Split& split, const PicturePlan& plan, const std::string& folder,
                                       const std::string& dataset, std::vector<std::string>& notes) {
  const PictureCache cache = cache_of(folder, dataset, split.name, plan);
  StoredPictures stored = through_cache(cache, plan, notes);
  for (std::size_t i = 0; i < stored.pictures.size(); ++i)
    split.frames[i].image = std::move(stored.pictures[i]);
  std::error_code unknown;
  notes.push_back(fmt::format("{}: pictures are in {} ({}), which is used again and may be deleted",
                              split.name, all_printable(cache.path),
                              gigabytes(double(fs::file_size(cache.path, unknown)))));
  return std::move(stored.facts);
}

/// What masks say of a split's pixels. A picture of which all is ignored is left out, with what was recorded
/// of it.
void fill_masks(const LoadOptions& options, const PicturePlan& plan, RawSplit& raw, Split& split,
                std::vector<PictureFacts>& facts, std::vector<std::string>& notes) {
  const MaskPlan& masks = plan.masks;
  const bool ignore = masks.use.what == MaskUse::What::ignore;
  if (masks.use.what == MaskUse::What::unsaid && options.inside) {
    try {
      std::vector<PixelMask> inside = read_inside(masks, plan.downscale);
      for (std::size_t i = 0; i < inside.size(); ++i) split.frames[i].inside = std::move(inside[i]);
    } catch (const Error& error) {
      notes.push_back("nothing is measured inside the masks: " + error.problem.where + ": " +
                      error.problem.what);
    }
  }
  if (masks.use.what == MaskUse::What::moving) {
    std::vector<CoarseMask> moving = read_moving(masks, plan.sizes, plan.downscale);
    for (std::size_t i = 0; i < moving.size(); ++i) split.frames[i].moving = std::move(moving[i]);
  }
  if (!ignore) return;
  std::vector<PixelMask> ignored = read_ignored(masks, plan.downscale);
  std::size_t kept = 0, out = 0;
  std::string first;
  for (std::size_t i = 0; i < ignored.size(); ++i) {
    if (ignored[i].all()) {
      if (++out == 1) first = split.frames[i].name;
      continue;
    }
    split.frames[i].ignored = std::move(ignored[i]);
    if (kept != i) {
      split.frames[kept] = std::move(split.frames[i]);
      raw.frames[kept] = std::move(raw.frames[i]);
      facts[kept] = facts[i];
    }
    ++kept;
  }
  if (out == 0) return;
  if (kept == 0)
    fail({raw.file, "the masks ignore every pixel of the " + raw.name + " split",
          "pictures of which something is left", "--masks " + masks.use.text,
          opposite_masks(masks.use, masks.use.keeps_black(raw.frames[0].mask_file))});
  notes.push_back(raw.name + ": " + std::to_string(out) + " of " + std::to_string(ignored.size()) +
                  " pictures are left out because their masks ignore all of them, first " + first);
  split.frames.resize(kept);
  raw.frames.resize(kept);
  facts.resize(kept);
}

/// Whether the first picture of a split, the middle one or the last has a pixel with alpha < 1: a channel for
/// it says nothing.
bool some_see_through(const PicturePlan& plan) {
  const std::size_t n = plan.paths.size();
  for (const std::size_t i : {std::size_t(0), n / 2, n - 1}) {
    if (!decode_one(plan, i).picture.opaque()) return true;
  }
  return false;
}

void note_sizes(const std::vector<PicturePlan>& plans, const std::vector<RawSplit>& raw,
                std::vector<std::string>& notes) {
  for (std::size_t s = 0; s < plans.size(); ++s) {
    const std::vector<PictureSize>& sizes = plans[s].sizes;
    const PictureSize &first = sizes[0], &of_all = plans[0].sizes[0];
    const auto others = std::ptrdiff_t(sizes.size()) - std::count(sizes.begin(), sizes.end(), first);
    if (others > 0)
      notes.push_back(fmt::format("{}: {} of {} pictures are not of {} as the first", raw[s].name, others,
                                  sizes.size(), size_text(first)));
    const bool mixed = others > 0 || std::count(plans[0].sizes.begin(), plans[0].sizes.end(), of_all) <
                                         std::ptrdiff_t(plans[0].sizes.size());
    if (!mixed && first != of_all)
      notes.push_back(fmt::format("{}: pictures of {}, {} has {}", raw[s].name, size_text(first), raw[0].name,
                                  size_text(of_all)));
    const int downscale = plans[s].downscale;
    const auto rest = std::find_if(sizes.begin(), sizes.end(), [&](const PictureSize& size) {
      return size.width % downscale > 0 || size.height % downscale > 0;
    });
    if (rest != sizes.end())
      notes.push_back(fmt::format(
          "{}: of pictures of {} the last {} columns and {} rows fill no block of --downscale {} and are "
          "left out",
          raw[s].name, size_text(*rest), rest->width % downscale, rest->height % downscale, downscale));
  }
}

}  // namespace

Dataset load_dataset(const std::string& path, const LoadOptions& options) {
  const fs::path folder(path);
  if (options.downscale < 1)
    fail(
        {"--downscale", "out of range", "a whole number, at least 1", std::to_string(options.downscale), ""});
  OpenScene open = open_scene(folder, options);
  std::vector<RawSplit>& raw = open.scene.splits;
  Dataset dataset;
  dataset.path = path;
  dataset.format = open.format;
  dataset.box = open.scene.box;
  dataset.cameras = open.scene.cameras;
  dataset.notes = open.scene.notes;
  dataset.downscale = options.downscale;
  dataset.time_map = map_of(open, options, dataset.notes);
  std::vector<PicturePlan> plans;
  const fs::path root = fs::canonical(folder);
  for (const RawSplit& split : raw) {
    plans.push_back(plan_pictures(folder, split, options.downscale, options.rules));
    PicturePlan& plan = plans.back();
    plan.masks = plan_masks(folder, split, open.mask_use, plan.sizes, plan.turns);
    note_turns(split, plan, dataset.notes);
    note_transfer(split, plan, dataset.notes);
    dataset.splits.push_back(frames_of(split, plan, dataset.time_map, root));
    note_times(split, dataset.time_map, dataset.notes);
    note_cameras(split, dataset.notes);
    note_lenses(split, dataset.splits.back(), dataset.notes);
  }
  note_sizes(plans, raw, dataset.notes);
  dataset.masks = note_masks(open, plans, dataset.notes);
  std::optional<DepthPlan> depth;
  if (options.depth && raw[0].name == "train") {
    depth = plan_depth(folder, raw[0], options.rules, plans[0].sizes, options.downscale);
    constexpr std::size_t kLooks = 32;  // where nobody asks for pixels
    std::vector<DepthMap> maps = read_depths(*depth, options.pixels ? depth->files.size() : kLooks);
    dataset.depth = note_depth(*depth, maps, dataset.notes);
    for (std::size_t i = 0; options.pixels && i < maps.size(); ++i)
      dataset.splits[0].frames[i].depth = std::move(maps[i]);
  }
  if (options.tracks && raw[0].name == "train")
    dataset.tracks =
        read_tracks(folder, open, options, plans[0].sizes, dataset.splits[0].frames, dataset.notes);
  if (!options.pixels || options.room) {
    const bool may = plans[0].alpha || open.mask_use.what == MaskUse::What::subject;
    try {
      dataset.has_alpha = may && !plans[0].film() && some_see_through(plans[0]);
    } catch (const Error&) {
      if (!options.pixels) throw;  // else whoever decodes all names the first bad one
    }
  }
  if (!options.pixels) return dataset;
  const bool outgrown = outgrow(plans, depth ? memory_for(*depth) : 0, dataset, options, dataset.notes);
  dataset.has_alpha = false;  // what all pictures say follows
  const std::string cache = outgrown ? cache_folder(options.cache) : "";
  for (std::size_t s = 0; s < raw.size(); ++s) {
    Split& split = dataset.splits[s];
    std::vector<PictureFacts> facts = outgrown ? map_pictures(split, plans[s], cache, path, dataset.notes)
                                               : fill_pictures(split, plans[s], options.keep);
    note_facts(split, facts, dataset.notes);
    fill_masks(options, plans[s], raw[s], split, facts, dataset.notes);
    for (const Frame& f : split.frames)
      (outgrown ? dataset.pictures_in_files : dataset.pictures_in_memory) +=
          double(f.image.layout().size(f.image.pixels()));
    if (raw[s].name == "train") dataset.fingerprint = fingerprint_of(raw[s], split, facts);
    if (raw[s].name == "train" || raw[0].name != "train")
      for (const PictureFacts& f : facts) dataset.has_alpha |= f.see_through;
  }
  return dataset;
}

}  // namespace splinevox
