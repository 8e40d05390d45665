// SPDX-License-Identifier: Apache-2.0
#include "train/bounds/hull.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <numeric>
#include <vector>

#include "core/parallel.hpp"
#include "math/camera.hpp"
#include "math/nearest_point.hpp"
#include "train/by_time.hpp"

namespace splinevox {
namespace {

/// Where cameras look outwards, how much further the scene reaches than they are spread: from there on a
/// picture hardly changes.
constexpr double kSurround = 8;

enum View : char { kOutside, kInside, kUnseen, kUnasked };

/// Runs of pixels along the rows of a picture that show something (alpha > 0), or are ignored.
struct PixelRuns {
  struct Run {
    int y, first, last;
    View view;
  };
  int width = 0, height = 0;
  std::vector<Run> runs;  ///< those of kUnseen before those of kInside
  bool complete = true;   ///< it shows something, and nothing touches its border, so nothing lies outside it

  explicit PixelRuns(const Frame& frame) : width(frame.image.width), height(frame.image.height) {
    const Picture& image = frame.image;
    const ReadAll all_of(image);
    const auto add = [&](const auto& is, View view) {
      for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
          if (!is(x, y)) continue;
          const int first = x;
          while (x + 1 < width && is(x + 1, y)) ++x;
          runs.push_back({y, first, x, view});
          complete &= first > 0 && y > 0 && x + 1 < width && y + 1 < height;
        }
    };
    if (!frame.ignored.empty()) add([&](int x, int y) { return frame.ignored.test(x, y); }, kUnseen);
    add([&](int x, int y) { return image.pixel(x, y)[3] >= 1000 && !frame.ignored.test(x, y); }, kInside);
    // What has left a picture altogether may be anywhere outside it.
    complete &= std::any_of(runs.begin(), runs.end(), [](const Run& run) { return run.view == kInside; });
  }
};

/// Silhouette in blocks: inside where any pixel of the block, or of a ring of `grow` pixels around it, has
/// alpha > 0; else unseen where any of them is ignored.
struct Silhouette {
  static constexpr int kBlock = 4;
  int width = 0;
  std::vector<View> views;
  bool complete = true;

  Silhouette(const PixelRuns& picture, int grow)
      : width((picture.width + kBlock - 1) / kBlock),
        views(std::size_t(width) * ((picture.height + kBlock - 1) / kBlock), kOutside),
        complete(picture.complete) {
    for (const PixelRuns::Run& run : picture.runs) {
      const int x0 = std::max(0, run.first - grow) / kBlock,
                x1 = std::min(picture.width - 1, run.last + grow) / kBlock,
                y0 = std::max(0, run.y - grow) / kBlock,
                y1 = std::min(picture.height - 1, run.y + grow) / kBlock;
      for (int v = y0; v <= y1; ++v)
        std::fill_n(views.begin() + std::size_t(v) * width + x0, x1 - x0 + 1, run.view);
    }
  }
};

/// A picture that says of any place whether it lies in the silhouette, beside it, or out of a picture that
/// shows only part.
class Watch {
 public:
  Watch(const Camera& camera, const PixelRuns& picture, const BitGrid& grid)
      : camera_(camera), silhouette_(picture, grow(camera, grid)) {}

  View operator()(const Vec3d& x) const {
    const Projection p = project(camera_, x);
    if (p.depth <= 0 || p.u < 0 || p.v < 0 || p.u >= camera_.width || p.v >= camera_.height)
      return silhouette_.complete ? kOutside : kUnseen;
    const std::size_t block =
        std::size_t(p.v) / Silhouette::kBlock * silhouette_.width + std::size_t(p.u) / Silhouette::kBlock;
    return silhouette_.views[block];
  }

 private:
  /// Half a cell's diagonal in pixels, and a little.
  static int grow(const Camera& camera, const BitGrid& grid) {
    const Vec3d middle = cast<double>(grid.center({grid.size.x / 2, grid.size.y / 2, grid.size.z / 2}));
    return 2 +
           int(std::min(0.9 * grid.cell * camera.fx / std::max(length(camera.position - middle), 1e-9), 1e6));
  }
  Camera camera_;
  Silhouette silhouette_;
};

/// Those of all pictures, in the order of their times.
struct RunsByTime {
  std::vector<int> by_time;
  std::vector<std::unique_ptr<const PixelRuns>> pictures;

