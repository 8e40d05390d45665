// SPDX-License-Identifier: Apache-2.0
#include "data/truth.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "core/parallel.hpp"
#include "data/pictures/exr.hpp"
#include "math/camera.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox {
namespace {

constexpr double kMiss = 2;  ///< pixels of the truth that the median point may lie beside its own: a sample
                             ///< lies within one, half floats add a fraction

Vec3 at(const Image& image, int x, int y) {
  const float* p = image.pixel(x, y);
  return {p[0], p[1], p[2]};
}

bool hit(const Vec3& v) { return v.x != 0 || v.y != 0 || v.z != 0; }

const Image& vectors(const std::vector<ExrLayer>& layers, const char* name, const std::string& path) {
  const Image& image = find_exr_layer(layers, name, path).image;
  if (image.channels < 3)
    fail({.where = path,
          .what = "layer '" + std::string(name) + "' is not a vector",
          .expected = "3 channels or more",
          .got = std::to_string(image.channels),
          .hint = {}});
  return image;
}

SurfaceFrame read_frame(const std::string& path, const Frame& frame, float jump) {
  const std::vector<ExrLayer> layers = read_exr_layers(path);
  const Image &position = vectors(layers, "position", path), &rest = vectors(layers, "rest", path);
  SurfaceFrame out{frame.time, {}, {}};
  std::vector<double> misses;  // of the points, from the pixels they stand in
  const auto miss = [&](int x, int y) {
    const Projection seen = project(frame.camera, cast<double>(at(position, x, y)));
    const double u = seen.u * position.width / frame.camera.width,
                 v = seen.v * position.height / frame.camera.height;
    return seen.depth > 0 ? std::hypot(u - (x + 0.5), v - (y + 0.5)) : HUGE_VAL;
  };
  const auto inside = [&](int x, int y) {
    const Vec3 p = at(position, x, y), r = at(rest, x, y);
    for (int v = y - 1; v <= y + 1; ++v)
      for (int u = x - 1; u <= x + 1; ++u) {
        const Vec3 q = at(position, u, v);
        // A pixel that is not a number is no surface, nor is its neighbour's edge known: no comparison holds
        // for it (numerics H29).
        if (!hit(q) || !(length(q - p) <= jump) || !(length(at(rest, u, v) - r) <= jump)) return false;
      }
    return true;
  };
  for (int y = 1; y + 1 < position.height; ++y)
    for (int x = 1; x + 1 < position.width; ++x)
      if (inside(x, y)) {
        out.position.push_back(at(position, x, y));
        out.rest.push_back(at(rest, x, y));
        misses.push_back(miss(x, y));
      }
  if (misses.empty()) return out;
  const auto median = misses.begin() + std::ptrdiff_t(misses.size() / 2);
  std::nth_element(misses.begin(), median, misses.end());
  if (!(*median <= kMiss))
    fail({.where = path,
          .what = "the motion ground truth belongs to another view than '" + frame.name + "'",
          .expected =
              fmt::format("positions that this view's camera sees at their own pixels, within {:g}", kMiss),
          .got = std::isinf(*median) ? std::string("points behind the camera")
                                     : fmt::format("the median point {:.0f} pixels away", *median),
          .hint = "truth is read by the picture's name: score the split whose views it was rendered for, "
                  "often --split test"});
  return out;
}

}  // namespace

std::vector<SurfaceFrame> read_truth(const std::string& dataset, const Split& split, float jump) {
  std::vector<SurfaceFrame> out(split.frames.size());
  parallel_for(int(out.size()), [&](int f) {
    const Frame& frame = split.frames[f];
    const std::string path = dataset + "/truth/" + frame.name + "_0000.exr";
    if (!std::filesystem::exists(path))
      fail({.where = path,
            .what = "there is no motion ground truth for this view",
            .expected = "an OpenEXR file with layers 'position' and 'rest'",
            .got = "no such file",
            .hint = "leave out --truth, or make a data set that has it: splinevox synth"});
    out[f] = read_frame(path, frame, jump);
  });
  return out;
}

}  // namespace splinevox
