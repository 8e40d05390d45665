// SPDX-License-Identifier: Apache-2.0
#include "cli/render_layers.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "core/nearest.hpp"
#include "data/pictures/exr.hpp"
#include "run/compositing.hpp"
#include "run/edit_session.hpp"
#include "run/support.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::cli {
namespace {

const std::vector<std::string> kLayers = {"rgb", "alpha", "depth", "flow", "rigidity", "cluster"};
/// By the names and with the conventions of compositing programs.
const std::vector<std::string> kCompositing = {"RGBA", "Z", "forward", "backward", "crypto"};

bool holds(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

std::vector<std::string> all_names() {
  std::vector<std::string> names = kLayers;
  names.insert(names.end(), kCompositing.begin(), kCompositing.end());
  return names;
}

/// Motion to the shot before or behind. At either end there is none: matter goes on as it came.
/// @param held  the frame is beyond that end, where all stands still
Image vectors(const VoxelModel& model, const Rendered& r, const std::vector<Shot>& shots, std::size_t at,
              bool forward, bool held) {
  if (held) return Image(r.rgb.width, r.rgb.height, 2);
  const bool there = forward ? at + 1 < shots.size() : at > 0;
  if (there) return motion_vectors(model, r, shots[at], shots[forward ? at + 1 : at - 1]);
  if (shots.size() < 2) return Image(r.rgb.width, r.rgb.height, 2);
  Image out = motion_vectors(model, r, shots[at], shots[forward ? at - 1 : at + 1]);
  for (float& v : out.data) v = -v;
  return out;
}

}  // namespace

std::vector<std::string> chosen_layers(const std::string& text, const std::string& format) {
  std::vector<std::string> names;
  for (const std::string& name : text == "all" ? kLayers : split_list(text))
    if (!holds(names, name)) names.push_back(name);
  const std::string expected = fmt::format("a list of {}", fmt::join(all_names(), ","));
  for (const std::string& n : names) {
    if (!holds(all_names(), n))
      fail({"--layers", fmt::format("there is no layer '{}'", n), expected, text, nearest(n, all_names())});
    if (holds(kCompositing, n) && format != "exr")
      fail({"--layers", fmt::format("{} is a layer of numbers, not a picture", n), "--format exr beside it",
            format, "--format exr"});
  }
  if (names.empty()) fail({"--layers", "there is nothing to render", expected, text, ""});
  if (holds(names, "rgb") && holds(names, "RGBA"))
    fail({"--layers", "rgb and RGBA are the same channels", "one of them", text,
          "RGBA for compositing: light times alpha, without the background"});
  return names;
}

bool wants_nothing_behind(const std::vector<std::string>& names) { return holds(names, "RGBA"); }

PartPictures::PartPictures(const VoxelModel& model, const std::vector<std::string>& names, Device device) {
  if (!holds(names, "cluster") && !holds(names, "crypto")) return;
  const MotionClusters clusters = find_clusters(model, 0);
  if (holds(names, "cluster")) {
    painted_ = std::make_unique<const VoxelModel>(painted(model, clusters));
    renderer_.emplace(make_renderer(*painted_, device));
  }
  if (holds(names, "crypto")) mattes_.emplace(model, clusters, device);
}

Image PartPictures::picture(const Shot& shot, const RenderOptions& options) {
  return clamped(renderer_->render(shot.camera, shot.time, options).rgb);
}

void write_layers(const std::string& path, const VoxelModel& model, const Rendered& r, PartPictures& parts,
                  const std::vector<std::string>& names, const RenderFrames& frames, std::size_t index,
                  double fps, const RenderOptions& options) {
  const std::size_t at = frames.shown[index];
  const Shot& shot = frames.shots[at];
  ExrNotes notes{.camera = shot.camera,
                 .fps = fps,
                 .frame = frames.numbers[index],
                 .time = shot.time,
                 .color_space = ""};
  std::vector<ExrLayer> layers;
  for (const std::string& n : names) {
    if (n == "rgb") layers.push_back({"", r.rgb, {}});
    if (n == "alpha") layers.push_back({"alpha", r.alpha, {}});
    if (n == "depth") layers.push_back({"depth", r.depth, {}});
    if (n == "flow") layers.push_back({"flow", r.flow, {"X", "Y", "Z"}});
    if (n == "rigidity") layers.push_back({"rigidity", r.rigidity, {}});
    if (n == "cluster") layers.push_back({"cluster", parts.picture(shot, options), {}});
    if (n == "RGBA") layers.push_back({"", premultiplied(r), {"R", "G", "B", "A"}, true});
    if (n == "Z") layers.push_back({"Z", depth_layer(r), {}});
    if (n == "forward" || n == "backward")
      layers.push_back(
          {n, vectors(model, r, frames.shots, at, n == "forward", frames.held[index]), {"u", "v"}});
    if (n != "crypto") continue;
    for (ExrLayer& layer : parts.mattes().layers(shot.camera, shot.time, r.alpha, options))
      layers.push_back(std::move(layer));
    notes.texts = parts.mattes().attributes();
  }
  if (holds(names, "RGBA")) notes.color_space = "lin_rec709_scene";
  if (holds(names, "rgb")) notes.color_space = "srgb_rec709_scene";
  write_exr(path, layers, notes);
}

}  // namespace splinevox::cli
