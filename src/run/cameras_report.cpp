// SPDX-License-Identifier: Apache-2.0
#include "run/cameras_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

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

/// The largest of a channel's gains over the least, of the channel where that is most; 1: they do not drift.
double drift_of(const Json& camera) {
  double most = 1;
  for (std::size_t a = 0; a < 3; ++a) {
    std::vector<double> gains;
    for (const Json& gain : camera.at("gains"))
      if (a < gain.size()) gains.push_back(gain[a].get<double>());
    if (gains.empty()) continue;
    const auto [least, largest] = std::minmax_element(gains.begin(), gains.end());
    most = std::max(most, *largest / *least);
  }
  return most;
}

std::string exposure_text(const Json& camera) {
  std::string text = gain_text(camera);
  if (camera.contains("gains")) text += fmt::format(", drifting by a factor of {:.2f}", drift_of(camera));
  return text;
}

}  // namespace

Json cameras_json(const Dataset& data, const CamerasConfig& learned, const CameraFits& fits) {
  Json out = Json::array();
  for (std::size_t c = 0; c < fits.cameras.size() && (fits.film || c < data.cameras.size()); ++c) {
    const CameraFit& fit = fits.cameras[c];
    if (!fit.trained) continue;
    Json camera{{"name", fits.film ? "film" : data.cameras[c].name}};
    if (learned.exposure || learned.drift) {
      Vec3 mean;  // geometric, over time
      for (int a = 0; a < 3; ++a) mean[a] = float(std::exp(fit.mean_log(a)));
      camera["gain"] = triple(mean);
    }
    if (learned.drift) {
      camera["gains"] = Json::array();
      for (const Vec3& gain : fit.gains) camera["gains"].push_back(triple(gain));
    }
    if (learned.clock && !fits.film) {
      camera["offset"] = fit.offset;
      camera["offset_frames"] = fit.offset / fit.interval;
    }
    out.push_back(std::move(camera));
  }
  return out;
}

std::string camera_line(const Json& camera) {
  std::string line = camera.value("name", "") + ":";
  if (camera.contains("gain")) line += " gain " + exposure_text(camera);
  if (camera.contains("offset_frames")) line += (camera.contains("gain") ? ", " : " ") + clock_text(camera);
  return line;
}

std::string cameras_table(const Json& cameras) {
  if (!cameras.is_array() || cameras.empty()) return {};
  std::string html =
      "<h3>Cameras</h3><table><tr><th>camera</th><th>gain, red green blue</th><th>clock</th></tr>";
  for (const Json& c : cameras)
    html += fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td></tr>", escape(c.value("name", "")),
                        c.contains("gain") ? exposure_text(c) : "",
                        c.contains("offset_frames") ? clock_text(c) : "");
  return html + "</table>";
}

}  // namespace splinevox::run
