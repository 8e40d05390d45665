// SPDX-License-Identifier: Apache-2.0
#include "train/film/moving_part.hpp"

#include <algorithm>
#include <cstdint>

#include "core/parallel.hpp"
#include "math/camera.hpp"
#include "render/field_view.hpp"
#include "train/by_time.hpp"
#include "train/square_sums.hpp"

namespace splinevox {
namespace {

constexpr int kCells = 64;  ///< along the longest edge
constexpr int kRun = 4;     ///< pictures in a row
constexpr std::size_t kMostPictures = 512;

enum class Vote { none, quiet, change };

/// What one picture says of cells.
class Voter {
 public:
  Voter(const Camera& camera, const CoarseMask& moving)
      : camera_(camera),
        factor_(moving.factor),
        width_(moving.squares.width()),
        height_(moving.squares.height()),
        sums_(width_, height_, [&](int x, int y) { return moving.squares.test(x, y); }) {}

  /// Of a cell by the square around its projection.
  Vote on(const Vec3& middle, float edge) const {
    const Projection p = project(camera_, cast<double>(middle));
    if (!(p.depth > 0.5 * double(edge) && p.u >= 0 && p.v >= 0 && p.u < camera_.width &&
          p.v < camera_.height))
      return Vote::none;
    constexpr double kHalfDiagonal = 0.87;  // of a cell, in edges
    const double du = kHalfDiagonal * double(edge) * camera_.fx / p.depth,
                 dv = kHalfDiagonal * double(edge) * camera_.fy / p.depth;
    const auto within = [](double at, int squares) { return int(std::clamp(at, 0.0, double(squares))); };
    const auto first = [&](double at, int squares) { return within(at / factor_, squares); };
    const auto last = [&](double at, int squares) { return within(at / factor_ + 1, squares); };
    const int x0 = first(p.u - du, width_), x1 = last(p.u + du, width_), y0 = first(p.v - dv, height_),
              y1 = last(p.v + dv, height_);
    return sums_.in(x0, y0, x1, y1) > 0 ? Vote::change : Vote::quiet;
  }

  /// Calls act(from, along, steps) for each square that shows motion: the points from + i * along are what it
  /// looks through in the box.
  template <class Act>
  void each_ray(const CoarseMask& moving, const Box& box, float step, const Act& act) const {
    for (int y = 0; y < height_; ++y)
      for (int x = 0; x < width_; ++x) {
        if (!moving.squares.test(x, y)) continue;
        const RayInput<float> ray =
            clip_ray(camera_ray(camera_, (x + 0.5) * factor_, (y + 0.5) * factor_), box, step, 0.5f, {});
        act(ray.origin, step * ray.direction, ray.count);
      }
  }

 private:
  const Camera& camera_;
  int factor_, width_, height_;
  SquareSums sums_;  ///< of the squares that show motion
};

/// The longest row of pictures that all show motion before a cell; those that do not see it do not count.
int longest_run(const std::vector<Voter>& voters, const Vec3& middle, float edge) {
  int run = 0, longest = 0;
  for (const Voter& voter : voters) {
    const Vote vote = voter.on(middle, edge);
    if (vote == Vote::none) continue;
    run = vote == Vote::change ? run + 1 : 0;
    longest = std::max(longest, run);
  }
  return longest;
}

}  // namespace

BitGrid cells_that_move(const std::vector<CoarseMask>& moving, const Split& split, const Box& box) {
  if (moving.empty() ||
      std::any_of(moving.begin(), moving.end(), [](const CoarseMask& m) { return m.empty(); }))
    return {};
  std::vector<int> order = frames_by_time(split);
  if (const std::size_t n = order.size(); n > kMostPictures) {
    for (std::size_t i = 0; i < kMostPictures; ++i) order[i] = order[i * n / kMostPictures];
    order.resize(kMostPictures);
  }
  std::vector<Voter> voters;
  for (const int f : order) voters.emplace_back(split.frames[std::size_t(f)].camera, moving[std::size_t(f)]);
  BitGrid cells(box, kCells);
  std::vector<std::uint8_t> free(cells.cells());
  parallel_for(int(free.size()), [&](int c) {
    free[std::size_t(c)] =
        longest_run(voters, cells.center(cells.cell_at(std::size_t(c))), cells.cell) >= kRun;
  });
  for (std::size_t c = 0; c < free.size(); ++c)
    if (free[c]) cells.set(c);
  BitGrid out = cells;
  for (std::size_t i = 0; i < voters.size(); ++i)
    voters[i].each_ray(moving[std::size_t(order[i])], box, 0.5f * cells.cell,
                       [&](const Vec3& from, const Vec3& along, int steps) {
                         const auto cell = [&](int k) { return cells.cell_of(from + float(k) * along); };
                         for (int k = 0; k < steps; ++k)
                           if (cells.test(cells.index(cell(k)))) return;
                         for (int k = 0; k < steps; ++k) {
                           const Vec3 middle = cells.center(cell(k));
                           const auto changes = [&](std::size_t v) {
                             return voters[v].on(middle, cells.cell) == Vote::change;
                           };
                           if ((i > 0 && changes(i - 1)) || (i + 1 < voters.size() && changes(i + 1)))
                             out.set(cells.index(cell(k)));
                         }
                       });
  return dilate(out);
}

}  // namespace splinevox
