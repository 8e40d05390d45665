// SPDX-License-Identifier: Apache-2.0
#include "data/pictures/pictures.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <string_view>

#include "core/printable.hpp"
#include "data/message_text.hpp"
#include "data/pictures/picture_header.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/data/image_io.hpp"

namespace splinevox::data {
namespace {

void require_blocks(const PicturePlan& plan, std::size_t i) {
  const int shorter = std::min(plan.sizes[i].width, plan.sizes[i].height);
  if (plan.downscale > shorter)
    fail({plan.where[i], "--downscale " + std::to_string(plan.downscale) + " leaves nothing of the image",
          "at most its shorter side, " + std::to_string(shorter), size_text(plan.sizes[i]), ""});
}

}  // namespace

std::string size_text(const PictureSize& size) {
  return std::to_string(size.width) + " x " + std::to_string(size.height);
}

bool same_shape(const PictureSize& a, const PictureSize& b) {
  const std::int64_t off = std::int64_t(a.width) * b.height - std::int64_t(b.width) * a.height;
  return std::abs(off) <= std::max(a.width, b.width);
}

namespace {

/// How far a lens is from being that of a picture of this size; 0 fits. Nothing if the lens does not say.
std::optional<double> misfit(const Lens& lens, const PictureSize& size) {
  const double w = size.width, h = size.height;
  if (lens.w && lens.h && *lens.w > 0 && *lens.h > 0)
    return lens.scaled ? std::abs(std::log(*lens.w / *lens.h * h / w))
                       : std::abs(*lens.w - w) + std::abs(*lens.h - h);
  if (lens.camera_angle_x && lens.camera_angle_y)
    return std::abs(
        std::log(std::tan(*lens.camera_angle_x / 2) / std::tan(*lens.camera_angle_y / 2) * h / w));
  if (lens.cx && lens.cy) return std::abs(2 * *lens.cx - w) + std::abs(2 * *lens.cy - h);
  return {};
}

/// Whether a turned picture's camera is for the picture upright; nothing if its size does not tell, as after
/// a half turn.
std::optional<bool> told_upright(const PictureHeader& header, const Lens& lens) {
  const auto as_stored = misfit(lens, header.size),
             as_turned = misfit(lens, turned(header.size, header.orientation));
  if (!as_stored || !as_turned || *as_stored == *as_turned) return {};
  return *as_turned < *as_stored;
}

}  // namespace

PicturePlan plan_pictures(const std::filesystem::path& folder, const RawSplit& split, int downscale,
                          const DatasetRules& rules) {
  const std::string& transfer = rules.transfer;
  if (!transfer.empty() && transfer != "srgb" && transfer != "linear")
    fail({"--transfer", "there is no such transfer", "srgb or linear", transfer, ""});
  const std::filesystem::path root = std::filesystem::canonical(folder);
  PicturePlan plan;
  plan.downscale = downscale;
  plan.layer = rules.layer;
  std::map<std::filesystem::path, PictureHeader> headers;  // frames may name one file again and again
  for (std::size_t i = 0; i < split.frames.size(); ++i) {
    plan.paths.push_back(split.frames[i].found);
    const std::string shown = printable((folder / plan.paths[i].lexically_relative(root)).string());
    plan.where.push_back(shown + " (" + split.name + ", frame " + std::to_string(i) + ")");
    plan.film_frame.push_back(split.frames[i].film_frame);
    PictureHeader header;
    if (plan.film()) {
      header = {.size = split.frames[i].film_size, .orientation = split.frames[i].film_turn};
    } else {
      const auto [known, first] = headers.try_emplace(plan.paths[i]);
      if (first) known->second = read_picture_header(plan.paths[i], plan.where[i], rules.layer);
      header = known->second;
    }
    const Lens& lens = split.frames[i].lens;
    plan.alpha |= header.alpha;
    const bool cut = !split.frames[i].mask_file.empty();
    plan.real.push_back(header.real);
    plan.linear.push_back(transfer.empty() ? header.real || header.linear : transfer == "linear");
    const bool deep = header.deep || downscale > 1 || plan.linear.back();
    plan.pixel_bytes.push_back((header.alpha || cut ? 4 : 3) * (deep ? 2 : 1));
    const auto told = told_upright(header, lens);
    plan.guessed |= header.orientation != 1 && !told && !plan.film();
    plan.turns.push_back(told.value_or(plan.film()) ? header.orientation : 1);
    plan.asked.push_back(header.orientation);
    plan.sizes.push_back(turned(header.size, plan.turns.back()));
    const PictureSize &first = plan.sizes[0], &size = plan.sizes.back();
    const bool differs = size != first;
    if (i == 0 || differs) require_blocks(plan, i);
    if (differs && !(lens.fl_x && lens.w && lens.h))  // which pinhole compares with the picture
      fail({plan.where[i], "the images of a split differ in size",
            size_text(first) + " as in " + printable(plan.paths[0].filename().string()),
            size_text(size) + " in " + printable(plan.paths[i].filename().string()),
            "render or crop them to one size, or give every frame its lens in pixels (w, h, fl_x, fl_y, cx, "
            "cy)"});
  }
  return plan;
}

void note_transfer(const RawSplit& raw, const PicturePlan& plan, std::vector<std::string>& notes) {
  const auto linear = std::count(plan.linear.begin(), plan.linear.end(), char(1)),
             real = std::count(plan.real.begin(), plan.real.end(), char(1));
  const auto all = std::ptrdiff_t(plan.linear.size());
  const auto count = [&](std::ptrdiff_t n) {
    return std::to_string(n) + " of " + std::to_string(all) + " pictures";
  };
  if (linear > 0)
    notes.push_back(
        raw.name + ": " + count(linear) +
        " are taken as linear light (--transfer srgb otherwise) and trained as a screen shows them, by "
        "the curve of sRGB, beyond 1 too");
  if (real > linear)
    notes.push_back(raw.name + ": " + count(real - linear) +
                    " hold floats that are taken as a screen shows them, as --transfer srgb says");
}

namespace {

/// Whether a character beyond ASCII is a letter, or part of one: no sign, no blank, nothing that is not seen.
bool is_letter(char32_t c) {
  const auto within = [c](char32_t lo, char32_t hi) { return c >= lo && c <= hi; };
  const bool sign = within(0x80, 0xbf) || c == 0xd7 || c == 0xf7 || within(0x2000, 0x2bff) ||
                    within(0x2e00, 0x2e7f) || within(0x3000, 0x3004) || within(0x3008, 0x3020) ||
                    within(0xfe00, 0xfe6f) || within(0xff00, 0xff0f) || within(0xff1a, 0xff20) ||
                    within(0xff3b, 0xff40) || within(0xff5b, 0xff65);
  const bool unseen = is_control(c) || c == 0x1680 || c == 0x180e || c == 0xfeff || within(0xd800, 0xf8ff) ||
                      within(0xfff0, 0xffff) || c >= 0xe0000;
  return !sign && !unseen;
}

/// Letters of any script, digits and `. _ -` and blanks alone: what means nothing to a shell, a path, a table
/// or a page. The name of a frame becomes that of files, and stands in what people and programs read.
std::string plain(std::string_view name) {
  std::string out;
  for (std::size_t i = 0; i < name.size();) {
    const std::string_view rest = name.substr(i);
    const std::size_t length = utf8_length(rest);
    const auto first = static_cast<unsigned char>(rest[0]);
    const bool good = length == 1 ? std::isalnum(first) || std::string_view("._- ").find(rest[0]) != rest.npos
                                  : length > 1 && is_letter(utf8_code(rest, length));
    if (good)
      out += rest.substr(0, length);
    else
      out += '_';
    i += std::max<std::size_t>(length, 1);
  }
  return out.empty() || out[0] == '.' || out[0] == '-' ? "_" + out : out;
}

}  // namespace

std::vector<std::string> frame_names(const RawSplit& raw, const PicturePlan& plan) {
  std::vector<std::string> names;
  std::map<std::string, int> frames;
  for (std::size_t i = 0; i < raw.frames.size(); ++i) {
    names.push_back(plain(raw.frames[i].name.empty() ? plan.paths[i].stem().string() : raw.frames[i].name));
    ++frames[names.back()];
  }
  std::set<std::string> taken;
  std::map<std::string, int> numbered;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (frames[names[i]] > 1)
      names[i] = plain(plan.paths[i].parent_path().filename().string()) + "_" +
                 names[i];  // cam01/0007.png and cam02/0007.png
    const std::string name = names[i];
    if (taken.insert(name).second) continue;
    int& k = numbered.try_emplace(name, 2).first->second;  // all below are taken
    while (!taken.insert(names[i] = name + "_" + std::to_string(k)).second) ++k;
  }
  return names;
}

}  // namespace splinevox::data
