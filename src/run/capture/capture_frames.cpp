// SPDX-License-Identifier: Apache-2.0
#include "run/capture/capture_frames.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "core/atomic_file.hpp"
#include "data/file_bytes.hpp"
#include "data/layouts/masks.hpp"
#include "data/message_text.hpp"
#include "data/pictures/film_read.hpp"
#include "data/pictures/picture_header.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::run {
namespace {

namespace fs = std::filesystem;
using namespace data;

constexpr int kWalkFrames = 100;  ///< of a walk, at most

/// The size of frames whose longer side is `most` at most, with even sides. 0: as they are. Their pixels are
/// square, since lenses may have one focal length for both sides.
PictureSize frame_size(const FilmFacts& film, int most) {
  const int width = std::max(1, int(std::lround(film.width * film.pixel_aspect)));
  const PictureSize size = turned(PictureSize{width, film.height}, film.orientation());
  const int longer = std::max(size.width, size.height);
  if (most <= 0 || longer <= most) return size;
  const auto scaled = [&](int side) {
    return std::max(2, 2 * int(std::lround(0.5 * side * double(most) / longer)));
  };
  return {scaled(size.width), scaled(size.height)};
}

void plan_film_times(CapturePlan& plan, const CaptureOptions& options, CaptureTalk& talk) {
  find_capture_masks(plan.camera, options.masks);  // refuses what it cannot do
  const std::string where = printable(plan.camera.film.string());
  FilmFacts film = film_facts(plan.camera.film, where);
  for (const std::string& odd : oddities_of(film)) talk.note(where + ": " + odd);
  const PictureSize size = frame_size(film, options.max_size);
  plan.width = size.width;
  plan.height = size.height;
  plan.times = std::move(film.times);
}

/// The same moments for cameras that stand still: those of the first, up to the end of the shortest.
void share_moments(std::vector<CapturePlan>& plans, const CaptureOptions& options, CaptureTalk& talk) {
  double shortest = options.to, longest = 0;
  for (const CapturePlan& plan : plans) {
    shortest = std::min(shortest, plan.times.back());
    longest = std::max(longest, std::min(options.to, plan.times.back()));
  }
  const auto first = std::min_element(plans.begin(), plans.end(), [](const auto& a, const auto& b) {
    return a.times.back() < b.times.back();
  });
  if (options.from > first->times.back())
    fail({printable(first->camera.film.string()), "this film ends before --from",
          fmt::format("seconds of 0 to {:.3f}", first->times.back()), fmt::format("{}", options.from), ""});
  if (longest > shortest)
    talk.note(
        fmt::format("cameras were on for {:.2f} to {:.2f} seconds: what all of them saw is taken, from "
                    "the beginning of each",
                    shortest, longest));
  const int most = options.frames > 0 || !plans[0].camera.is_film() ? options.frames : kUsualFrames;
  std::vector<double> moments;
  for (const FrameGroup& group : frame_groups(plans[0].times, options.from, shortest, options.every, most))
    moments.push_back(plans[0].times[std::size_t(group.first)]);
  for (CapturePlan& plan : plans) plan.groups = frames_at(plan.times, moments);
}

/// The same moments for cameras whose pictures' names tell them: of each group that which most cameras saw. A
/// camera without a picture of it has a gap.
void share_named_moments(std::vector<CapturePlan>& plans, const CaptureOptions& options) {
  std::map<double, int> seen;  // by how many cameras
  for (const CapturePlan& plan : plans)
    for (const double time : plan.times) ++seen[time];
  std::vector<double> times;
  for (const auto& [time, cameras] : seen) times.push_back(time);
  for (const auto& [first, second] :
       frame_groups(times, options.from, options.to, options.every, options.frames)) {
    const double moment = *std::max_element(times.begin() + first, times.begin() + second,
                                            [&](double a, double b) { return seen.at(a) < seen.at(b); });
    for (CapturePlan& plan : plans) {
      const auto at = std::lower_bound(plan.times.begin(), plan.times.end(), moment);
      const int i = int(at - plan.times.begin());
      if (at != plan.times.end() && *at == moment) plan.groups.emplace_back(i, i + 1);
    }
  }
}

void require_frames(const std::vector<CapturePlan>& plans, const CaptureOptions& options) {
  for (const CapturePlan& plan : plans) {
    if (!plan.groups.empty()) continue;
    const std::string folder =
        printable((plan.camera.is_film() ? plan.camera.film : plan.camera.root).string());
    const std::string where = plan.camera.is_film() || plans.size() == 1
                                  ? folder
                                  : fmt::format("{}, camera {}", folder, printable(plan.camera.name));
    const auto begin = std::lower_bound(plan.times.begin(), plan.times.end(), options.from);
    if (begin != plan.times.end() && *begin <= options.to)
      fail({where, "has no picture of any moment that is taken of the other cameras",
            "pictures of the same moments, told by their names", "",
            "take more moments, with a smaller --every or more --frames, or leave this camera out"});
    fail({where, "no frame is between --from and --to",
          fmt::format("seconds of 0 to {:.3f}", plan.times.back()),
          fmt::format("{} to {}", options.from, options.to), ""});
  }
}

std::vector<char> png_of(std::span<const std::uint8_t> rgb, int width, int height) {
  Image image(width, height, 3);
  std::transform(rgb.begin(), rgb.end(), image.data.begin(), [](std::uint8_t v) { return float(v) / 255; });
  return encode_png(image);
}

void write_bytes(const fs::path& path, const std::vector<char>& bytes) {
  FileWriter file(path.string(), bytes.size());
  file.add({bytes.data(), bytes.size()});
  file.commit("", Wait::no);
}

void make_folders(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error)
    fail_output({printable(folder.string()), "the folder cannot be created", "", error.message(), ""});
}

