// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "live/packer.hpp"
#include "live/server.hpp"
#include "run/watcher.hpp"
#include "splinevox/run/train.hpp"

namespace splinevox::run {

/// The page of `train --live`: how far a training is, its present model, and buttons to act on it. What is
/// asked of it and what it answers is in docs/formats.md, "The live page".
class LivePage : public Watcher {
 public:
  /// Serves from here on. @param port  0: a free one. @param name  of the run. Throws Error (input)
  LivePage(int port, std::string name);
  /// Waits a moment for a page that is open to fetch what is new.
  ~LivePage() override;

  const std::string& address() const { return server_.address(); }
  /// Hears what is said before the first step and besides.
  void note(const std::string& text);

  bool stop_wished() const override;
  void begin(const Watched& training) override;
  void line(const std::string& line, std::optional<double> left) override;
  bool wants_model(std::int64_t step) const override;
  void model(VoxelModel model, std::int64_t step, double cost) override;
  Wishes take_wishes() override;
  void wait() override;
  bool close(bool anyway) override;
  void end(const VoxelModel& model, std::int64_t step, bool finished) override;

 private:
  enum class Phase { preparing, training, saving, saved, finished };

  Answer answer(const Ask& ask);
  Answer state(const Ask& ask);
  Answer wish(const Ask& ask);
  Answer preview(const std::string& file) const;
  bool ended() const { return phase_ >= Phase::saved; }
  /// Whether a page has asked for the model of late.
  bool followed() const;
  void lay_beside(const VoxelModel& model);

  mutable std::mutex mutex_;
  std::condition_variable wished_, told_;
  Phase phase_ = Phase::preparing;
  Wishes wishes_;
  std::vector<std::string> notes_, lines_;  ///< lines: JSON
  std::optional<double> left_;
  std::optional<Watched> training_;  ///< until it has ended
  std::string folder_;
  Json about_ = Json::object();  ///< what does not change from the first step on
  bool by_clock_ = false;
  double max_time_ = 0;
  double seen_at_ = -1e9, asked_at_ = -1e9;  ///< when a page asked last, and for the model: running_seconds
  double handed_at_ = -1e9;                  ///< likewise, when the last model was handed over
  std::int64_t handed_ = -1, fetched_ = -1;  ///< steps of models: handed over, and fetched by a page
  bool told_end_ = false;                    ///< a page has heard that the training has ended
  double copies_ = 0, begun_at_ = 0;         ///< processor seconds: of copies; when training began
  std::optional<ViewPage> beside_;           ///< what the viewer shows beside the model
  std::shared_ptr<const std::string> page_, truth_;  ///< HTML; the held-out view, PNG
  ModelPacker packer_;
  PageServer server_;  ///< the last: it asks all of the above
};

}  // namespace splinevox::run
