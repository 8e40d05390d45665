// SPDX-License-Identifier: Apache-2.0
#include "data/pictures/depth_read.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "core/in_order.hpp"
#include "core/parallel.hpp"
#include "data/file_bytes.hpp"
#include "data/layouts/folder_list.hpp"
#include "data/layouts/npy_file.hpp"
#include "data/message_text.hpp"
#include "data/npz_file.hpp"
#include "data/pictures/exr.hpp"
#include "data/pictures/pictures.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::data {
namespace {

namespace fs = std::filesystem;

constexpr const char* kKinds[] = {"metric", "relative", "inverse"};  // in the order of DepthKind
constexpr const char* kWithout = "--depth none trains without depth";

/// Numbers as a file has them.
struct Numbers {
  PictureSize size;
  std::vector<float> values;  ///< [height * width]
  bool whole = false;         ///< whole numbers: a unit is needed
};

Numbers read_png_numbers(const fs::path& path, const std::string& where) {
  const PngHeader header = read_png_header(path, where);
  if (header.bits != 16 || header.samples != 1)
    fail({where, "the depth map is no picture of depths", "a grey PNG of 16 bits",
          fmt::format("{} bits, {} channels", header.bits, header.samples), kWithout});
  const Image16 image = read_png(path, where);
  Numbers out{{image.width, image.height}, {}, true};
  for (std::size_t i = 0; i < image.pixels(); ++i) out.values.push_back(float(image.rgba[4 * i]));
  return out;
}

/// How surely a channel is depth: 0 is surest; none: it is not.
std::optional<int> rank_of(const ExrLayer& layer, const std::string& letter) {
  const std::string name = lower_case(layer.name), channel = lower_case(letter);
  const bool of_depth = name == "depth" || name.ends_with(".depth") || name.ends_with(".z") || name == "z";
  if (name.empty() && channel == "z") return 0;
  if (of_depth && (channel.empty() || channel == "z" || channel == "v" || channel == "y")) return 1;
  if (name.empty() && channel == "y") return 2;
  return {};
}

Numbers read_exr_numbers(const fs::path& path, const std::string& where) {
  const std::vector<ExrLayer> layers =
      called(where, kWithout, [&] { return read_exr_layers(path.string()); });
  const ExrLayer* layer = nullptr;
  std::size_t channel = 0, channels = 0;
  int best = 100;
  std::string all;
  for (const ExrLayer& l : layers)
    for (std::size_t c = 0; c < l.channels.size(); ++c, ++channels) {
      all += (all.empty() ? "" : ", ") + l.name + (l.name.empty() || l.channels[c].empty() ? "" : ".") +
             l.channels[c];
      const std::optional<int> rank = rank_of(l, l.channels[c]);
      if (!rank || *rank >= best) continue;
      best = *rank;
      layer = &l;
      channel = c;
    }
  if (!layer && channels == 1) layer = &layers[0];
  if (!layer)
    fail({where, "the depth map has no channel of depth", "a channel Z, depth or Y, or one alone", all,
          kWithout});
  const Image& image = layer->image;
  Numbers out{{image.width, image.height}, {}, false};
  for (std::size_t i = 0; i < image.pixels(); ++i)
    out.values.push_back(image.data[i * std::size_t(image.channels) + channel]);
  return out;
}

Numbers of_array(NpyArray array, const std::string& where) {
  const std::string shape = axes_text(array.shape);
  std::erase(array.shape, std::size_t(1));
  if (array.shape.size() != 2 || array.values.size() > kMostPixels)
    fail({where, "the depth map has not two axes", "(height, width)", shape, kWithout});
  Numbers out{{int(array.shape[1]), int(array.shape[0])}, {}, false};
  for (const double v : array.values) out.values.push_back(float(v));
  return out;
}

Numbers read_numbers(const fs::path& path, const std::string& where) {
  const std::vector<std::uint8_t> start = read_bytes(path, where, kLargestFile, 8);
  if (begins_with(start, "\x89PNG")) return read_png_numbers(path, where);
  if (begins_with(start, kExrMark)) return read_exr_numbers(path, where);
  if (begins_with(start, kNpyMark))
    return of_array(parse_npy(read_bytes(path, where, std::uintmax_t(1) << 31), where, true), where);
  if (begins_with(start, kZipMark)) return of_array(read_npz_array(path, where, "depth"), where);
  fail({where, "the depth map is of a kind that is not read",
        "a grey PNG of 16 bits, OpenEXR, or a .npy or .npz file of floats",
        start.empty() ? "an empty file" : "something else", kWithout});
}

std::string share_text(double part) { return fmt::format("{:.0f}%", 100 * part); }

}  // namespace

DepthPlan plan_depth(const fs::path& folder, const RawSplit& split, const DatasetRules& rules,
                     const std::vector<PictureSize>& sizes, int downscale) {
  DepthPlan plan;
  const auto kind = std::find(std::begin(kKinds), std::end(kKinds), rules.depth);
  plan.used = rules.depth != "none";
  plan.asked = !rules.depth.empty();
  if (plan.used && plan.asked && kind == std::end(kKinds))
    fail({"--depth", "there is no such kind of depth", "metric, relative, inverse or none",
          in_quotes(rules.depth), ""});
  plan.downscale = downscale;
  plan.sizes = sizes;
  const fs::path root = fs::canonical(folder);
  bool unit = true;
  for (std::size_t i = 0; i < split.frames.size(); ++i) {
    const RawFrame& frame = split.frames[i];
    plan.files.emplace_back();
    plan.units.push_back(frame.depth_unit);
    plan.where.push_back(printable((folder / frame.depth).string() + ", the depth of " + frame.file_path +
                                   " (" + split.name + ", frame " + std::to_string(i) + ")"));
    if (frame.depth.empty()) continue;
    const std::optional<fs::path> file = file_within(root, frame.depth);
    if (!file) {
      if (++plan.absent == 1) plan.first_absent = frame.depth;
      continue;
    }
    plan.files.back() = *file;
    unit &= frame.depth_unit.has_value();
    if (++plan.found == 1) plan.first = frame.depth;
  }
  plan.kind = plan.asked && plan.used ? DepthKind(kind - std::begin(kKinds))
              : unit                  ? DepthKind::metric
                                      : DepthKind::relative;
  return plan;
}

