// SPDX-License-Identifier: Apache-2.0
#include "data/lens_notes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "math/camera.hpp"

namespace splinevox::data {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;
constexpr double kNarrowest = 5, kWidest = 170;  ///< degrees, of a lens without fisheye
constexpr double kUneven = 2;                    ///< of the focal lengths along x and y
constexpr double kAgree = 0.01;                  ///< of focal lengths that are given twice

double degrees(double focal, int pixels) { return kDegrees * angle_of(focal, pixels); }

/// Degrees, without a point where they are large and without "0" where they are small.
std::string angle_text(double angle) {
  return angle < 10 ? fmt::format("{:.2g}", angle) : fmt::format("{:.0f}", angle);
}

std::string view_text(const Camera& c) {
  return angle_text(degrees(c.fx, c.width)) + " x " + angle_text(degrees(c.fy, c.height)) + " degrees";
}

bool is_odd(const Camera& c) {
  if (c.lens.kind == Distortion::Kind::fisheye) return false;
  const double across = degrees(c.fx, c.width), down = degrees(c.fy, c.height);
  const double uneven = std::max(c.fx / c.fy, c.fy / c.fx);
  return std::min(across, down) < kNarrowest || std::max(across, down) > kWidest || uneven > kUneven;
}

/// A field of view that the data gives beside a focal length which is used, where they differ.
struct Other {
  const char* angle = nullptr;  ///< the field's name
  const char* focal = nullptr;
  double view = 0;  ///< degrees, by the angle
};

Other other_view(const Lens& lens, const Camera& c) {
  const auto differ = [](const std::optional<double>& angle, double focal, int pixels) {
    return angle && std::abs(focal_of(*angle, pixels) / focal - 1) > kAgree;
  };
  if (lens.fl_x && differ(lens.camera_angle_x, c.fx, c.width))
    return {"camera_angle_x", "fl_x", *lens.camera_angle_x * kDegrees};
  if (lens.fl_y && differ(lens.camera_angle_y, c.fy, c.height))
    return {"camera_angle_y", "fl_y", *lens.camera_angle_y * kDegrees};
  return {};
}

}  // namespace

void note_lenses(const RawSplit& raw, const Split& split, std::vector<std::string>& notes) {
  std::size_t odd = 0, twice = 0, first_odd = 0, first_twice = 0;
  Other other;
  for (std::size_t i = split.frames.size(); i-- > 0;) {
    const Camera& camera = split.frames[i].camera;
    if (is_odd(camera)) {
      ++odd;
      first_odd = i;
    }
    if (const Other o = other_view(raw.frames[i].lens, camera); o.angle) {
      ++twice;
      first_twice = i;
      other = o;
    }
  }
  const std::string all = std::to_string(split.frames.size()) + " frames ";
  if (twice > 0) {
    const Camera& c = split.frames[first_twice].camera;
    const bool x = std::string_view(other.focal) == "fl_x";
    notes.push_back(fmt::format(
        "{}: in {} of {}{} and {} do not agree: {} degrees and {}; {} is used{}", raw.name, twice, all,
        other.focal, other.angle, angle_text(x ? degrees(c.fx, c.width) : degrees(c.fy, c.height)),
        angle_text(other.view), other.focal,
        odd > 0 ? ", though the field of view is then " + view_text(c) + ", as of no usual lens" : ""));
  } else if (odd > 0) {
    notes.push_back(fmt::format(
        "{}: {} of {}see {}, as no usual lens does: check focal lengths and the size they are for", raw.name,
        odd, all, view_text(split.frames[first_odd].camera)));
  }
}

}  // namespace splinevox::data
