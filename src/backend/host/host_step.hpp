// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "backend/host/engine.hpp"
#include "backend/host/level_sums.hpp"
#include "backend/step.hpp"

namespace splinevox {

/// The CPU's steps, brick by brick in vector registers, on the caller's own arrays: there is nothing to
/// upload but where they are, and nothing to download. The same bits for any number of threads.
class HostStep final : public StepBackend {
 public:
  /// @param ranks  who makes the steps together; null: nobody else
  explicit HostStep(Ranks* ranks) : ranks_(ranks) {}

  void upload(const StepModel& model) override;
  void download() override {}
  StepSums run(const StepInput& in) override;
  bool learns_depth() const override { return true; }
  bool learns_tracks() const override { return true; }
  bool takes_colour_gradient() const override { return !ranks_; }
  std::vector<int> bad_rays() override { return engine_->bad_rays(); }

 private:
  bool moving() const { return !levels_.empty(); }
  void choose_engine(const RayLosses& losses);
  std::vector<RayTask> own(std::span<const RayTask> tasks) const;
  void sum_ranks(PassResult& pass);
  void spread_motion_gradient();
  void regularise(const StepInput& in);
  std::int64_t unusable_rows() const;
  void discard();
  void update(const StepInput& in);

  Ranks* const ranks_;
  StepModel model_{};
  std::vector<RowMask> marks_;      ///< rows that the step's rays make visible: kept if the step is
  std::unique_ptr<Engine> engine_;  ///< compiled for the order of the harmonics and what changes over time
  int engine_order_ = -1;
  bool engine_moves_ = false, engine_losses_ = false;
  LevelSums sums_;
  Gradient radiance_;
  std::vector<Gradient> levels_;
  std::vector<Vec3> behind_;  ///< gradient of the colour behind each ray of the batch
};

}  // namespace splinevox
