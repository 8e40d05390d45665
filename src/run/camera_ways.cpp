// SPDX-License-Identifier: Apache-2.0
#include "run/camera_ways.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "math/rotation.hpp"
#include "run/training_cameras.hpp"

namespace splinevox::run {
namespace {

/// A camera as numbers that can be averaged: quaternion, place, distance, lens in picture widths. With a
/// middle the place is the direction from there; without one it is the position. Of the distance they hold
/// the logarithm, so that all numbers but positions are without unit.
using Numbers = std::array<double, 12>;

Numbers numbers_of(const Camera& c, const std::optional<Vec3d>& middle) {
  const Quaternion q = quaternion_of(c.axes);
  const Vec3d from = middle ? c.position - *middle : c.position;
  const double distance = middle ? std::max(length(from), 1e-12) : 1, w = c.width;
  return {q[0],
          q[1],
          q[2],
          q[3],
          from.x / distance,
          from.y / distance,
          from.z / distance,
          std::log(distance),
          c.fx / w,
          c.fy / w,
          (c.cx - 0.5 * w) / w,
          (c.cy - 0.5 * c.height) / w};
}

/// @param like  whose size the picture has
Camera camera_of(const Numbers& n, const std::optional<Vec3d>& middle, const Camera& like) {
  Camera c;
  c.width = like.width;
  c.height = like.height;
  const double w = c.width;
  c.axes = axes_of({n[0], n[1], n[2], n[3]});
  const Vec3d place{n[4], n[5], n[6]};
  // Half-way between opposite cameras there is no direction: then the one that the camera looks back along.
  const Vec3d out = length(place) > 1e-9 ? normalize(place) : c.axes[2];
  c.position = middle ? *middle + std::exp(n[7]) * out : place;
  c.fx = n[8] * w;
  c.fy = n[9] * w;
  c.cx = 0.5 * w + n[10] * w;
  c.cy = 0.5 * c.height + n[11] * w;
  return c;
}

/// Of a quaternion and its negative the one that is nearer to the one before.
void align(Numbers& n, const Numbers& before) {
  double along = 0;
  for (std::size_t i = 0; i < 4; ++i) along += n[i] * before[i];
  for (std::size_t i = 0; along < 0 && i < 4; ++i) n[i] = -n[i];
}

std::vector<Numbers> aligned_numbers(const std::vector<Camera>& cameras, const std::optional<Vec3d>& middle) {
  std::vector<Numbers> out;
  for (const Camera& c : cameras) {
    out.push_back(numbers_of(c, middle));
    if (out.size() > 1) align(out.back(), out[out.size() - 2]);
  }
  return out;
}

double distance(const Numbers& a, const Numbers& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum);
}

/// How far a camera is from another: what it moves, and what it turns in units of `scale`.
double step(const Camera& a, const Camera& b, double scale) {
  const Quaternion p = quaternion_of(a.axes), q = quaternion_of(b.axes);
  const double along = p[0] * q[0] + p[1] * q[1] + p[2] * q[2] + p[3] * q[3];
  return length(a.position - b.position) + scale * std::sqrt(std::max(0.0, 2 - 2 * std::abs(along)));
}

/// Root of the mean squared distance of positions from their mean.
double spread(const std::vector<Camera>& cameras) {
  Vec3d mean{};
  for (const Camera& c : cameras) mean += c.position * (1 / double(cameras.size()));
  double sum = 0;
  for (const Camera& c : cameras) sum += dot(c.position - mean, c.position - mean);
  return std::sqrt(sum / double(cameras.size()));
}

Camera mean_camera(const std::vector<Camera>& cameras) {
  Numbers sum{};
  const Numbers first = numbers_of(cameras.front(), {});
  for (const Camera& c : cameras) {
    Numbers n = numbers_of(c, {});
    align(n, first);
    for (std::size_t i = 0; i < n.size(); ++i) sum[i] += n[i] / double(cameras.size());
  }
  return camera_of(sum, {}, cameras.front());
}

}  // namespace

