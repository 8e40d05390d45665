// SPDX-License-Identifier: Apache-2.0
#include "run/training_cameras.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "math/nearest_point.hpp"
#include "run/camera_ways.hpp"
#include "train/by_time.hpp"

namespace splinevox::run {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kNearOrbit = 60 * kDegree;  // a camera this near shows most of what the orbit shows
constexpr double kOneSide = 0.9;           // length of the mean direction of cameras on one side of the scene
constexpr double kLooksAt = 45 * kDegree;  // between its axis and the way to the middle
constexpr double kOnePlace = 1e-3;         // radians that cameras of one place may differ by
constexpr double kInOrder = 0.5;           // of the mean distance of two pictures of a film
constexpr std::size_t kShortestFilm = 8;   // pictures
constexpr double kParallel = 1e-3;         // of an axis' weight, for the middle of the box: axes that are
                                           // parallel within 2 degrees do not tell how far they meet
constexpr std::size_t kCompared = 256;     // pictures of a film that all pairs are taken of

/// The angle that one camera must be turned by to stand like the other.
double turn(const Camera& a, const Camera& b) {
  double trace = 0;
  for (int i = 0; i < 3; ++i) trace += dot(a.axes[i], b.axes[i]);
  return std::acos(std::clamp((trace - 1) / 2, -1.0, 1.0));
}

/// The point next to all axes; where they are parallel it is as far away as the middle of the box. Where it
/// lies behind many cameras, what lies before the mean camera at that distance.
Vec3d middle_of_view(const std::vector<Frame>& frames, const Vec3d& box_middle) {
  NearestPoint nearest;
  Vec3d position{}, look{};
  for (const Frame& f : frames) {
    const Vec3d z = f.camera.axes[2], p = f.camera.position;
    nearest.add({z.x, z.y, z.z}, {p.x, p.y, p.z});
    position += p;
    look -= z;
  }
  const double n = double(frames.size());
  nearest.hold({box_middle.x, box_middle.y, box_middle.z}, kParallel * n);
  const Eigen::Vector3d solved = nearest.solve();
  const Vec3d x{solved[0], solved[1], solved[2]};
  const auto before = std::count_if(frames.begin(), frames.end(), [&](const Frame& f) {
    const Vec3d to = x - f.camera.position;
    return dot(-f.camera.axes[2], to) > 0.5 * length(to);
  });
  if (double(before) >= 0.8 * n || length(look) < 1e-6) return x;
  position = position * (1 / n);
  return position + std::max(length(box_middle - position), 1e-6) * normalize(look);
}

struct Surround {
  bool yes = false;
  std::string measured;  ///< a clause
};

/// Whether an orbit is near cameras everywhere. One about the axis of cameras on one side would be near them,
/// and yet see other sides than they do.
Surround surround(const std::vector<Frame>& frames, const Box& box, double elevation) {
  const Vec3d middle = cast<double>(box.center()), lo = cast<double>(box.lo), hi = cast<double>(box.hi);
  std::vector<Vec3d> seen;
  Vec3d mean{};
  for (const Frame& f : frames) {
    const Vec3d p = f.camera.position, out = p - middle;
    const bool inside = p.x > lo.x && p.y > lo.y && p.z > lo.z && p.x < hi.x && p.y < hi.y && p.z < hi.z;
    if (inside || length(out) == 0 || angle_between(f.camera.axes[2], out) > kLooksAt) continue;
    seen.push_back(normalize(out));
    mean += seen.back();
  }
  if (seen.empty()) return {false, "no camera looks at the box from outside"};
  if (length(mean) > kOneSide * double(seen.size()))
    return {false, "all cameras are on one side of the scene"};
  double widest = 0;
  for (const Camera& to : orbit(box, elevation, 1, 60)) {
    double least = std::numbers::pi;
    for (const Vec3d& d : seen) least = std::min(least, angle_between(to.axes[2], d));
    widest = std::max(widest, least);
  }
  const double degrees = std::ceil(widest / kDegree);
  if (widest > kNearOrbit)
    return {false, fmt::format("an orbit would be up to {:.0f} degrees from every training camera", degrees)};
  return {true, fmt::format("an orbit is nowhere over {:.0f} degrees from a training camera", degrees)};
}

/// Indices of the frames that one camera took, in the order of time: of the camera with the most.
std::vector<int> of_one_camera(const Dataset& data, const Split& train) {
  std::vector<int> order = frames_by_time(train);
  if (data.cameras.empty()) return order;
  std::map<int, int> count;
  for (const Frame& f : train.frames) ++count[f.camera_id];
  const int most = std::max_element(count.begin(), count.end(), [](const auto& a, const auto& b) {
                     return a.second < b.second;
                   })->first;
  std::erase_if(order, [&](int f) { return train.frames[std::size_t(f)].camera_id != most; });
  return order;
}

Shot shot_of(const Frame& f) { return {f.camera, std::clamp(f.time, 0.0, 1.0)}; }

/// Whether neighbours are so near to each other that the shots are one way.
template <class Apart>
bool in_order(const std::vector<Shot>& shots, const Apart& apart) {
  const std::size_t n = shots.size(), stride = 1 + n / kCompared;
  if (n < kShortestFilm) return false;
  double neighbours = 0, pairs = 0, count = 0;
  for (std::size_t i = 0; i + 1 < n; ++i)
    neighbours += apart(shots[i].camera, shots[i + 1].camera) / double(n - 1);
  for (std::size_t i = 0; i < n; i += stride)
    for (std::size_t j = 0; j < i; j += stride) {
      pairs += apart(shots[i].camera, shots[j].camera);
      ++count;
    }
  return neighbours < kInOrder * pairs / count;
}

}  // namespace

