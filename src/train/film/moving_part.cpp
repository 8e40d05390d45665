// SPDX-License-Identifier: Apache-2.0
#include "train/film/moving_part.hpp"

#include <algorithm>
#include <cstdint>

#include "core/parallel.hpp"
#include "train/by_time.hpp"
#include "train/cell_votes.hpp"

namespace splinevox {
namespace {

constexpr int kCells = 64;  ///< along the longest edge
constexpr int kRun = 4;     ///< pictures in a row
constexpr std::size_t kMostPictures = 512;

/// What a picture says of a cell, by the square around its projection.
Vote vote_on(const SquareVotes& picture, const Vec3& middle, float edge) {
  const Camera& camera = picture.camera();
  const Projection p = project(camera, cast<double>(middle));
  if (!(p.depth > 0.5 * double(edge) && picture.sees(p.u, p.v))) return Vote::none;
  constexpr double kHalfDiagonal = 0.87;  // of a cell, in edges
  const double du = kHalfDiagonal * double(edge) * camera.fx / p.depth,
               dv = kHalfDiagonal * double(edge) * camera.fy / p.depth;
  return picture.vote(p.u - du, p.v - dv, p.u + du, p.v + dv, 0);
}

/// The longest row of pictures that all show motion before a cell; those that do not see it do not count.
int longest_run(const std::vector<SquareVotes>& voters, const Vec3& middle, float edge) {
  int run = 0, longest = 0;
  for (const SquareVotes& voter : voters) {
    const Vote vote = vote_on(voter, middle, edge);
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
  const auto changes = [](const CoarseMask& mask) {
    return [&mask](int x, int y) { return mask.squares.test(x, y); };
  };
  std::vector<SquareVotes> voters;
  for (const int f : order) {
    const CoarseMask& mask = moving[std::size_t(f)];
    voters.emplace_back(split.frames[std::size_t(f)].camera, mask.factor, mask.squares.width(),
                        mask.squares.height(), changes(mask));
  }
  BitGrid cells(box, kCells);
  std::vector<std::uint8_t> free(cells.cells());
  parallel_for(int(free.size()), [&](int c) {
    free[std::size_t(c)] =
        longest_run(voters, cells.center(cells.cell_at(std::size_t(c))), cells.cell) >= kRun;
  });
  for (std::size_t c = 0; c < free.size(); ++c)
    if (free[c]) cells.set(c);
  BitGrid out = cells;
  for (std::size_t i = 0; i < voters.size(); ++i) {
    const auto shown = [&](std::size_t v, std::size_t cell) {
      return vote_on(voters[v], cells.center(cells.cell_at(cell)), cells.cell) == Vote::change;
    };
    voters[i].add_unexplained(
        cells, box, changes(moving[std::size_t(order[i])]),
        [&](std::size_t c) {
          return (i > 0 && shown(i - 1, c)) || (i + 1 < voters.size() && shown(i + 1, c));
        },
        out);
  }
  return dilate(out);
}

}  // namespace splinevox