std::vector<std::uint8_t> rgb_of(const Image16& picture) {
  std::vector<std::uint8_t> rgb(3 * picture.pixels());
  for (std::size_t p = 0; p < picture.pixels(); ++p)
    for (std::size_t c = 0; c < 3; ++c) rgb[3 * p + c] = std::uint8_t((picture.rgba[4 * p + c] + 128) / 257);
  return rgb;
}

/// Writes the frames of one camera and adds them to what there is.
class FrameWriter {
 public:
  FrameWriter(const CapturePlan& plan, int number, const fs::path& folder, std::vector<CaptureFrame>& frames,
              const std::function<void()>& done)
      : plan_(plan), number_(number), folder_(folder), frames_(frames), done_(done) {
    make_folders(folder / "images" / plan.camera.name);
    for (const fs::path& picture : plan.camera.pictures) ++stems_[picture.stem().string()];
  }

  void write() {
    if (plan_.camera.is_film())
      write_film();
    else
      for (const FrameGroup& group : plan_.groups) write_picture(sharpest(group));
  }

 private:
  std::string inside(const std::string& name) const {
    return plan_.camera.name.empty() ? name : plan_.camera.name + "/" + name;
  }

  /// A picture's name without its ending, unless pictures of the camera differ in that alone.
  std::string stem_of(const fs::path& picture) const {
    const std::string stem = picture.stem().string();
    return stems_.at(stem) > 1 ? picture.filename().string() : stem;
  }

  void write_film() {
    std::vector<std::uint8_t> best;
    double sharp = -1;
    int chosen = 0;
    std::size_t g = 0;
    const auto take = [&](int i, std::span<const std::uint8_t> rgb) {
      const FrameGroup& group = plan_.groups[g];
      if (i < group.first) return true;
      const bool alone = group.second - group.first == 1;
      if (const double now = alone ? 0 : sharpness(rgb, plan_.width, plan_.height); now > sharp) {
        sharp = now;
        chosen = i;
        best.assign(rgb.begin(), rgb.end());
      }
      if (i + 1 < group.second) return true;
      const std::string name = inside(fmt::format("{:06}.png", chosen));
      write_bytes(folder_ / "images" / name, png_of(best, plan_.width, plan_.height));
      frames_.push_back({name, number_, plan_.times[std::size_t(chosen)], ""});
      sharp = -1;
      done_();
      return ++g < plan_.groups.size();
    };
    read_film_scaled(plan_.camera.film, {plan_.width, plan_.height}, int(plan_.times.size()), take,
                     printable(plan_.camera.film.string()));
  }

  std::size_t sharpest(const FrameGroup& group) const {
    auto best = std::size_t(group.first);
    double sharp = -1;
    for (int i = group.first; group.second - group.first > 1 && i < group.second; ++i) {
      const Image16 picture = splinevox::read_picture(plan_.camera.pictures[std::size_t(i)]);
      const double now = sharpness(rgb_of(picture), picture.width, picture.height);
      if (now > sharp) best = std::size_t(i);
      sharp = std::max(now, sharp);
    }
    return best;
  }

  void write_picture(std::size_t i) {
    const fs::path& from = plan_.camera.pictures[i];
    const int orientation = read_picture_header(from).orientation;
    CaptureFrame frame{inside(from.filename().string()), number_, plan_.times[i], ""};
    if (orientation == 1) {
      write_file((folder_ / "images" / frame.name).string(),
                 {read_file(from.string(), kLargestFile, Named::by_user)});
    } else {  // COLMAP takes pictures as they are stored
      frame.name = inside(stem_of(from) + ".png");
      const Image16 upright = turned(splinevox::read_picture(from), orientation);
      write_bytes(folder_ / "images" / frame.name, png_of(rgb_of(upright), upright.width, upright.height));
    }
    if (i < plan_.masks.files.size() && !plan_.masks.files[i].empty()) write_masks(i, frame);
    frames_.push_back(std::move(frame));
    done_();
  }

