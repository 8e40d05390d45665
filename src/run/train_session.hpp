// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <functional>
#include <future>
#include <limits>
#include <memory>
#include <optional>
#include <string>

#include "backend/step.hpp"
#include "core/ranks.hpp"
#include "io/checkpoint.hpp"
#include "run/held_camera.hpp"
#include "run/progress.hpp"
#include "run/run_folder.hpp"
#include "run/watcher.hpp"
#include "splinevox/backend/device.hpp"
#include "splinevox/data/scene.hpp"
#include "splinevox/train/trainer.hpp"

namespace splinevox::run {

/// Trains into a run folder: steps, reports, pictures of a held-out view, checkpoints, the final files.
class TrainSession {
 public:
  struct Setup {
    const Config& config;
    const Dataset& data;
    const RunFolder& folder;
    double seconds_used;                 ///< of the budget, before this
    bool resume;                         ///< there is a checkpoint to go on from
    Ranks* ranks;                        ///< who trains with us, if any; only the first of them writes
    Device device;                       ///< makes pictures
    std::unique_ptr<StepBackend> steps;  ///< makes steps, there and with those ranks
    Watcher* watcher = nullptr;          ///< who looks at it, if anybody; not with ranks
    /// Adds seconds to the budget that the run's files and `config` have; the new one. Only with a watcher.
    std::function<double(double)> longer = {};
  };
  TrainSession(Setup setup, Progress& progress);

  /// Until the budget is spent or a signal asks to stop; saves either way. Returns the figures of
  /// metrics.json.
  Json run();
  /// Whether a signal made `run` end.
  bool interrupted() const { return interrupted_; }
  /// Seconds of the budget that are gone.
  double seconds() const { return last_.seconds; }

 private:
  double clock() const;
  bool writes() const { return !setup_.ranks || setup_.ranks->first(); }
  bool go_on();
  void look(bool held_out_view_due);
  void obey();
  void log_wish(const char* what, const Json& more, const std::string& text);
  void add_time(double seconds);
  void hand_over(VoxelModel model, double started);
  void step();
  void report(const Json& line);
  void save_replay();
  bool held_out_view_due(double seconds) const;
  /// @param start  when this began, the making of the model included
  Image picture_of(const VoxelModel& model, const Frame& view, Device device) const;
  void render_held_out_view(const VoxelModel& model, double start);
  /// Of a film that moves: how far what stands still goes, and a warning if that is far.
  void hold_camera(const VoxelModel& model);
  void resume();
  CheckpointHeader header() const;
  void start_checkpoint();
  void finish_checkpoint();
  void try_finish_checkpoint();
  void save_manifest(const FileDigest& model);
  Json figures() const;

  Setup setup_;
  Progress& progress_;
  Trainer trainer_;
  std::optional<Frame> held_out_;  ///< a held-out view, or a training view if there is none
  bool no_held_out_ = false;
  const char* held_out_split() const { return no_held_out_ ? "train" : "val"; }
  std::optional<HeldCamera> held_camera_;
  double held_out_psnr_ = std::numeric_limits<double>::quiet_NaN();
  double held_out_cost_ = 0, held_out_spent_ = 0, held_out_step_ = -1;
  double begun_at_ = 0, rays_before_ = 0;  ///< seconds of training and in its ray loop, of earlier sessions
  double stepped_at_ = 0;                  ///< when the last step ended
  double checkpoint_at_ = 0, checkpoint_cost_ = 0, saving_ = 0;
  std::future<FileDigest> writing_;  ///< a checkpoint on its way to the disk
  std::int64_t written_step_ = -1;   ///< of the last checkpoint that was begun
  FileDigest checkpoint_digest_;
  StepReport last_;
  std::int64_t discarded_ = 0,
               lines_lost_ = 0;  ///< steps that were not finite; lines that metrics.jsonl did not take
  bool interrupted_ = false, stopped_by_watcher_ = false;
  std::int64_t steps_ = 0, samples_ = 0, rays_ = 0;  ///< of this session
  double stepping_ = 0;                              ///< seconds of this session in Trainer::step
};

}  // namespace splinevox::run