std::vector<Camera> orbit(const Box& box, double elevation, int size, int count) {
  constexpr double kView = 36;  // degrees
  const double half = kView / 2 * std::numbers::pi / 180, up = elevation * std::numbers::pi / 180;
  const Vec3d centre = cast<double>(box.center());
  const double distance = 0.5 * length(cast<double>(box.extent())) / std::sin(half);
  std::vector<Camera> cameras;
  for (int i = 0; i < count; ++i) {
    const double a = 2 * std::numbers::pi * i / count;
    const Vec3d out{std::cos(up) * std::cos(a), std::cos(up) * std::sin(a), std::sin(up)};
    Camera c;
    c.width = c.height = size;
    c.fx = c.fy = 0.5 * size / std::tan(half);
    c.cx = c.cy = 0.5 * size;
    const Vec3d right{-std::sin(a), std::cos(a), 0};
    c.axes = {right, cross(out, right), out};
    c.position = centre + distance * out;
    cameras.push_back(c);
  }
  return cameras;
}

std::vector<Camera> stabilised(const std::vector<Shot>& film, double window, const std::vector<double>& at) {
  constexpr std::size_t kFewest = 5;
  const std::size_t n = film.size();
  std::vector<Camera> cameras;
  for (const Shot& s : film) cameras.push_back(s.camera);
  const std::vector<Numbers> numbers = aligned_numbers(cameras, {});
  const double first = film.front().time, span = film.back().time - first;
  std::vector<double> when, away(n);
  for (std::size_t i = 0; i < n; ++i)
    when.push_back(span > 0 ? (film[i].time - first) / span : double(i) / double(n - 1));
  std::vector<Camera> out;
  for (const double t : at) {
    for (std::size_t i = 0; i < n; ++i) away[i] = std::abs(when[i] - t);
    std::vector<double> sorted = away;
    const std::size_t used = std::min(kFewest, n) - 1;
    std::nth_element(sorted.begin(), sorted.begin() + std::ptrdiff_t(used), sorted.end());
    const double half = std::max(0.5 * window, 1.0001 * sorted[used] + 1e-12);
    double w0 = 0, w1 = 0, w2 = 0;
    Numbers sum{}, slope{};
    for (std::size_t i = 0; i < n; ++i) {
      const double u = away[i] / half, v = 1 - u * u * u, w = u < 1 ? v * v * v : 0, x = when[i] - t;
      w0 += w;
      w1 += w * x;
      w2 += w * x * x;
      for (std::size_t k = 0; k < sum.size(); ++k) {
        sum[k] += w * numbers[i][k];
        slope[k] += w * x * numbers[i][k];
      }
    }
    const double det = w0 * w2 - w1 * w1;
    Numbers value;
    for (std::size_t k = 0; k < sum.size(); ++k)
      value[k] = det > 1e-12 * w0 * w2 ? (w2 * sum[k] - w1 * slope[k]) / det : sum[k] / w0;
    out.push_back(camera_of(value, {}, film.front().camera));
  }
  return out;
}

std::vector<Camera> interpolated(const std::vector<Camera>& cameras, const Vec3d& middle, bool closed,
                                 const std::vector<double>& at) {
  std::vector<Numbers> through = aligned_numbers(cameras, middle);
  if (closed) {
    through.push_back(through.front());
    align(through.back(), through[through.size() - 2]);
  }
  const std::size_t last = through.size() - 1;
  std::vector<double> knots{0};
  for (std::size_t i = 0; i < last; ++i)
    knots.push_back(knots.back() + std::max(distance(through[i], through[i + 1]), 1e-9));
  /// The neighbour of a knot, and how far along it is; past the ends of a closed way it goes round.
  const auto neighbour = [&](std::size_t i, int by) -> std::pair<double, Numbers> {
    if (by < 0 && i == 0) {
      if (!closed) return {knots[0], through[0]};
      Numbers n = through[last - 1];
      align(n, through[0]);
      return {knots[last - 1] - knots[last], n};
    }
    if (by > 0 && i == last) {
      if (!closed) return {knots[last], through[last]};
      Numbers n = through[1];
      align(n, through[last]);
      return {knots[last] + knots[1], n};
    }
    const std::size_t j = by < 0 ? i - 1 : i + 1;
    return {knots[j], through[j]};
  };
  const auto tangent = [&](std::size_t i) {
    const auto [a, before] = neighbour(i, -1);
    const auto [b, after] = neighbour(i, 1);
    Numbers out;
    for (std::size_t k = 0; k < out.size(); ++k) out[k] = (after[k] - before[k]) / (b - a);
    return out;
  };
  std::vector<Camera> out;
  for (const double t : at) {
    const double s = t * knots[last];
    const auto after = std::upper_bound(knots.begin(), knots.end(), s) - knots.begin();
    const std::size_t i = std::min(std::size_t(std::max<std::ptrdiff_t>(after - 1, 0)), last - 1);
    const double h = knots[i + 1] - knots[i], u = (s - knots[i]) / h, v = 1 - u;
    const Numbers from = tangent(i), to = tangent(i + 1);
    Numbers n;
    for (std::size_t k = 0; k < n.size(); ++k)
      n[k] = v * v * (1 + 2 * u) * through[i][k] + u * u * (1 + 2 * v) * through[i + 1][k] +
             h * u * v * (v * from[k] - u * to[k]);
    out.push_back(camera_of(n, middle, cameras.front()));
  }
  return out;
}

