// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "backend/host/gradient.hpp"
#include "field/outer_walk.hpp"
#include "render/scatter.hpp"
#include "train/archive.hpp"
#include "train/learner.hpp"
#include "train/start.hpp"

namespace splinevox {

/// Thin fog in the colour of the background everywhere around the box; none where none are learned.
/// @param unit  of brightness (train/start.hpp)
Surroundings starting_surroundings(const Config& config, const Box& box, const Background& background,
                                   const PictureStats& stats, float unit);

/// Learns the surroundings from what the steps say of the colours behind their rays. It works on the host,
/// whoever makes the steps: no ray of the box needs to know of it. The same bits for any number of threads.
class SurroundingsLearner {
 public:
  SurroundingsLearner() = default;
  SurroundingsLearner(const Config& config, const Surroundings& surroundings, float unit = 1);

  /// One step. @param rays  of the batch, in the data's own coordinates. @param behind  gradient of the
  /// colour behind the box; what is left of it behind the surroundings takes its place
  void step(const Config& config, std::span<const Ray> rays, std::span<Vec3> behind,
            const Background& background, const StepInput& in, Surroundings& surroundings);
  /// Puts them on the lattice that is due, without the bricks in which there is nothing.
  void refine(const Config& config, double progress, Surroundings& surroundings);
  /// Saves or restores them and what they are learned by. False: what was restored does not fit.
  bool archive(Archive& a, const Config& config, Surroundings& surroundings);

 private:
  using Walked = std::vector<Record<float, OuterWalk::kWidth>>;

  void begin(const Config& config, const Surroundings& surroundings);

  float unit_ = 1;  ///< of brightness
  int stage_ = 0;
  Learner learner_;
  Gradient gradient_;  ///< zero between steps
  std::vector<Walked> records_;
  Scatter<float, OuterWalk::kWidth, false> scatter_;
};

}  // namespace splinevox
