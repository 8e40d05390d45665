// SPDX-License-Identifier: Apache-2.0
#include "train/still/changing_cells.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/parallel.hpp"
#include "math/camera.hpp"
#include "render/field_view.hpp"
#include "train/square_sums.hpp"

namespace splinevox {
namespace {

constexpr int kCells = 32;            ///< along the longest edge
constexpr double kMostMoments = 0.8;  ///< of all, that a camera must see to vote
constexpr int kFewestVotes = 2;
constexpr double kAgree = 0.5;  ///< of the cameras that see a cell

enum class Vote { none, quiet, change };

struct Voter {
  const StillCamera& maps;
  const Camera& camera;
  SquareSums sums;

  Vote on(const Vec3& middle, float edge) const {
    double lo[2] = {1e30, 1e30}, hi[2] = {-1e30, -1e30};
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3 half =
          0.5f * edge * Vec3{corner & 1 ? 1.0f : -1, corner & 2 ? 1.0f : -1, corner & 4 ? 1.0f : -1};
      const Projection p = project(camera, cast<double>(middle + half));
      if (!(p.depth > 0)) return Vote::none;
      lo[0] = std::min(lo[0], p.u);
      hi[0] = std::max(hi[0], p.u);
      lo[1] = std::min(lo[1], p.v);
      hi[1] = std::max(hi[1], p.v);
    }
    const Projection seen = project(camera, cast<double>(middle));
    if (!(seen.u >= 0 && seen.v >= 0 && seen.u < camera.width && seen.v < camera.height)) return Vote::none;
    // Clamped before it is an integer: a corner just before the camera may project anywhere.
    const auto within = [](double block, int blocks) { return int(std::clamp(block, 0.0, double(blocks))); };
    const auto first = [&](double at, int blocks) { return within(at / maps.factor - 1, blocks); };
    const auto last = [&](double at, int blocks) { return within(at / maps.factor + 2, blocks); };
    return sums.in(first(lo[0], maps.width), first(lo[1], maps.height), last(hi[0], maps.width),
                   last(hi[1], maps.height)) > 0
               ? Vote::change
               : Vote::quiet;
  }
  /// Calls act(from, along, steps) for the middle of every block that changes: the points from + i * along,
  /// half a cell apart, are what it looks through in the box.
  template <class Act>
  void each_changing_ray(const Box& box, const Act& act) const {
    const float step = 0.5f * box.longest_edge() / kCells;
    for (int y = 0; y < maps.height; ++y)
      for (int x = 0; x < maps.width; ++x) {
        if (!maps.ever[std::size_t(y) * maps.width + x]) continue;
        const RayInput<float> ray = clip_ray(
            camera_ray(camera, (x + 0.5) * maps.factor, (y + 0.5) * maps.factor), box, step, 0.5f, {});
        act(ray.origin, step * ray.direction, ray.count);
      }
  }
};

std::vector<Voter> voters_of(const std::vector<StillCamera>& cameras, const Split& split) {
  std::set<double> all;
  for (const Frame& frame : split.frames) all.insert(frame.time);
  std::vector<Voter> out;
  for (const StillCamera& camera : cameras) {
    std::set<double> moments;
    for (const int f : camera.frames) moments.insert(split.frames[std::size_t(f)].time);
    if (double(moments.size()) < kMostMoments * double(all.size()) || !camera.steady()) continue;
    out.push_back({camera, split.frames[std::size_t(camera.frames.front())].camera,
                   SquareSums(camera.width, camera.height, [&](int x, int y) {
                     const std::size_t i = std::size_t(y) * std::size_t(camera.width) + std::size_t(x);
                     return camera.ever[i] || camera.unknown[i];
                   })});
  }
  return out;
}

}  // namespace

BitGrid changing_cells(const std::vector<StillCamera>& cameras, const Split& split, const Box& box) {
  const std::vector<Voter> voters = voters_of(cameras, split);
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
    voter.each_changing_ray(box, [&](const Vec3& from, const Vec3& along, int steps) {
      const auto each = [&](const auto& act) {
        for (int i = 0; i < steps; ++i) act(cells.index(cells.cell_of(from + float(i) * along)));
      };
      bool explained = false;
      each([&](std::size_t c) { explained |= cells.test(c); });
      if (!explained)
        each([&](std::size_t c) {
          if (votes[c].may_change()) others.set(c);
        });
    });
  return dilate(others);
}

}  // namespace splinevox