std::vector<Camera> round_trip(std::vector<Camera> cameras, std::size_t most) {
  const double scale = std::max(spread(cameras), 1e-9);
  const auto far = [&](const Camera& a, const Camera& b) { return step(a, b, scale); };
  // Each next one is the furthest from all that are taken.
  std::vector<double> least(cameras.size(), std::numeric_limits<double>::infinity());
  const std::size_t count = std::min(most, cameras.size());
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t next =
        k == 0
            ? 0
            : std::size_t(std::max_element(least.begin() + std::ptrdiff_t(k), least.end()) - least.begin());
    std::swap(cameras[k], cameras[next]);
    std::swap(least[k], least[next]);
    for (std::size_t i = k + 1; i < cameras.size(); ++i)
      least[i] = std::min(least[i], far(cameras[k], cameras[i]));
  }
  cameras.resize(count);
  for (std::size_t k = 1; k + 1 < count; ++k) {
    const auto nearest = std::min_element(
        cameras.begin() + std::ptrdiff_t(k), cameras.end(),
        [&](const Camera& a, const Camera& b) { return far(cameras[k - 1], a) < far(cameras[k - 1], b); });
    std::swap(cameras[k], *nearest);
  }
  // A part of the trip is reversed while that makes it shorter.
  bool shorter = count > 3;
  while (shorter) {
    shorter = false;
    for (std::size_t i = 1; i + 1 < count; ++i)
      for (std::size_t j = i + 1; j < count; ++j) {
        const Camera &a = cameras[i - 1], &b = cameras[i], &c = cameras[j], &d = cameras[(j + 1) % count];
        if (far(a, c) + far(b, d) > far(a, b) + far(c, d) - 1e-9 * scale) continue;
        std::reverse(cameras.begin() + std::ptrdiff_t(i), cameras.begin() + std::ptrdiff_t(j) + 1);
        shorter = true;
      }
  }
  return cameras;
}

bool open_at_wide_leg(std::vector<Camera>& trip, const Vec3d& middle) {
  constexpr double kWidest = std::numbers::pi / 3, kMuchWider = 1.5;
  double widest = 0, second = 0;
  std::size_t start = 0;  // behind that leg
  for (std::size_t i = 0; i < trip.size(); ++i) {
    const std::size_t next = (i + 1) % trip.size();
    const double leg = angle_between(trip[i].position - middle, trip[next].position - middle);
    second = std::max(second, std::min(leg, widest));
    if (leg <= widest) continue;
    widest = leg;
    start = next;
  }
  if (widest <= kWidest || widest < kMuchWider * second) return false;
  std::rotate(trip.begin(), trip.begin() + std::ptrdiff_t(start), trip.end());
  return true;
}

std::vector<Camera> spiral(const std::vector<Camera>& cameras, const Vec3d& middle,
                           const std::vector<double>& at) {
  constexpr int kTurns = 2;
  const Camera mean = mean_camera(cameras);
  Vec3d half{};  // of the ellipse
  for (const Camera& c : cameras)
    for (int k = 0; k < 3; ++k) {
      const double off = dot(c.position - mean.position, mean.axes[k]);
      half[k] += off * off / double(cameras.size());
    }
  const Vec3d look = mean.position - std::max(dot(mean.position - middle, mean.axes[2]), 1e-6) * mean.axes[2];
  std::vector<Camera> out;
  for (const double t : at) {
    const double a = 2 * std::numbers::pi * kTurns * t;
    Camera c = mean;
    c.position = mean.position + std::sqrt(half[0]) * std::cos(a) * mean.axes[0] +
                 std::sqrt(half[1]) * std::sin(a) * mean.axes[1] +
                 std::sqrt(half[2]) * std::sin(a / kTurns) * mean.axes[2];
    c.axes[2] = normalize(c.position - look);
    c.axes[0] = normalize(cross(mean.axes[1], c.axes[2]));
    c.axes[1] = cross(c.axes[2], c.axes[0]);
    out.push_back(c);
  }
  return out;
}

}  // namespace splinevox::run