double angle_between(const Vec3d& a, const Vec3d& b) { return std::atan2(length(cross(a, b)), dot(a, b)); }

const Shot& central(const std::vector<Shot>& shots) {
  Vec3d mean{};
  for (const Shot& s : shots) mean += s.camera.position * (1 / double(shots.size()));
  const auto off = [&](const Shot& s) { return length(s.camera.position - mean); };
  return *std::min_element(shots.begin(), shots.end(),
                           [&](const Shot& a, const Shot& b) { return off(a) < off(b); });
}

TrainingCameras survey(const Dataset& data, const Box& box, double elevation) {
  const Split& train = *data.find("train");
  TrainingCameras out;
  out.middle = middle_of_view(train.frames, cast<double>(box.center()));
  double reach = 0;
  for (const Frame& f : train.frames) reach += length(f.camera.position - out.middle);
  reach = std::max(reach / double(train.frames.size()), 1e-9);
  const auto apart = [&](const Camera& a, const Camera& b) {
    return turn(a, b) + length(a.position - b.position) / reach;
  };
  for (const Frame& f : train.frames)
    if (std::none_of(out.places.begin(), out.places.end(),
                     [&](const Shot& s) { return apart(s.camera, f.camera) < kOnePlace; }))
      out.places.push_back(shot_of(f));
  for (const int f : of_one_camera(data, train)) out.film.push_back(shot_of(train.frames[std::size_t(f)]));
  if (!in_order(out.film, apart)) out.film.clear();

  const auto [around, measured] = surround(train.frames, box, elevation);
  if (around) {
    out.stand = Stand::around;
    out.why = fmt::format("cameras surround the scene: {}", measured);
  } else if (out.places.size() == 1) {
    out.stand = Stand::one;
    out.why = "all pictures were taken from one place";
  } else if (!out.film.empty()) {
    out.stand = Stand::film;
    out.why = fmt::format("{} pictures are a film of one camera, and {}", out.film.size(), measured);
  } else {
    out.stand = out.places.size() <= kFewPlaces ? Stand::few : Stand::many;
    out.why = fmt::format("pictures were taken from {} places, and {}", out.places.size(), measured);
  }
  return out;
}

TrainingCameras training_cameras(const Run& run, const std::string& data, double elevation) {
  LoadOptions load;
  load.downscale = run.config.run.downscale;
  load.splits = {"train"};
  load.time_map = run.record.time_map;
  load.rules = run.record.rules;
  load.pixels = false;
  return survey(load_dataset(data.empty() ? run.record.dataset : data, load), run.model.box, elevation);
}

}  // namespace splinevox::run
