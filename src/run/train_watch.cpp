// SPDX-License-Identifier: Apache-2.0
// What a training session does for who looks at it.
#include <fmt/format.h>

#include "core/process.hpp"
#include "run/held_camera.hpp"
#include "run/signals.hpp"
#include "run/train_session.hpp"
#include "splinevox/render/render_image.hpp"

namespace splinevox::run {

/// What was asked for on the page, in the log and in metrics.jsonl: the figures of a run say who changed it.
void TrainSession::log_wish(const char* what, const Json& more, const std::string& text) {
  Json line{{"step", last_.step}, {"seconds", last_.seconds}, {"live", what}};
  line.update(more);
  report(line);
  progress_.note(fmt::format("live page: {} at step {}", text, last_.step));
}

/// Between two steps.
void TrainSession::obey() {
  Watcher& watcher = *setup_.watcher;
  Wishes wishes = watcher.take_wishes();
  if (wishes.pause && !wishes.stop) {
    log_wish("pause", Json::object(), "pause");
    const double asked = clock();
    try_finish_checkpoint();  // one that is on its way: no cost of the run's, as it goes beside the steps
    stepped_at_ += clock() - asked;
    if (written_step_ != last_.step) start_checkpoint();  // a pause may be the end
    const double start = clock();
    for (; wishes.pause && !wishes.stop && !stop_asked(); wishes = watcher.take_wishes()) {
      add_time(wishes.more_time);
      if (watcher.wants_model(last_.step)) hand_over(trainer_.model(), 0);
      watcher.wait();
    }
    const double rested = clock() - start;  // none of the budget
    stepped_at_ += rested;
    checkpoint_at_ += rested;
    log_wish("go on", {{"paused_seconds", rested}}, fmt::format("goes on after {}", duration(rested)));
  }
  add_time(wishes.more_time);
  if (!wishes.stop) return;
  stopped_by_watcher_ = true;
  log_wish("stop", Json::object(), "stop and save");
}

void TrainSession::add_time(double seconds) {
  if (seconds <= 0) return;
  trainer_.add_time(seconds);
  const double budget = setup_.longer(seconds);
  log_wish("more time", {{"max_time", budget}},
           fmt::format("{} more, {} in all", duration(seconds), duration(budget)));
}

/// A picture of the held-out view, and the model for who watches: one copy of it serves both.
void TrainSession::look(bool held_out_view_due) {
  const bool watched = setup_.watcher && setup_.watcher->wants_model(last_.step);
  if (!held_out_view_due && !watched) return;
  const double start = clock(), started = thread_seconds();
  VoxelModel model = trainer_.model();
  if (held_out_view_due) render_held_out_view(model, start);
  if (watched) hand_over(std::move(model), held_out_view_due ? 0 : started);
}

/// @param started  when its making began, seconds of this thread; 0: it is no cost of the training
void TrainSession::hand_over(VoxelModel model, double started) {
  setup_.watcher->model(std::move(model), last_.step, started > 0 ? thread_seconds() - started : 0);
}

void TrainSession::hold_camera(const VoxelModel& model) {
  const Split& train = *setup_.data.find("train");
  if (!model.motion.moves() || !is_film(train, model.box)) return;
  const Split& held_out = no_held_out_ ? train : *setup_.data.find("val");
  const auto test = [&](Device device) {
    Renderer renderer = make_renderer(model, device);
    held_camera_ = held_camera_test(model, renderer, train, held_out);
  };
  try {
    test(setup_.device);
  } catch (const Error&) {  // others may fill the device's memory
    if (setup_.device == Device::cpu) throw;
    test(Device::cpu);
  }
  if (!held_camera_) return;
  if (const std::string text = held_camera_warning(*held_camera_); !text.empty()) progress_.note(text);
}

}  // namespace splinevox::run