  explicit RunsByTime(const Split& train) : by_time(frames_by_time(train)), pictures(by_time.size()) {
    parallel_for(int(pictures.size()),
                 [&](int f) { pictures[f] = std::make_unique<const PixelRuns>(train.frames[by_time[f]]); });
  }
};

/// Cells that in some window of neighbouring times no view sees outside the silhouette and most see inside.
BitGrid swept_hull(const RunsByTime& known, const std::vector<Camera>& cameras, const Box& box, int cells) {
  const int n = int(known.pictures.size());
  // A window is a twentieth of the frames: longer clips what moves fast, shorter leaves the hull loose.
  constexpr int kLongest = 9;
  constexpr std::size_t kWord = 32;
  const int window = std::min(n, std::clamp(n / 20, 3, kLongest));
  BitGrid hull(box, cells);
  std::vector<std::unique_ptr<const Watch>> watches(n);
  parallel_for(n, [&](int f) {
    watches[f] = std::make_unique<const Watch>(cameras[known.by_time[f]], *known.pictures[f], hull);
  });
  // By words, each of which one thread owns. A window is looked through from its end: where a view sees a
  // cell outside, no window up to that view can hold it, so most views of empty space are never asked.
  parallel_for(int(hull.bits.size()), [&](int word) {
    const std::size_t first = std::size_t(word) * kWord;
    const std::size_t last = std::min(first + kWord, hull.cells());
    std::vector<View> seen(n);
    for (std::size_t cell = first; cell < last; ++cell) {
      const Vec3d place = cast<double>(hull.center(hull.cell_at(cell)));
      std::fill(seen.begin(), seen.end(), kUnasked);
      const auto view = [&](int f) { return seen[f] == kUnasked ? seen[f] = (*watches[f])(place) : seen[f]; };
      for (int begin = 0; begin + window <= n;) {
        int inside = 0, f = begin + window - 1;
        for (; f >= begin && view(f) != kOutside; --f) inside += view(f) == kInside;
        if (f >= begin) {
          begin = f + 1;
        } else if (2 * inside > window) {
          hull.set(cell);
          break;
        } else {
          ++begin;
        }
      }
    }
  });
  return hull;
}

/// Whether a ray meets a set cell.
bool meets(const BitGrid& hull, const Ray& ray) {
  const Vec3d lo = cast<double>(hull.origin),
              hi = lo + double(hull.cell) * cast<double>(cast<float>(hull.size));
  double enter = 0, leave = 1e300;
  for (int a = 0; a < 3; ++a) {
    const double one = (lo[a] - ray.origin[a]) / ray.direction[a],
                 two = (hi[a] - ray.origin[a]) / ray.direction[a];
    enter = std::max(enter, std::min(one, two));
    leave = std::min(leave, std::max(one, two));
  }
  const double step = 0.5 * double(hull.cell);
  for (double t = enter; t <= leave; t += step)
    if (hull.test(hull.index(hull.cell_of(cast<float>(ray.origin + t * ray.direction))))) return true;
  return false;
}

/// Where the middle of a camera's picture lies: not along its axis if the lens is shifted or pictures are
/// cut.
Vec3d middle_of(const Camera& c) { return camera_ray(c, 0.5 * c.width, 0.5 * c.height).direction; }

constexpr int kCoarse = 48;  ///< cells of a first hull along an edge

}  // namespace

std::vector<Camera> cameras_of(const Split& train) {
  std::vector<Camera> cameras;
  for (const Frame& f : train.frames) cameras.push_back(f.camera);
  return cameras;
}

Box camera_cube(const std::vector<Camera>& cameras) {
  NearestPoint nearest;
  nearest.hold({0, 0, 0}, 1e-9);  // parallel axes have no such point: any will do
  for (const Camera& c : cameras) {
    const Vec3d d = middle_of(c), p = c.position;
    nearest.add({d.x, d.y, d.z}, {p.x, p.y, p.z});
  }
  const Eigen::Vector3d x = nearest.solve();
  const Vec3d center{x[0], x[1], x[2]};
  std::vector<double> reach;
  double spread = 0;
  std::size_t away = 0;
  for (const Camera& c : cameras) {
    const double half = std::max(c.width / c.fx, c.height / c.fy) / 2;
    const Vec3d outwards = c.position - center;
    reach.push_back(length(outwards) * half);
    spread = std::max(spread, length(outwards));
    away += dot(outwards, middle_of(c)) >= 0;
  }
  std::nth_element(reach.begin(), reach.begin() + reach.size() / 2, reach.end());
  const bool inside = 2 * away > cameras.size();
  // Cameras all in one point say nothing of lengths: any will do.
  const double r = !inside                          ? std::max(1e-6, 1.1 * reach[reach.size() / 2])
                   : spread > 1e-9 * length(center) ? kSurround * spread
                                                    : 1.0;
  const Vec3 c = cast<float>(center), e{float(r), float(r), float(r)};
  return {c - e, c + e};
}

