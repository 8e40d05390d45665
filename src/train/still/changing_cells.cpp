// SPDX-License-Identifier: Apache-2.0
#include "train/still/changing_cells.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/parallel.hpp"
#include "data/times/seen_moments.hpp"
#include "train/cell_votes.hpp"

namespace splinevox {
namespace {

constexpr int kCells = 32;            ///< along the longest edge
constexpr double kMostMoments = 0.8;  ///< of all, that a camera must see to vote
constexpr int kFewestVotes = 2;
constexpr double kAgree = 0.5;  ///< of the cameras that see a cell

struct Voter {
  const StillCamera& maps;
  SquareVotes squares;

  /// Of a cell by the squares around its corners.
  Vote on(const Vec3& middle, float edge) const {
    double lo[2] = {1e30, 1e30}, hi[2] = {-1e30, -1e30};
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3 half =
          0.5f * edge * Vec3{corner & 1 ? 1.0f : -1, corner & 2 ? 1.0f : -1, corner & 4 ? 1.0f : -1};
      const Projection p = project(squares.camera(), cast<double>(middle + half));
      if (!(p.depth > 0)) return Vote::none;
      lo[0] = std::min(lo[0], p.u);
      hi[0] = std::max(hi[0], p.u);
      lo[1] = std::min(lo[1], p.v);
      hi[1] = std::max(hi[1], p.v);
    }
    const Projection seen = project(squares.camera(), cast<double>(middle));
    return squares.sees(seen.u, seen.v) ? squares.vote(lo[0], lo[1], hi[0], hi[1], 1) : Vote::none;
  }
};

/// Those that see nearly every moment, in steady light.
std::vector<const StillCamera*> voting(const std::vector<StillCamera>& cameras, const Split& split) {
  std::set<double> moments;
  for (const Frame& frame : split.frames) moments.insert(frame.time);
  std::vector<std::set<double>> seen(cameras.size());
  for (std::size_t c = 0; c < cameras.size(); ++c)
    for (const int f : cameras[c].frames) seen[c].insert(split.frames[std::size_t(f)].time);
  const std::vector<double> shares = shares_of_moments(seen, moments);
  std::vector<const StillCamera*> out;
  for (std::size_t c = 0; c < cameras.size(); ++c)
    if (shares[c] >= kMostMoments && cameras[c].steady()) out.push_back(&cameras[c]);
  return out;
}

Voter voter_of(const StillCamera& camera, const Split& split) {
  return {camera, SquareVotes(split.frames[std::size_t(camera.frames.front())].camera, camera.factor,
                              camera.width, camera.height, [&](int x, int y) {
                                const std::size_t i = camera.block(x, y);
                                return camera.ever[i] || camera.unknown[i];
                              })};
}

}  // namespace

bool tell_cells(const std::vector<StillCamera>& cameras, const Split& split) {
  return int(voting(cameras, split).size()) >= kFewestVotes;
}

BitGrid changing_cells(const std::vector<StillCamera>& cameras, const Split& split, const Box& box) {
  std::vector<Voter> voters;
  for (const StillCamera* camera : voting(cameras, split)) voters.push_back(voter_of(*camera, split));
  if (int(voters.size()) < kFewestVotes) return {};
  BitGrid cells(box, kCells);
  struct Votes {
    int quiet = 0, change = 0;
    bool may_change() const { return quiet < kFewestVotes || quiet < kAgree * (quiet + change); }
  };
  std::vector<Votes> votes(cells.cells());
  parallel_for(int(cells.cells()), [&](int c) {
    for (const Voter& voter : voters) {
      const Vote vote = voter.on(cells.center(cells.cell_at(std::size_t(c))), cells.cell);
      votes[std::size_t(c)].quiet += vote == Vote::quiet;
      votes[std::size_t(c)].change += vote == Vote::change;
    }
  });
  for (std::size_t c = 0; c < votes.size(); ++c)
    if (votes[c].may_change() && votes[c].change >= kFewestVotes) cells.set(c);
  // What no such cell explains happens somewhere else before the camera.
  BitGrid others = cells;
  for (const Voter& voter : voters)
    voter.squares.add_unexplained(
        cells, box, [&](int x, int y) { return voter.maps.ever[voter.maps.block(x, y)]; },
        [&](std::size_t c) { return votes[c].may_change(); }, others);
  return dilate(others);
}

}  // namespace splinevox
