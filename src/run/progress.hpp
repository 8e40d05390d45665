// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "run/pace.hpp"
#include "run/support.hpp"
#include "splinevox/run/train.hpp"

namespace splinevox::run {

enum class Talk {
  bar,    ///< one line that is drawn over itself: stderr is a terminal
  lines,  ///< a plain line every few seconds
  json,   ///< one JSON object a line on stdout, begin_events was called
  quiet   ///< nothing but errors
};
Talk choose_talk(bool quiet, bool json);
/// Of the terminal behind a descriptor, as wide as it is now; 80 where there is none.
int columns(int descriptor);

/// The parts of the line that is drawn over itself.
struct LineParts {
  double progress = 0;  ///< 0..1
  std::string step, loss, held_out, rays, rate, left;
};
/// That line, of at most `width` columns: the bar is as long as there is room for, and where there is none
/// for all parts, loss, rate and the rays' PSNR are left out, in this order.
std::string bar_line(const LineParts& parts, int width);

/// What training says while it runs. Averages the steps between two lines.
class Progress {
 public:
  /// @param events  hear notes and steps besides
  explicit Progress(Talk talk, TrainEvents events = {}) : talk_(talk), events_(std::move(events)) {}
  ~Progress() { finish(); }

  /// A line of its own, above the bar; also an event.
  void note(const std::string& text);
  /// A line for programs alone, if they listen (events.hpp).
  void event(const char* name, const Json& fields);
  /// One step was done. Returns the averaged report when one is due (every half second; JSON and plain lines
  /// less often), else null: what metrics.jsonl gets.
  Json step(const StepReport& report, double held_out_psnr);
  /// The report that is not due yet, if any step was made since the last one.
  Json unreported(double held_out_psnr);
  /// Ends the line that the bar is drawn on.
  void finish();
  Talk talk() const { return talk_; }
  /// Whether the view that is shown is one of the training split, for there is no other.
  void show_training_view(bool of_training) { of_training_ = of_training; }
  /// How the rest of the run is to be foretold; not called: its steps cost alike.
  void expect(Pace pace) { pace_ = std::move(pace); }
  /// Seconds that the rest of the run takes; none: too little of it is done to tell.
  std::optional<double> left() const { return pace_.left(); }
  /// Tells those who hear of a step, discarded or not.
  void tell(const StepReport& report);
  /// Whether one of them asked to stop.
  bool stop_asked() const { return stop_; }

 private:
  Json report(double held_out_psnr);
  void draw(const Json& report);

  Talk talk_;
  TrainEvents events_;
  bool drawn_ = false, stop_ = false, of_training_ = false;
  Pace pace_;
  StepReport last_;
  std::int64_t steps_ = 0, rays_ = 0, samples_ = 0;  ///< since the last report
  double loss_ = 0, squared_error_ = 0;              ///< likewise; the latter per channel, of all rays
  double since_ = -1, spoken_ = -1e9;
};

}  // namespace splinevox::run
