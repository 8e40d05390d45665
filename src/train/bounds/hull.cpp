// SPDX-License-Identifier: Apache-2.0
#include "train/bounds/hull.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "core/parallel.hpp"
#include "math/camera.hpp"
#include "train/by_time.hpp"

namespace splinevox {
namespace {

/// Where cameras look outwards, how much further the scene reaches than they are spread: from there on a
/// picture hardly changes.
constexpr double kSurround = 8;

/// Cube around the point nearest to all viewing axes: as large as the views of cameras that look at it. If
/// most look away from it they are inside the scene, which a cube between them would not hold (numerics H28).
Box camera_cube(const Split& train) {
  Eigen::Matrix3d a = 1e-9 * Eigen::Matrix3d::Identity();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (const Frame& f : train.frames) {
    const Vec3d z = f.camera.axes[2], p = f.camera.position;
    const Eigen::Vector3d axis(z.x, z.y, z.z), position(p.x, p.y, p.z);
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - axis * axis.transpose();
    a += across;
    b += across * position;
  }
  const Eigen::Vector3d x = a.ldlt().solve(b);
  const Vec3d center{x[0], x[1], x[2]};
  std::vector<double> reach;
  double spread = 0;
  std::size_t away = 0;
  for (const Frame& f : train.frames) {
    const double half = std::max(f.camera.width / f.camera.fx, f.camera.height / f.camera.fy) / 2;
    const Vec3d outwards = f.camera.position - center;
    reach.push_back(length(outwards) * half);
    spread = std::max(spread, length(outwards));
    away += dot(outwards, f.camera.axes[2]) <= 0;
  }
  std::nth_element(reach.begin(), reach.begin() + reach.size() / 2, reach.end());
  const bool inside = 2 * away > train.frames.size();
  // Cameras all in one point say nothing of lengths: any will do.
  const double r = !inside                          ? std::max(1e-6, 1.1 * reach[reach.size() / 2])
                   : spread > 1e-9 * length(center) ? kSurround * spread
                                                    : 1.0;
  const Vec3 c = cast<float>(center), e{float(r), float(r), float(r)};
  return {c - e, c + e};
}

/// Silhouette in blocks: set where any pixel of the block, or of a ring of `grow` pixels around it, has alpha
/// > 0.
struct Silhouette {
  static constexpr int kBlock = 4;
  int width = 0, height = 0;
  std::vector<char> inside;
  bool complete = true;  ///< nothing touches the picture's border, so nothing lies outside it

  Silhouette(const Picture& image, int grow)
      : width((image.width + kBlock - 1) / kBlock),
        height((image.height + kBlock - 1) / kBlock),
        inside(std::size_t(width) * height) {
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x) {
        if (image.pixel(x, y)[3] < 1000) continue;
        complete &= x > 0 && y > 0 && x + 1 < image.width && y + 1 < image.height;
        const int x0 = std::max(0, x - grow) / kBlock, x1 = std::min(image.width - 1, x + grow) / kBlock;
        const int y0 = std::max(0, y - grow) / kBlock, y1 = std::min(image.height - 1, y + grow) / kBlock;
        for (int v = y0; v <= y1; ++v)
          std::fill_n(inside.begin() + std::size_t(v) * width + x0, x1 - x0 + 1, char(1));
      }
  }
};

enum View : char { kOutside, kInside, kUnseen };

/// A picture that says of any place whether it lies in the silhouette, beside it, or out of a picture that
/// shows only part.
class Watch {
 public:
  Watch(const Frame& frame, const BitGrid& grid)
      : camera_(frame.camera), silhouette_(frame.image, grow(frame.camera, grid)) {}

  View operator()(const Vec3d& x) const {
    const Projection p = project(camera_, x);
    if (p.depth <= 0 || p.u < 0 || p.v < 0 || p.u >= camera_.width || p.v >= camera_.height)
      return silhouette_.complete ? kOutside : kUnseen;
    const std::size_t block =
        std::size_t(p.v) / Silhouette::kBlock * silhouette_.width + std::size_t(p.u) / Silhouette::kBlock;
    return silhouette_.inside[block] ? kInside : kOutside;
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

/// Cells that in some window of neighbouring times no view sees outside the silhouette and most see inside.
BitGrid swept_hull(const Split& train, const Box& box, int cells) {
  const std::vector<int> by_time = frames_by_time(train);
  const int n = int(by_time.size());
  // A window is a twentieth of the frames: longer clips what moves fast, shorter leaves the hull loose.
  constexpr int kLongest = 9, kWord = 32;
  const int window = std::min(n, std::clamp(n / 20, 3, kLongest));
  BitGrid hull(box, cells);
  std::vector<std::unique_ptr<const Watch>> watches(n);
  parallel_for(n, [&](int f) { watches[f] = std::make_unique<const Watch>(train.frames[by_time[f]], hull); });
  // By words, each of which one thread owns, and through all times at once: only the views of a window are
  // kept.
  parallel_for(int(hull.bits.size()), [&](int word) {
    const std::size_t first = std::size_t(word) * kWord;
    const int count = int(std::min<std::size_t>(kWord, hull.cells() - first));
    Vec3d place[kWord];
    for (int k = 0; k < count; ++k) place[k] = cast<double>(hull.center(hull.cell_at(first + k)));
    View views[kLongest][kWord];
    int inside[kWord] = {}, outside[kWord] = {};
    for (int f = 0; f < n; ++f)
      for (int k = 0; k < count; ++k) {
        View& view = views[f % window][k];
        if (f >= window) {
          inside[k] -= view == kInside;
          outside[k] -= view == kOutside;
        }
        view = (*watches[f])(place[k]);
        inside[k] += view == kInside;
        outside[k] += view == kOutside;
        if (f + 1 >= window && outside[k] == 0 && 2 * inside[k] > window) hull.set(first + k);
      }
  });
  return hull;
}

}  // namespace

SceneBounds find_bounds(const Split& train, bool has_alpha, int cells, float margin) {
  Box box = camera_cube(train);
  if (has_alpha) {
    const BitGrid coarse = swept_hull(train, box, 48);
    if (coarse.count() > 0) {
      box = bounding_box(coarse, margin);
      const BitGrid hull = swept_hull(train, box, cells);
      if (hull.count() > 0) return {box, dilate(hull)};
    }
  }
  BitGrid all(box, cells);
  std::fill(all.bits.begin(), all.bits.end(), ~0u);
  return {box, all};
}

}  // namespace splinevox