double explained_by_hull(const Split& train, const std::vector<Camera>& cameras) {
  const BitGrid hull = swept_hull(RunsByTime(train), cameras, camera_cube(cameras), kCoarse);
  if (hull.count() == 0) return 0;
  constexpr int kPictures = 64, kAcross = 24;  // looked at, and pixels along a side of each
  const int every = std::max(1, int(train.frames.size()) / kPictures);
  const int count = (int(train.frames.size()) + every - 1) / every;
  std::vector<int> shown(count), met(count);
  parallel_for(count, [&](int k) {
    const Frame& frame = train.frames[k * every];
    const Picture& image = frame.image;
    const ReadAll all_of(image);
    for (int v = 0; v < kAcross; ++v)
      for (int u = 0; u < kAcross; ++u) {
        const int x = (2 * u + 1) * image.width / (2 * kAcross),
                  y = (2 * v + 1) * image.height / (2 * kAcross);
        if (image.pixel(x, y)[3] < 32768 || frame.ignored.test(x, y)) continue;
        ++shown[k];
        met[k] += meets(hull, camera_ray(cameras[k * every], x + 0.5, y + 0.5)) ? 1 : 0;
      }
  });
  const double all = std::accumulate(shown.begin(), shown.end(), 0.0);
  return all > 0 ? std::accumulate(met.begin(), met.end(), 0.0) / all : 0;
}

std::vector<OtherCameras> other_cameras(const Split& train) {
  const auto changed = [&](const auto& change) {
    std::vector<Camera> cameras = cameras_of(train);
    for (Camera& c : cameras) change(c);
    return cameras;
  };
  const auto flip = [](Camera& c) {
    c.axes[1] = -c.axes[1];
    c.axes[2] = -c.axes[2];
  };
  const auto invert = [](Camera& c) {
    const std::array<Vec3d, 3> a = c.axes;
    const Vec3d p = c.position;
    for (int k = 0; k < 3; ++k) c.axes[k] = {a[0][k], a[1][k], a[2][k]};
    c.position = {-dot(a[0], p), -dot(a[1], p), -dot(a[2], p)};
  };
  return {{"camera to world with OpenCV's axes (y down, z forwards)", changed(flip)},
          {"world to camera", changed(invert)},
          {"world to camera with OpenCV's axes (y down, z forwards)", changed([&](Camera& c) {
             invert(c);
             flip(c);
           })}};
}

double parallax(const std::vector<Camera>& cameras, const Box& box) {
  const Vec3d middle = cast<double>(box.center());
  std::vector<Vec3d> towards;
  double furthest_off = 0, spread = 0;
  for (const Camera& c : cameras) {
    const Vec3d off = c.position - middle;
    furthest_off = std::max(furthest_off, length(off));
    spread = std::max(spread, length(c.position - cameras.front().position));
    if (length(off) > 0) towards.push_back(normalize(off));
  }
  if (towards.empty() || spread <= 1e-9 * furthest_off) return 0;
  double least = 1;
  Vec3d furthest = towards.front();  // two sweeps find nearly the widest pair
  for (int sweep = 0; sweep < 2; ++sweep) {
    const Vec3d from = furthest;
    for (const Vec3d& t : towards)
      if (dot(from, t) < least) {
        least = dot(from, t);
        furthest = t;
      }
  }
  return std::acos(std::clamp(least, -1.0, 1.0)) * 180 / std::numbers::pi;
}

bool look_alike(const std::vector<Camera>& cameras) {
  constexpr double kAlike = 1;  // degrees
  for (const Camera& c : cameras)
    if (dot(middle_of(c), middle_of(cameras.front())) < std::cos(kAlike * std::numbers::pi / 180))
      return false;
  return cameras.size() > 1;
}

SceneBounds find_bounds(const Split& train, bool has_alpha, int cells, float margin) {
  const std::vector<Camera> cameras = cameras_of(train);
  Box box = camera_cube(cameras);
  if (has_alpha) {
    const RunsByTime known(train);
    const BitGrid coarse = swept_hull(known, cameras, box, kCoarse);
    if (coarse.count() > 0) {
      box = bounding_box(coarse, margin);
      const BitGrid hull = swept_hull(known, cameras, box, cells);
      if (hull.count() > 0) return {box, dilate(hull)};
    }
  }
  BitGrid all(box, cells);
  std::fill(all.bits.begin(), all.bits.end(), ~0u);
  return {box, all};
}

}  // namespace splinevox
