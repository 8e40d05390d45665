// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

#include "core/parallel.hpp"
#include "field/warp_velocity.hpp"
#include "math/inverse_warp.hpp"
#include "splinevox/field/sample.hpp"

namespace splinevox {
namespace {

constexpr int kStepsPerPoint = 4;    ///< time steps per control point of a curve
constexpr float kTolerance = 1e-2f;  ///< of a march step
constexpr double kJump =
    4;  ///< march steps a correction may go beyond the predicted way before it counts as a jump
constexpr int kChunk = 256;  ///< points per task

/// Moves points, all at `now`, to `next` in one step.
void advance(const FrameSampler& at_now, const FrameSampler& at_next, double dt, float step,
             const std::vector<Vec3d>& canonical, std::vector<TrackedPoint>& points) {
  parallel_for((int(points.size()) + kChunk - 1) / kChunk, [&](int chunk) {
    for (std::size_t i = std::size_t(chunk) * kChunk;
         i < std::min(points.size(), std::size_t(chunk + 1) * kChunk); ++i) {
      TrackedPoint& p = points[i];
      const Vec3d velocity = material_velocity(at_now.warp(p.position)).velocity;
      const Vec3d predicted = cast<double>(p.position) + dt * velocity;
      const auto found = invert_warp([&](const Vec3d& x) { return at_next.warp(cast<float>(x)); },
                                     canonical[i], predicted, double(kTolerance * step));
      p.position = cast<float>(found.x);
      p.folded |= found.folded || !found.converged ||
                  length(found.x - predicted) > std::abs(dt) * length(velocity) + kJump * step;
    }
  });
}

/// Calls work(time, rows, their points) for the points of every time, and each time once.
template <class Work>
void for_each_time(std::span<const Vec3> points, std::span<const double> time, const Work& work) {
  std::map<double, std::vector<std::size_t>> groups;
  for (std::size_t i = 0; i < points.size(); ++i) groups[time[i]].push_back(i);
  for (const auto& [t, rows] : groups) {
    std::vector<Vec3> part;
    for (const std::size_t i : rows) part.push_back(points[i]);
    work(t, rows, part);
  }
}

}  // namespace

std::vector<std::vector<TrackedPoint>> track(const VoxelModel& model, std::span<const Vec3> points,
                                             double from, std::span<const double> times) {
  // Where a point is depends on the parameter of the curves alone: the way leads along it, so that loops and
  // jumps in time are neither walked round nor leapt over.
  std::vector<std::vector<TrackedPoint>> out(times.size());
  const auto parameter = [&](double t) { return model.motion.time_curve(t); };
  from = parameter(from);
  const auto start = std::make_shared<const FrameSampler>(model, FrameSampler::AtParameter{from});
  std::vector<Vec3d> canonical(points.size());
  std::vector<TrackedPoint> origin(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const FrameSampler::Warp w = start->warp(points[i]);
    origin[i] = {points[i], material_velocity(w).folded};
    canonical[i] = cast<double>(points[i]) + cast<double>(w.displacement);
  }
  const double longest = 1.0 / (kStepsPerPoint * model.motion.points);

  for (const int direction : {-1, 1}) {
    std::vector<std::size_t> order;
    for (std::size_t k = 0; k < times.size(); ++k)
      if (direction < 0 ? parameter(times[k]) < from : parameter(times[k]) >= from) order.push_back(k);
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return direction * parameter(times[a]) < direction * parameter(times[b]);
    });
    std::vector<TrackedPoint> current = origin;
    std::shared_ptr<const FrameSampler> here = start;
    double now = from;
    for (const std::size_t k : order) {
      const double target = parameter(times[k]), reach = target - now;
      const int steps = int(std::ceil(std::abs(reach) / longest - 1e-9));
      for (int s = 1; s <= steps; ++s) {
        const auto next =
            std::make_shared<const FrameSampler>(model, FrameSampler::AtParameter{now + reach * s / steps});
        advance(*here, *next, reach / steps, model.step, canonical, current);
        here = next;
      }
      now = target;
      out[k] = current;
      parallel_for(int(points.size()), [&](int i) {
        TrackedPoint& p = out[k][std::size_t(i)];
        p.density = here->density(p.position);
      });
    }
  }
  return out;
}

std::vector<TrackedPoint> to_canonical(const VoxelModel& model, std::span<const Vec3> points, double time) {
  const FrameSampler sampler(model, std::clamp(time, 0.0, 1.0));
  std::vector<TrackedPoint> out(points.size());
  parallel_for(int(points.size()), [&](int i) {
    const FrameSampler::Warp w = sampler.warp(points[std::size_t(i)]);
    out[std::size_t(i)] = {points[std::size_t(i)] + w.displacement, material_velocity(w).folded};
  });
  return out;
}

std::vector<std::vector<TrackedPoint>> track(const VoxelModel& model, std::span<const Vec3> points,
                                             std::span<const double> from, std::span<const double> times) {
  std::vector<std::vector<TrackedPoint>> out(times.size(), std::vector<TrackedPoint>(points.size()));
  for_each_time(points, from, [&](double time, const auto& rows, const std::vector<Vec3>& part) {
    const auto found = track(model, part, time, times);
    for (std::size_t k = 0; k < out.size(); ++k)
      for (std::size_t j = 0; j < rows.size(); ++j) out[k][rows[j]] = found[k][j];
  });
  return out;
}

std::vector<TrackedPoint> to_canonical(const VoxelModel& model, std::span<const Vec3> points,
                                       std::span<const double> time) {
  std::vector<TrackedPoint> out(points.size());
  for_each_time(points, time, [&](double at, const auto& rows, const std::vector<Vec3>& part) {
    const auto found = to_canonical(model, part, at);
    for (std::size_t j = 0; j < rows.size(); ++j) out[rows[j]] = found[j];
  });
  return out;
}

}  // namespace splinevox
