// SPDX-License-Identifier: Apache-2.0
#include "train/bounds/seen_motion.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/parallel.hpp"
#include "core/rng.hpp"
#include "render/specialise.hpp"
#include "train/by_time.hpp"
#include "train/look.hpp"
#include "train/neutral.hpp"

namespace splinevox {
namespace {

constexpr std::size_t kMostLooks = 256;  ///< views
constexpr double kRays = 180000;         ///< of all looks together: one or two steps of training in a hundred
constexpr float kLeastWeight = 0.5f;     ///< of a cell in one view, in pixels of its grid of rays

/// Weighted sums over the samples of one view in one cell.
struct CellSums {
  Vec3 displacement{}, error{};
  float light = 0, presence = 0, weight = 0;
};
using VisibleCell = std::pair<std::size_t, CellSums>;

template <int Sh>
std::vector<VisibleCell> cells_of(const VoxelModel& model, const Frame& view, const CameraFits& cameras,
                                  const BitGrid* occupancy, const BitGrid& grid, double rays) {
  Look<Sh> look(model, cameras.time_of(view), occupancy);
  const Vec3 gain = cameras.gain_of(view);
  const Camera& camera = view.camera;
  const ReadAll all_of(view.image);
  const int stride = std::max(1, int(std::sqrt(double(camera.width) * camera.height / rays)));
  std::vector<CellSums> cells(grid.cells());
  for (int y = stride / 2; y < camera.height; y += stride)
    for (int x = stride / 2; x < camera.width; x += stride) {
      if (view.ignored.test(x, y)) continue;
      const Ray ray = camera_ray(camera, x + 0.5, y + 0.5);
      const Vec3 behind = model.behind(ray);
      const Vec3 error =
          photometric_error(look.along(ray, behind), neutral_target(view.image, x, y, behind, gain));
      look.each_sample([&](const Vec3& position, float w, int i) {
        CellSums& cell = cells[grid.index(grid.cell_of(position))];
        cell.displacement += w * look.displacement(i);
        cell.error += w * error;
        cell.light += w * look.light(i);
        cell.presence += w * look.presence(i);
        cell.weight += w;
      });
    }
  std::vector<VisibleCell> out;
  for (std::size_t c = 0; c < cells.size(); ++c)
    if (cells[c].weight > kLeastWeight) out.emplace_back(c, cells[c]);
  return out;
}

/// Weighted mean and variance of vectors.
class Moments {
 public:
  void add(const Vec3& value, double weight) {
    const Vec3d v = cast<double>(value);
    sum_ = sum_ + weight * v;
    square_ += weight * dot(v, v);
    weight_ += weight;
  }
  Vec3 mean() const { return cast<float>((1 / weight_) * sum_); }
  double variance() const { return std::max(0.0, (square_ - dot(sum_, sum_) / weight_) / weight_); }

 private:
  Vec3d sum_{};
  double square_ = 0, weight_ = 0;
};

}  // namespace

std::vector<VisibleMotion> visible_motion(const VoxelModel& model, const Split& views,
                                          const FrameOccupancy& occupancy, const BitGrid& cells,
                                          const CameraFits& cameras) {
  const std::vector<int> by_time = frames_by_time(views);
  const std::size_t looks = std::min(kMostLooks, by_time.size());
  // One view of every stretch of time, drawn at random, or it might always be the same camera's.
  std::vector<int> chosen(looks);
  for (std::size_t i = 0; i < looks; ++i) {
    const std::size_t first = i * by_time.size() / looks, last = (i + 1) * by_time.size() / looks;
    chosen[i] = by_time[first + hash64(i) % (last - first)];
  }
  std::vector<std::vector<VisibleCell>> visible(looks);
  parallel_for(int(looks), [&](int i) {
    const int f = chosen[i];
    const BitGrid* grid =
        occupancy.grids.empty() ? nullptr : &occupancy.grids[std::size_t(occupancy.of_frame[std::size_t(f)])];
    specialise(model.radiance.sh_order, [&]<int Sh>() {
      visible[i] = cells_of<Sh>(model, views.frames[f], cameras, grid, cells, kRays / double(looks));
    });
  });
  struct Course {
    Moments displacement, light, presence, error;
    double last =
        std::numeric_limits<double>::quiet_NaN();  ///< of the last view in which the cell is visible
  };
  std::vector<Course> courses(cells.cells());
  std::vector<VisibleMotion> out(cells.cells());
  for (std::size_t i = 0; i < looks; ++i)
    for (const auto& [c, s] : visible[i]) {
      const float share = 1 / s.weight;
      courses[c].displacement.add(share * s.displacement, s.weight);
      courses[c].light.add({share * s.light, 0, 0}, s.weight);
      courses[c].presence.add({share * s.presence, 0, 0}, s.weight);
      courses[c].error.add(share * s.error, s.weight);
      out[c].weight += s.weight;
      const double time = views.frames[chosen[i]].time;
      if (std::exchange(courses[c].last, time) != time) ++out[c].times;
    }
  for (std::size_t c = 0; c < out.size(); ++c) {
    if (out[c].times == 0) continue;
    out[c].offset = courses[c].displacement.mean();
    out[c].spread = float(std::sqrt(courses[c].displacement.variance()));
    out[c].light = float(std::sqrt(courses[c].light.variance()));
    out[c].presence = float(std::sqrt(courses[c].presence.variance()));
    out[c].error = float(std::sqrt(courses[c].error.variance() / 3));
  }
  return out;
}

}  // namespace splinevox
