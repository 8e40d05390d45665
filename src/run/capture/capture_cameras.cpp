// SPDX-License-Identifier: Apache-2.0
#include "run/capture/capture_cameras.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "data/layouts/folder_list.hpp"
#include "math/median.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::run {
namespace {

namespace fs = std::filesystem;
using namespace data;

/// x becomes scale * rows * (x - centre).
struct Similarity {
  std::array<Vec3d, 3> rows{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  Vec3d centre{};
  double scale = 1;

  Vec3d turned(const Vec3d& v) const { return {dot(rows[0], v), dot(rows[1], v), dot(rows[2], v)}; }
  Vec3d operator()(const Vec3d& p) const { return scale * turned(p - centre); }
};

/// z is the mean of the cameras' up, and y as near as can be to where they look.
Similarity upright(const std::vector<RigidPose>& poses) {
  constexpr double kTell = 0.1;  // of a mean of unit vectors, for it to have a direction
  Vec3d up{}, ahead{};
  for (const RigidPose& pose : poses) {
    up += pose.axes[1] * (1.0 / double(poses.size()));
    ahead -= pose.axes[2] * (1.0 / double(poses.size()));
  }
  if (length(up) < kTell) return {};
  const Vec3d z = normalize(up);
  Vec3d y = ahead - z * dot(z, ahead);
  if (length(y) < kTell) {
    const Vec3d other = std::abs(z.x) < 0.5 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
    y = other - z * dot(z, other);
  }
  y = normalize(y);
  return {{cross(y, z), y, z}, {}, 1};
}

RigidPose mean_pose(const std::vector<RigidPose>& poses) {
  RigidPose mean;
  std::array<Vec3d, 3> sum{};
  for (const RigidPose& pose : poses) {
    mean.position += pose.position * (1.0 / double(poses.size()));
    for (std::size_t a = 0; a < 3; ++a) sum[a] += pose.axes[a];
  }
  const Vec3d z = normalize(sum[2]), x = normalize(cross(sum[1], z));
  mean.axes = {x, cross(z, x), z};
  return mean;
}

double spread(const std::vector<RigidPose>& poses) {
  double most = 0;
  for (const RigidPose& a : poses)
    for (const RigidPose& b : poses) most = std::max(most, length(a.position - b.position));
  return most;
}

double longest_way(const std::vector<RigidPose>& poses) {
  Vec3d lo = poses.at(0).position, hi = lo;
  for (const RigidPose& pose : poses) {
    lo = min(lo, pose.position);
    hi = max(hi, pose.position);
  }
  const Vec3d e = hi - lo;
  return std::max({e.x, e.y, e.z});
}

/// The median distance of points from cameras: of some of each, evenly chosen.
double usual_distance(const std::vector<Vec3d>& points, const std::vector<RigidPose>& poses) {
  constexpr std::size_t kMost = 64;
  std::vector<double> distances;
  const auto step = [](std::size_t n) { return std::max<std::size_t>(1, n / kMost); };
  for (std::size_t i = 0; i < points.size(); i += step(points.size()))
    for (std::size_t k = 0; k < poses.size(); k += step(poses.size()))
      distances.push_back(length(points[i] - poses[k].position));
  return distances.empty() ? 1 : median(std::move(distances));
}

/// A camera that found its place.
struct Found {
  std::vector<RigidPose> poses;
  Lens lens;
};

/// The camera of the data set; none if its lens is none.
std::optional<Camera> camera_of(const Found& found, const RigidPose& pose) {
  try {
    const Camera camera = pinhole(found.lens, pose, int(found.lens.w.value()), int(found.lens.h.value()), "");
    return is_likely_lens(camera) ? std::optional(camera) : std::nullopt;
  } catch (const Error&) {  // a distortion that folds
    return {};
  }
}

CapturedScene nothing_placed(const std::vector<CaptureFrame>& frames, const std::vector<std::string>& rig) {
  CapturedScene scene;
  scene.left_out = rig;
  scene.asked = int(rig.empty() ? frames.size() : rig.size());
  return scene;
}

/// What frames are placed by: a picture's own name, or its camera's.
std::string key_of(const std::string& image, bool rig) {
  return rig ? image.substr(0, image.find('/')) : image;
}

}  // namespace

std::optional<std::pair<fs::path, int>> largest_model(const fs::path& folder) {
  std::optional<std::pair<fs::path, int>> best;
  std::size_t most = 0;
  for (const std::string& name : folders_in(folder)) {
    std::error_code ignored;
    if (!fs::exists(folder / name / "images.bin", ignored)) continue;
    const std::size_t images = read_colmap_binary(folder / name).images.size();
    const int number = best ? best->second + 1 : 1;
    if (!best || images > most) {
      best = {folder / name, number};
      most = images;
    }
    best->second = number;
  }
  return best;
}

bool is_likely_lens(const Camera& camera) {
  const double side = std::max(camera.width, camera.height);
  const auto likely = [&](double focal) { return focal >= side / 5 && focal <= side * 5; };
  return likely(camera.fx) && likely(camera.fy);
}

CapturedScene place_frames(const ColmapModel& model, const std::vector<CaptureFrame>& frames,
                           const std::vector<std::string>& rig) {
  std::map<std::string, Found> found;
  std::vector<RigidPose> poses;
  for (const ColmapImage& image : model.images) {
    const RawFrame frame = frame_of(model, image);
    if (frame.fault) throw Error(*frame.fault);
    const std::string key = key_of(image.name, !rig.empty());
    if (!rig.empty() && std::find(rig.begin(), rig.end(), key) == rig.end()) continue;  // of a walk
    Found& camera = found[key];
    camera.poses.push_back(frame.pose);
    camera.lens = frame.lens;
    poses.push_back(frame.pose);
  }
  CapturedScene scene;
  if (poses.empty()) return nothing_placed(frames, rig);
  Similarity to = upright(poses);
  std::vector<Vec3d> points;
  for (const Vec3d& point : model.points) points.push_back(to(point));
  const std::optional<Box> box = points_box(std::move(points));
  if (!box || !(box->longest_edge() > 0))
    fail({"splinevox capture", "COLMAP found hardly any points", "10 points or more",
          std::to_string(model.points.size()), ""});
  const Vec3d middle = cast<double>(box->center());
  to.centre = to.rows[0] * middle.x + to.rows[1] * middle.y + to.rows[2] * middle.z;
  to.scale = 2 / double(box->longest_edge());
  scene.scale = to.scale;
  const Vec3 half = box->extent() * float(0.5 * to.scale);
  scene.box = {-half, half};
  const double distance = usual_distance(model.points, poses);
  scene.parallax = longest_way(poses) / distance;

  std::map<std::string, std::pair<std::array<double, 16>, Camera>> placed;
  for (const auto& [name, camera] : found) {
    RigidPose pose = mean_pose(camera.poses);
    for (Vec3d& axis : pose.axes) axis = to.turned(axis);
    pose.position = to(pose.position);
    if (const auto of = camera_of(camera, pose))
      placed.emplace(name, std::pair{matrix_of(pose.axes, pose.position), *of});
    else
      ++scene.odd_lenses;
    if (!rig.empty()) scene.unrest = std::max(scene.unrest, spread(camera.poses) / distance);
  }
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const auto at = placed.find(key_of(frames[i].name, !rig.empty()));
    if (at != placed.end())
      scene.frames.push_back({i, at->second.first, at->second.second});
    else if (rig.empty())
      scene.left_out.push_back(frames[i].name);
  }
  for (const std::string& name : rig)
    if (!placed.contains(name)) scene.left_out.push_back(name);
  scene.asked = int(rig.empty() ? frames.size() : rig.size());
  scene.placed = scene.asked - int(scene.left_out.size());
  return scene;
}

std::string models_note(int models, const CapturedScene& scene, const std::string& share) {
  if (models < 2 || scene.placed == scene.asked) return "";
  return fmt::format("COLMAP made {} models that it could not join: the largest is taken, {}", models, share);
}

}  // namespace splinevox::run
