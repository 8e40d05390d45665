// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "backend/step.hpp"

namespace splinevox {

/// The rays of a batch that one rank's device computes: of every slot one piece in a row, so equally many of
/// each. All of them where nobody else computes any.
class RayShare {
 public:
  /// @param in  must stay as long as the share is used. @param ranks  null: nobody else
  void take(const StepInput& in, const Ranks* ranks);

  std::span<const RayInput<float>> rays() const { return rays_; }
  std::span<const Vec3> targets() const { return targets_; }
  std::span<const RayTask> tasks() const { return tasks_; }
  int per_slot() const { return int(own_); }
  /// Number in the batch of a ray of the share.
  int in_batch(int ray) const;

 private:
  std::size_t drawn_ = 0, first_ = 0, own_ = 0;  ///< rays of a slot: of the batch, before the share, in it
  std::span<const RayInput<float>> rays_;
  std::span<const Vec3> targets_;
  std::span<const RayTask> tasks_;
  std::vector<RayInput<float>> own_rays_;
  std::vector<Vec3> own_targets_;
  std::vector<RayTask> own_tasks_;
};

}  // namespace splinevox
