// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

#include "math/camera.hpp"
#include "render/field_view.hpp"
#include "render/occupancy.hpp"
#include "train/square_sums.hpp"

namespace splinevox {

/// What a picture says of a cell: it does not see it, or shows change before it, or none.
enum class Vote { none, quiet, change };

/// A picture in squares of pixels, some of which change, and what they say of cells.
class SquareVotes {
 public:
  /// @param camera  outlives this. @param factor  pixels along a square. @param width, height  squares
  /// @param changes  of square (x, y)
  template <class Changes>
  SquareVotes(const Camera& camera, int factor, int width, int height, const Changes& changes)
      : camera_(camera), factor_(factor), width_(width), height_(height), sums_(width, height, changes) {}

  const Camera& camera() const { return camera_; }
  bool sees(double u, double v) const { return u >= 0 && v >= 0 && u < camera_.width && v < camera_.height; }
  /// Of the squares from pixel (u0, v0) to (u1, v1), and `ring` squares around them.
  Vote vote(double u0, double v0, double u1, double v1, int ring) const {
    // Clamped before it is an integer: a corner just before the camera may project anywhere.
    const auto within = [](double square, int squares) {
      return int(std::clamp(square, 0.0, double(squares)));
    };
    const auto first = [&](double at, int squares) { return within(at / factor_ - ring, squares); };
    const auto last = [&](double at, int squares) { return within(at / factor_ + ring + 1, squares); };
    return sums_.in(first(u0, width_), first(v0, height_), last(u1, width_), last(v1, height_)) > 0
               ? Vote::change
               : Vote::quiet;
  }

  /// What changes before none of `cells` happens elsewhere along its ray: adds to `out` the cells there that
  /// may change. @param changes  of square (x, y). @param may  of the index of a cell
  template <class Changes, class May>
  void add_unexplained(const BitGrid& cells, const Box& box, const Changes& changes, const May& may,
                       BitGrid& out) const {
    const float step = 0.5f * cells.cell;
    for (int y = 0; y < height_; ++y)
      for (int x = 0; x < width_; ++x) {
        if (!changes(x, y)) continue;
        const RayInput<float> ray =
            clip_ray(camera_ray(camera_, (x + 0.5) * factor_, (y + 0.5) * factor_), box, step, 0.5f, {});
        const Vec3 along = step * ray.direction;
        const auto cell = [&](int k) { return cells.index(cells.cell_of(ray.origin + float(k) * along)); };
        bool explained = false;
        for (int k = 0; k < ray.count && !explained; ++k) explained = cells.test(cell(k));
        for (int k = 0; k < ray.count && !explained; ++k)
          if (const std::size_t c = cell(k); may(c)) out.set(c);
      }
  }

 private:
  const Camera& camera_;
  int factor_, width_, height_;
  SquareSums sums_;
};

}  // namespace splinevox