  /// The mask as it is for training, and where COLMAP may find features.
  void write_masks(std::size_t i, CaptureFrame& frame) {
    const fs::path& from = plan_.masks.files[i];
    frame.mask = "masks/" + inside((is_dynamic_mask(from) ? "dynamic_mask_" : "") +
                                   stem_of(plan_.camera.pictures[i]) + from.extension().string());
    const fs::path own = folder_ / frame.mask, features = folder_ / "work/masks" / (frame.name + ".png");
    make_folders(own.parent_path());
    make_folders(features.parent_path());
    if (plan_.masks.turns[i] == 1) {
      write_file(own.string(), {read_file(from.string(), kLargestFile, Named::by_user)});
    } else {
      const Mask mask = read_mask(plan_.masks, i);
      Image image(mask.width, mask.height, 1);
      for (std::size_t p = 0; p < image.pixels(); ++p) image.data[p] = float(mask.white[p]) / 65535;
      frame.mask = fs::path(frame.mask).replace_extension(".png").generic_string();
      write_bytes(folder_ / frame.mask, encode_png(image));
    }
    write_bytes(features, encode_png(feature_mask(plan_.masks, i)));
  }

  const CapturePlan& plan_;
  std::map<std::string, int> stems_;  ///< how many of the camera's pictures have each
  int number_;
  const fs::path& folder_;
  std::vector<CaptureFrame>& frames_;
  const std::function<void()>& done_;
};

/// Few pictures a second tell where cameras were, and not how things moved.
void note_few_frames(const CapturePlan& plan, CaptureTalk& talk) {
  constexpr double kFew = 5, kSame = 0.9;  // a second; of the film's own rate
  if (plan.groups.size() < 2) return;
  const auto rate_of = [](std::size_t frames, double from, double to) {
    return double(frames - 1) / (to - from);
  };
  const auto time = [&](int frame) { return plan.times[std::size_t(frame)]; };
  const double rate = rate_of(plan.groups.size(), time(plan.groups.front().first),
                              time(plan.groups.back().first)),
               all = rate_of(plan.times.size(), plan.times.front(), plan.times.back());
  if (rate < kFew && rate < kSame * all)
    talk.note(
        fmt::format("{:.1f} frames a second are taken: fast motion wants 10 or more; --from and --to "
                    "take a part of the film, --frames takes more of it",
                    rate));
}

}  // namespace

std::vector<CapturePlan> plan_capture(std::vector<CaptureCamera> cameras, const CaptureOptions& options,
                                      CaptureTalk& talk) {
  PictureTimes pictures;
  if (!cameras.at(0).is_film()) pictures = picture_times(cameras, options.fps, talk);
  std::vector<CapturePlan> plans;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    plans.push_back({std::move(cameras[i]), {}, {}, 0, 0, {}});
    CapturePlan& plan = plans.back();
    if (plan.camera.is_film()) {
      plan_film_times(plan, options, talk);
    } else {
      plan.times = std::move(pictures.times.at(i));
      plan.masks = find_capture_masks(plan.camera, options.masks);
    }
  }
  CapturePlan& first = plans.at(0);
  const int most = options.frames > 0 || !first.camera.is_film() ? options.frames : kUsualFrames;
  if (plans.size() > 1 && pictures.by_names)
    share_named_moments(plans, options);
  else if (plans.size() > 1)
    share_moments(plans, options, talk);
  else
    first.groups = frame_groups(first.times, options.from, options.to, options.every, most);
  require_frames(plans, options);
  if (first.camera.is_film() && options.frames == 0 && options.every == 0) note_few_frames(first, talk);
  return plans;
}

CapturePlan plan_walk(CaptureCamera camera, const CaptureOptions& options, CaptureTalk& talk) {
  CapturePlan plan{std::move(camera), {}, {}, 0, 0, {}};
  CaptureOptions own = options;
  own.masks.clear();
  if (plan.camera.is_film()) {
    plan_film_times(plan, own, talk);
  } else {
    plan.times = ordered_times(plan.camera.pictures.size(), options.fps);
    plan.masks = find_capture_masks(plan.camera, own.masks);
  }
  plan.groups = frame_groups(plan.times, 0, plan.times.back(), 0, kWalkFrames);
  return plan;
}

std::vector<CaptureFrame> write_capture_frames(const std::vector<CapturePlan>& plans, const fs::path& folder,
                                               CaptureTalk& talk) {
  int done = 0, total = 0;
  for (const CapturePlan& plan : plans) total += int(plan.groups.size());
  std::vector<CaptureFrame> frames;
  const std::function<void()> count = [&] { talk.progress(++done, total); };
  for (std::size_t i = 0; i < plans.size(); ++i) FrameWriter(plans[i], int(i), folder, frames, count).write();
  return frames;
}

}  // namespace splinevox::run