DepthMap read_depth(const DepthPlan& plan, std::size_t i) {
  const std::string& where = plan.where[i];
  Numbers numbers = read_numbers(plan.files[i], where);
  const PictureSize &size = numbers.size, &picture = plan.sizes[i];
  if (!same_shape(size, picture))
    fail({where, "the depth map is of another shape than its picture", size_text(picture), size_text(size),
          "make depth of the whole picture, upright; or --depth none"});
  constexpr double kThousandth = 1e-3;
  const double unit = plan.units[i].value_or(numbers.whole ? kThousandth : 1.0);
  for (float& v : numbers.values) v = float(unit * v);
  if (plan.kind == DepthKind::metric)
    if (const auto below = std::find_if(numbers.values.begin(), numbers.values.end(),
                                        [](float v) { return v < 0 && std::isfinite(v); });
        below != numbers.values.end())
      fail({where, "the depth map has depths below 0", "distances before the camera; 0 where it is not known",
            number(*below),
            "--depth relative if scale and shift are unknown, --depth inverse for disparity"});
  const PictureSize kept{std::min(size.width, picture.width / plan.downscale),
                         std::min(size.height, picture.height / plan.downscale)};
  if (kept == size) return {size.width, size.height, numbers.values, plan.kind};
  // Where a map is as small as its picture gets in one direction alone, that one is taken as it is.
  const auto middle_of = [&](int pixel, int fewer, int all, int pixels) {
    if (fewer == all) return std::int64_t(pixel);
    return (2 * std::int64_t(pixel) + 1) * plan.downscale * all / (2 * std::int64_t(pixels));
  };
  std::vector<float> fewer;
  for (int y = 0; y < kept.height; ++y)
    for (int x = 0; x < kept.width; ++x) {
      const std::int64_t u = middle_of(x, kept.width, size.width, picture.width),
                         v = middle_of(y, kept.height, size.height, picture.height);
      fewer.push_back(numbers.values[std::size_t(v * size.width + u)]);
    }
  return {kept.width, kept.height, fewer, plan.kind};
}

std::vector<DepthMap> read_depths(const DepthPlan& plan, std::size_t most) {
  std::vector<DepthMap> out(plan.files.size());
  std::vector<std::size_t> all, chosen;
  for (std::size_t i = 0; plan.used && i < out.size(); ++i)
    if (!plan.files[i].empty()) all.push_back(i);
  const std::size_t n = std::min(most, all.size());
  for (std::size_t k = 0; k < n; ++k) chosen.push_back(all[k * all.size() / n]);
  in_order(
      int(n), 2 * thread_count(),
      [&](int k) { out[chosen[std::size_t(k)]] = read_depth(plan, chosen[std::size_t(k)]); },
      [](int) { return true; });
  return out;
}

double memory_for(const DepthPlan& plan) {
  double bytes = 0;
  for (std::size_t i = 0; plan.used && i < plan.files.size(); ++i)
    if (!plan.files[i].empty())
      bytes += sizeof(std::uint16_t) * (double(plan.sizes[i].width) / plan.downscale) *
               (double(plan.sizes[i].height) / plan.downscale);
  return bytes;
}

std::optional<DatasetDepth> note_depth(const DepthPlan& plan, const std::vector<DepthMap>& maps,
                                       std::vector<std::string>& notes) {
  if (plan.absent > 0 && plan.used)
    notes.push_back(fmt::format("{} depth maps that the data names are not there, first {}", plan.absent,
                                in_quotes(plan.first_absent)));
  if (plan.found == 0 && plan.used && plan.asked)
    notes.push_back(fmt::format("--depth {} was asked for, and no picture has a depth map: none is used",
                                kKinds[int(plan.kind)]));
  if (plan.found == 0) return {};
  const std::string kind = plan.used ? kKinds[int(plan.kind)] : "none";
  DatasetDepth out{kind, plan.found, plan.files.size(), plan.first, 0, 0};
  for (const DepthMap& map : maps) {
    if (map.empty()) continue;
    ++out.looked_at;
    out.known += map.known_share();
  }
  if (out.looked_at > 0) out.known /= double(out.looked_at);
  if (!plan.used) return out;
  const std::string meaning = plan.kind == DepthKind::metric ? "in scene units"
                              : plan.kind == DepthKind::relative
                                  ? "depth but for a scale and a shift, which are fitted to each picture"
                                  : "inverse depth but for a scale and a shift, which are fitted to "
                                    "each picture";
  const std::string why =
      plan.asked ? "as --depth says"
      : plan.kind == DepthKind::metric
          ? "since depth_unit_scale_factor gives a unit; --depth relative or inverse otherwise"
          : "since no depth_unit_scale_factor gives a unit; --depth metric or inverse otherwise";
  notes.push_back(fmt::format(
      "depth of {} of {} training pictures, such as {}, known in {} of the pixels, is "
      "taken as {}: {}, {}",
      plan.found, plan.files.size(), in_quotes(plan.first), share_text(out.known), kind, meaning, why));
  return out;
}

}  // namespace splinevox::data
