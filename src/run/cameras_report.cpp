// SPDX-License-Identifier: Apache-2.0
#include "run/cameras_report.hpp"

#include <fmt/format.h>

#include <cmath>

#include "run/html.hpp"

namespace splinevox::run {
namespace {

std::string gain_text(const Json& camera) {
  std::string text;
  for (const Json& g : camera.at("gain"))
    text += fmt::format("{}{:.3f}", text.empty() ? "" : " ", g.get<double>());
  return text;
}

std::string clock_text(const Json& camera) {
  const double frames = camera.at("offset_frames").get<double>();
  return fmt::format("{:.2f} frames {}", std::abs(frames), frames < 0 ? "early" : "late");
}

}  // namespace

Json cameras_json(const Dataset& data, const CamerasConfig& learned, const CameraFits& fits) {
  Json out = Json::array();
  for (std::size_t c = 0; c < fits.cameras.size() && c < data.cameras.size(); ++c) {
    const CameraFit& fit = fits.cameras[c];
    if (!fit.trained) continue;
    Json camera{{"name", data.cameras[c].name}};
    if (learned.exposure) camera["gain"] = {fit.gain.x, fit.gain.y, fit.gain.z};
    if (learned.clock) {
      camera["offset"] = fit.offset;
      camera["offset_frames"] = fit.offset / fit.interval;
    }
    out.push_back(std::move(camera));
  }
  return out;
}

std::string camera_line(const Json& camera) {
  std::string line = camera.value("name", "") + ":";
  if (camera.contains("gain")) line += " gain " + gain_text(camera);
  if (camera.contains("offset_frames")) line += (camera.contains("gain") ? ", " : " ") + clock_text(camera);
  return line;
}

std::string cameras_table(const Json& cameras) {
  if (!cameras.is_array() || cameras.empty()) return {};
  std::string html =
      "<h3>Cameras</h3><table><tr><th>camera</th><th>gain, red green blue</th><th>clock</th></tr>";
  for (const Json& c : cameras)
    html +=
        fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td></tr>", escape(c.value("name", "")),
                    c.contains("gain") ? gain_text(c) : "", c.contains("offset_frames") ? clock_text(c) : "");
  return html + "</table>";
}

}  // namespace splinevox::run
