// SPDX-License-Identifier: Apache-2.0
#include "train/effects/moving_cells.hpp"

#include <algorithm>
#include <vector>

#include "core/parallel.hpp"
#include "math/photometric.hpp"
#include "render/specialise.hpp"
#include "train/look.hpp"
#include "train/neutral.hpp"

namespace splinevox {
namespace {

constexpr int kCells = 32;        ///< along the longest edge
constexpr int kStride = 2;        ///< pixels
constexpr float kFewestRays = 2;  ///< of a cell at one time, counted by their weights there

/// Errors of the rays that met a cell at one time, weighted sums.
struct Given {
  Vec3 moving{}, still{};
  float weight = 0;
};

/// Variance over time of the means of a cell, per channel.
class Spread {
 public:
  void add(const Vec3& mean) {
    sum_ = sum_ + cast<double>(mean);
    square_ += double(dot(mean, mean));
    ++times_;
  }
  int times() const { return times_; }
  double variance() const {
    return times_ == 0 ? 0 : std::max(0.0, square_ / times_ - dot(sum_, sum_) / times_ / times_) / 3;
  }

 private:
  Vec3d sum_{};
  double square_ = 0;
  int times_ = 0;
};

template <int Sh>
std::vector<Given> given_by(const Frame& frame, const BitGrid& grid, const VoxelModel& moving,
                            const VoxelModel& still, const CameraFits& cameras) {
  const double time = cameras.time_of(frame);
  const Vec3 gain = cameras.gain_of(frame);
  Look<Sh> look(moving, time), still_look(still, time);
  std::vector<Given> out(grid.cells());
  for (int y = 0; y < frame.camera.height; y += kStride)
    for (int x = 0; x < frame.camera.width; x += kStride) {
      if (frame.ignored.test(x, y)) continue;
      const Ray ray = camera_ray(frame.camera, x + 0.5, y + 0.5);
      const Vec3 target = neutral_target(frame.image, x, y, moving.background.color, gain),
                 error = photometric_error(look.along(ray), target),
                 still_error = photometric_error(still_look.along(ray), target);
      look.each_sample([&](const Vec3& position, float w, int) {
        Given& g = out[grid.index(grid.cell_of(position))];
        g.moving = g.moving + w * error;
        g.still = g.still + w * still_error;
        g.weight += w;
      });
    }
  return out;
}

/// Mean over a cell and those of the six beside it that are visible.
double mean_beside(const BitGrid& visible, const std::vector<double>& values, std::size_t cell) {
  double sum = values[cell];
  int count = 1;
  for (int a = 0; a < 3; ++a)
    for (const int step : {-1, 1}) {
      Int3 at = visible.cell_at(cell);
      at[a] += step;
      if (at[a] < 0 || at[a] >= visible.size[a] || !visible.test(visible.index(at))) continue;
      sum += values[visible.index(at)];
      ++count;
    }
  return sum / count;
}

}  // namespace

BitGrid moving_cells(const VoxelModel& moving, const VoxelModel& still, const Split& views, float least,
                     const CameraFits& cameras) {
  BitGrid out(moving.box, kCells), visible = out;
  std::vector<std::vector<Given>> given(views.frames.size());
  parallel_for(int(given.size()), [&](int f) {
    specialise(moving.radiance.sh_order,
               [&]<int Sh>() { given[f] = given_by<Sh>(views.frames[f], out, moving, still, cameras); });
  });
  std::vector<double> explained(out.cells(), 0.0);
  for (std::size_t c = 0; c < out.cells(); ++c) {
    Spread errors, still_errors;
    for (const std::vector<Given>& at : given)
      if (const Given& g = at[c]; g.weight >= kFewestRays) {
        errors.add((1 / g.weight) * g.moving);
        still_errors.add((1 / g.weight) * g.still);
      }
    if (errors.times() == 0) continue;
    visible.set(c);
    explained[c] = still_errors.variance() - errors.variance();
  }
  for (std::size_t c = 0; c < out.cells(); ++c)
    if (visible.test(c) && std::min(explained[c], mean_beside(visible, explained, c)) > double(least) * least)
      out.set(c);
  return out;
}

Image shows_cells(const VoxelModel& moving, const BitGrid& cells, const Frame& frame) {
  Image out(frame.camera.width, frame.camera.height, 1);
  specialise(moving.radiance.sh_order, [&]<int Sh>() {
    Look<Sh> look(moving, frame.time);
    for (int y = 0; y < out.height; ++y)
      for (int x = 0; x < out.width; ++x) {
        if (frame.ignored.test(x, y)) continue;
        float share = 0;
        look.along(camera_ray(frame.camera, x + 0.5, y + 0.5));
        look.each_sample([&](const Vec3& position, float w, int) {
          share += cells.test(cells.index(cells.cell_of(position))) ? w : 0;
        });
        *out.pixel(x, y) = share > 0.5f;
      }
  });
  return out;
}

}  // namespace splinevox
