// SPDX-License-Identifier: Apache-2.0
#include "data/tracks/flow_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <map>
#include <utility>

#include "data/file_bytes.hpp"
#include "data/layouts/folder_list.hpp"
#include "data/layouts/npy_file.hpp"
#include "data/message_text.hpp"
#include "data/npz_file.hpp"
#include "data/pictures/exr.hpp"
#include "data/tracks/followed.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::data {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFlowShape = "(height, width, 2) or (2, height, width)";

/// https://vision.middlebury.edu/flow/code/flow-code/README.txt: a float that spells "PIEH", width, height,
/// then pairs of floats; what is not known is larger than 1e9.
FlowField parse_flo(const std::vector<std::uint8_t>& bytes, const std::string& where) {
  constexpr std::size_t kHeader = 12;
  constexpr float kUnknown = 1e9f;
  std::int32_t side[2] = {0, 0};
  if (bytes.size() >= kHeader) std::memcpy(side, bytes.data() + 4, sizeof side);
  const bool sound =
      side[0] > 0 && side[1] > 0 && std::uint64_t(side[0]) * std::uint64_t(side[1]) <= kMostPixels;
  const std::size_t values = sound ? 2 * std::size_t(side[0]) * std::size_t(side[1]) : 0;
  if (!sound || bytes.size() != kHeader + values * sizeof(float))
    fail({where, "the flow is not whole",
          fmt::format("{} bytes, of {} x {} pixels", kHeader + 4 * values, side[0], side[1]),
          fmt::format("{} bytes", bytes.size()), kWithoutTracks});
  FlowField out{{side[0], side[1]}, std::vector<float>(values)};
  std::memcpy(out.values.data(), bytes.data() + kHeader, values * sizeof(float));
  for (float& v : out.values)
    if (!(std::abs(v) <= kUnknown)) v = std::numeric_limits<float>::quiet_NaN();
  return out;
}

FlowField of_array(const NpyArray& array, const std::string& where) {
  const std::vector<std::size_t> shape = without_batch(array.shape, 3);
  const bool last = shape.size() == 3 && shape[2] == 2, first = shape.size() == 3 && shape[0] == 2;
  if (last == first || array.values.empty() || array.values.size() / 2 > kMostPixels)
    fail({where, "the flow is of another shape", kFlowShape, axes_text(array.shape), kWithoutTracks});
  const std::size_t height = shape[last ? 0 : 1], width = shape[last ? 1 : 2], pixels = height * width;
  FlowField out{{int(width), int(height)}, std::vector<float>(2 * pixels)};
  for (std::size_t i = 0; i < pixels; ++i)
    for (std::size_t a = 0; a < 2; ++a)
      out.values[2 * i + a] = float(array.values[last ? 2 * i + a : a * pixels + i]);
  return out;
}

/// A channel of a file.
struct ExrChannel {
  const ExrLayer* layer;
  std::size_t index;
  float at(std::size_t pixel) const { return layer->image.data[pixel * layer->channels.size() + index]; }
};

/// Channels u and v before red and green; those of no layer before those of the layer called as the way that
/// is asked for, and these before those of the only layer that has any.
FlowField read_exr_flow(const fs::path& path, const std::string& where, FlowWay way) {
  const std::vector<ExrLayer> layers =
      called(where, kWithoutTracks, [&] { return read_exr_layers(path.string()); });
  std::map<std::string, ExrChannel> channels;
  for (const ExrLayer& layer : layers)
    for (std::size_t c = 0; c < layer.channels.size(); ++c) {
      const std::string& letter = layer.channels[c];
      const bool both = !layer.name.empty() && !letter.empty();
      channels.emplace(lower_case(layer.name + (both ? "." : "") + letter), ExrChannel{&layer, c});
    }
  const std::string named = way == FlowWay::forward ? "forward." : "backward.";
  for (const auto& [right, down] : {std::pair{"u", "v"}, {"r", "g"}}) {
    std::vector<std::string> of;  // layers, with a dot after each
    for (const auto& [name, channel] : channels) {
      if (!name.ends_with(right)) continue;
      const std::string layer = name.substr(0, name.size() - 1);
      if ((layer.empty() || layer.ends_with('.')) && channels.contains(layer + down)) of.push_back(layer);
    }
    const auto has = [&](const std::string& layer) {
      return std::find(of.begin(), of.end(), layer) != of.end();
    };
    if (of.empty()) continue;
    if (!has("") && !has(named) && of.size() > 1)
      fail({where, "it is not clear which layer is the flow",
            fmt::format("one layer, or one named {}", named.substr(0, named.size() - 1)),
            printable(fmt::format("{}", fmt::join(of, " "))), kWithoutTracks});
    const std::string layer = has("") ? "" : has(named) ? named : of[0];
    const ExrChannel &u = channels.at(layer + right), &v = channels.at(layer + down);
    const Image& image = u.layer->image;
    FlowField out{{image.width, image.height}, {}};
    out.values.reserve(2 * image.pixels());
    for (std::size_t i = 0; i < image.pixels(); ++i) out.values.insert(out.values.end(), {u.at(i), v.at(i)});
    return out;
  }
  std::vector<std::string> names;
  for (const auto& [name, channel] : channels) names.push_back(printable(name));
  fail({where, "there are no channels of flow in it", "channels u and v, or R and G",
        fmt::format("{}", fmt::join(names, ", ")), kWithoutTracks});
}

}  // namespace

