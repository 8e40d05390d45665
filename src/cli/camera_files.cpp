// SPDX-License-Identifier: Apache-2.0
#include "cli/camera_files.hpp"

#include <fmt/format.h>

#include "core/atomic_file.hpp"
#include "io/export/usd_text.hpp"
#include "run/support.hpp"

namespace splinevox::cli {
namespace {

/// A frame's number and its camera.
using Numbered = std::pair<int, Camera>;

Json matrix_of(const Camera& c) {
  Json rows = Json::array();
  for (int r = 0; r < 3; ++r) rows.push_back({c.axes[0][r], c.axes[1][r], c.axes[2][r], c.position[r]});
  rows.push_back({0, 0, 0, 1});
  return rows;
}

std::string cameras_json(const RenderFrames& frames, double fps, const TimeMap& times) {
  Json list = Json::array();
  for (std::size_t i = 0; i < frames.shown.size(); ++i) {
    const Shot& shot = frames.shots[frames.shown[i]];
    const Camera& c = shot.camera;
    list.push_back({{"frame", frames.numbers[i]},
                    {"time", times.raw(shot.time)},
                    {"w", c.width},
                    {"h", c.height},
                    {"fl_x", c.fx},
                    {"fl_y", c.fy},
                    {"cx", c.cx},
                    {"cy", c.cy},
                    {"transform_matrix", matrix_of(c)}});
  }
  return json_text({{"fps", fps}, {"frames", list}}, 1) + "\n";
}

std::string cameras_usd(const std::vector<Numbered>& cameras, double fps) {
  constexpr double kAperture = 36;  // mm of a film that no one sees; all else is in proportion to it
  const auto focal = [](const Camera& c) { return kAperture * c.fx / c.width; };
  const auto number = [](double v) { return fmt::format("{}", v); };
  std::vector<int> numbers;
  for (const auto& [frame, camera] : cameras) numbers.push_back(frame);
  std::string text = usd_head("splinevox_camera", {numbers.front(), numbers.back(), fps});
  text += "def Camera \"splinevox_camera\"\n{\n    float2 clippingRange = (0.001, 10000)\n";
  const auto attribute = [&](const char* declaration, const auto& value) {
    std::vector<std::string> values;
    for (const auto& [frame, camera] : cameras) values.push_back(value(camera));
    const auto samples =
        usd_samples(values.size(), [&](std::size_t i, std::size_t j) { return values[i] == values[j]; });
    return usd_attribute(declaration, numbers, samples, samples.size() == 1,
                         [&](std::size_t i) { return values[i]; });
  };
  text += attribute("float focalLength", [&](const Camera& c) { return number(focal(c)); });
  text += attribute("float horizontalAperture", [&](const Camera&) { return number(kAperture); });
  text += attribute("float verticalAperture",
                    [&](const Camera& c) { return number(focal(c) * c.height / c.fy); });
  text += attribute("float horizontalApertureOffset",
                    [&](const Camera& c) { return number(kAperture * (0.5 - c.cx / c.width)); });
  text += attribute("float verticalApertureOffset",
                    [&](const Camera& c) { return number(focal(c) * (c.cy - 0.5 * c.height) / c.fy); });
  text += attribute("matrix4d xformOp:transform", [&](const Camera& c) {
    std::string rows;  // USD's vectors are rows: each axis of the camera is one
    for (const Vec3d& axis : c.axes) rows += fmt::format("({}, {}, {}, 0), ", axis.x, axis.y, axis.z);
    return fmt::format("( {}({}, {}, {}, 1) )", rows, c.position.x, c.position.y, c.position.z);
  });
  return text + "    uniform token[] xformOpOrder = [\"xformOp:transform\"]\n}\n";
}

}  // namespace

void write_cameras(const std::string& folder, const RenderFrames& frames, double fps, const TimeMap& times) {
  std::vector<Numbered> cameras;
  for (std::size_t i = 0; i < frames.shown.size(); ++i)
    cameras.emplace_back(frames.numbers[i], frames.shots[frames.shown[i]].camera);
  write_file(folder + "/" + kCamerasJson, {cameras_json(frames, fps, times)});
  write_file(folder + "/" + kCamerasUsd, {cameras_usd(cameras, fps)});
}

}  // namespace splinevox::cli
