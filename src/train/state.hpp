// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "splinevox/train/trainer.hpp"
#include "train/archive.hpp"
#include "train/batch.hpp"
#include "train/home.hpp"
#include "train/learn_background.hpp"
#include "train/learn_cameras.hpp"
#include "train/learn_depth.hpp"
#include "train/learn_surroundings.hpp"
#include "train/learn_tracks.hpp"
#include "train/plan.hpp"
#include "train/run_clock.hpp"
#include "train/setting.hpp"

namespace splinevox {

/// Parameters and everything else a run carries from step to step.
struct Trainer::State {
  State(const Config& config, const Split& train, const TimeMap& time_map, Ranks* ranks,
        std::unique_ptr<StepBackend> backend);

  const Setting setting;
  Ranks* const ranks;              ///< who trains with us; null: nobody
  bool told;                       ///< what moves is told by the frames, not by cameras that stand still
  std::vector<CoarseMask> moving;  ///< what moves in each frame; empty: nobody knows
  Home home;
  BatchSampler sampler;
  BackgroundLearner background;  ///< of the volume's background, if that is learned
  SurroundingsLearner surroundings;
  CameraLearner cameras;             ///< of the volume's cameras
  ErrorMap errors;                   ///< of the training pictures; empty: rays are drawn evenly
  DepthFits depths;                  ///< empty: no depth is asked for
  const float depth_weight;          ///< of its loss
  const std::vector<char> followed;  ///< which points move, by their tracks; empty: no track is asked for
  RunClock clock;
  double progress = 0;  ///< of the last refine
  Plan plan;
  Batch batch;                        ///< of the last step
  TrackBatch tracks;                  ///< of the same; nothing where no track is asked for
  ColourLoss own_loss;                ///< in place of the photometric one; empty: that
  std::optional<double> lost;         ///< what it gave for the last step
  std::vector<StepReport> discarded;  ///< the last steps, as far as they were discarded in a row

  TimeWindow window() const { return {sampler.window(progress), sampler.whole(progress)}; }
  /// Runs the events that are due at the progress. True if a lattice changed, or bricks were pruned.
  bool refine(double progress_now);
  /// Whether the occupancy is due for a refresh: twice as often while the window of time grows.
  bool occupancy_is_due() const;
  void refresh_occupancy();
  /// Depth maps are fitted anew, if that is due.
  void fit_depths();
  /// The rays of the next step.
  void draw();
  /// What it asks for. Good until the next draw.
  StepInput step_input();
  /// A step on the background and the surroundings, if they are learned.
  void learn_background(const StepInput& in, BackgroundGradient gradient);
  /// A step on what is learned of the cameras.
  void learn_cameras(const StepInput& in, const StepSums& sums);
  /// The report of a step that changed nothing, which is remembered. After too many in a row, back to the
  /// last good one and an error.
  StepReport discard(const StepSums& sums, StepReport report);
  void archive(Archive& a);

 private:
  void tell_what_moves();
  ColourGradient colour_gradient_;  ///< asks `own_loss`
  std::vector<Vec3> behind_;        ///< gradient of the colour behind each ray of the batch, if it is wanted
  RayLosses ray_losses() const;
};

}  // namespace splinevox