std::optional<PixelPlace> FlowField::at(PixelPlace place) const {
  if (!(place.u >= 0 && place.v >= 0 && place.u <= size.width && place.v <= size.height)) return {};
  // Beyond the centres of the pixels at the border flow is as it is there.
  const double x = std::clamp(place.u - 0.5, 0.0, double(size.width - 1)),
               y = std::clamp(place.v - 0.5, 0.0, double(size.height - 1));
  const int x0 = std::min(int(x), std::max(0, size.width - 2)),
            y0 = std::min(int(y), std::max(0, size.height - 2));
  PixelPlace out;
  for (int i = 0; i < 4; ++i) {
    const int px = std::min(x0 + (i & 1), size.width - 1), py = std::min(y0 + (i >> 1), size.height - 1);
    const double wx = i & 1 ? x - x0 : 1 - (x - x0), wy = i >> 1 ? y - y0 : 1 - (y - y0);
    const float* way = values.data() + 2 * (std::size_t(py) * std::size_t(size.width) + std::size_t(px));
    if (wx * wy > 0) out = {out.u + wx * wy * way[0], out.v + wx * wy * way[1]};
  }
  if (!std::isfinite(out.u) || !std::isfinite(out.v)) return {};
  return out;
}

FlowField read_flow(const fs::path& path, const std::string& where, FlowWay way) {
  const std::vector<std::uint8_t> start = read_bytes(path, where, kLargestFile, 8);
  if (begins_with(start, "PIEH")) return parse_flo(read_bytes(path, where, kLargestFile), where);
  if (begins_with(start, kNpyMark))
    return of_array(parse_npy(read_bytes(path, where, kLargestFile), where, true), where);
  if (begins_with(start, kZipMark)) return of_array(read_npz_array(path, where, "flow"), where);
  if (begins_with(start, kExrMark)) return read_exr_flow(path, where, way);
  fail({where, "flow of this kind is not read", "a .flo, .npy, .npz or OpenEXR file",
        start.empty() ? "an empty file" : "something else", kWithoutTracks});
}

FlowFiles find_flow(const fs::path& folder, const std::string& where) {
  FlowFiles out;
  for (const std::string& name : files_in(folder)) {
    const std::string lower = lower_case(name), ending = lower_case(fs::path(name).extension().string());
    if (ending != ".flo" && ending != ".npy" && ending != ".npz" && ending != ".exr") continue;
    if (name.starts_with('.')) continue;  // macOS leaves ._a.flo beside a.flo
    const bool back = lower.find("bwd") != std::string::npos || lower.find("backward") != std::string::npos;
    (back ? out.backward : out.forward).push_back(name);
  }
  if (out.forward.empty())
    fail({where, "there is no flow in this folder",
          "files .flo, .npy, .npz or .exr, one from each picture to the next", list_of(files_in(folder)),
          kWithoutTracks});
  if (!out.backward.empty() && out.backward.size() != out.forward.size())
    fail({where, "there is not as much flow backward as forward",
          fmt::format("{} files each", out.forward.size()),
          fmt::format("{} with bwd or backward in their names", out.backward.size()), kWithoutTracks});
  return out;
}

}  // namespace splinevox::data
