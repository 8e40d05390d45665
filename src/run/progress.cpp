// SPDX-License-Identifier: Apache-2.0
#include "run/progress.hpp"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/printable.hpp"
#include "core/system.hpp"
#include "run/events.hpp"
#include "run/standard_output.hpp"
#include "splinevox/math/metrics.hpp"

namespace splinevox::run {
namespace {

constexpr double kReportEvery = 0.5;  // seconds of training between two lines of metrics.jsonl
constexpr double kLineEvery = 5;      // between two plain lines

std::string bar(double share, int width) {
  static const char* const eighths[] = {"", "▏", "▎", "▍", "▌", "▋", "▊", "▉"};
  const int filled = int(std::lround(std::min(std::max(share, 0.0), 1.0) * width * 8));
  std::string text;
  for (int i = 0; i < filled / 8; ++i) text += "█";
  text += eighths[filled % 8];
  for (int i = (filled + 7) / 8; i < width; ++i) text += " ";
  return text;
}

/// Says it, or not: a terminal that is gone or a full log disk is no reason to stop training. What was left
/// in the buffer of a stream that failed is dropped too, or it would fail for ever.
void try_say(const std::string& text) {
  std::fwrite(text.data(), 1, text.size(), stderr);
  if (std::fflush(stderr) == 0) return;
  drop_unwritten(stderr);
  std::clearerr(stderr);
}

}  // namespace

Talk choose_talk(bool quiet, bool json) {
  return json ? Talk::json : quiet ? Talk::quiet : ::isatty(STDERR_FILENO) ? Talk::bar : Talk::lines;
}

int columns(int descriptor) {
  constexpr int kUsual = 80;
  winsize size{};
  return ::ioctl(descriptor, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : kUsual;
}

std::string bar_line(const LineParts& parts, int width) {
  constexpr int kLongest = 24, kShortest = 5, kPercent = 5;  // of the bar; "100% "
  std::string text;
  for (int left_out = 0; left_out <= 4; ++left_out) {
    text = parts.step;
    const auto add = [&](const std::string& part, bool shown) {
      if (shown && !part.empty()) text += "  " + part;
    };
    add(parts.loss, left_out < 1);
    add(parts.held_out + (left_out < 3 ? ", " + parts.rays : ""), left_out < 4);
    add(parts.rate, left_out < 2);
    add(parts.left, true);
    const int room = width - 1 - kPercent - int(text.size()) - 1;
    if (room >= kShortest)
      return fmt::format("{:3.0f}% {} {}", 100 * parts.progress,
                         bar(parts.progress, std::min(room, kLongest)), text);
  }
  return fmt::format("{:3.0f}% {}", 100 * parts.progress, text)
      .substr(0, std::size_t(std::max(width - 1, 4)));
}

void Progress::note(const std::string& text) {
  if (events_.note) events_.note(text);
  event("note", {{"note", text}});
  if (talk_ == Talk::quiet || talk_ == Talk::json) return;
  finish();
  try_say(all_printable(text) + "\n");
}

void Progress::event(const char* name, const Json& fields) {
  if (talk_ == Talk::json) print_now(event_line(name, fields) + "\n");
}

void Progress::tell(const StepReport& report) {
  if (events_.step && !events_.step(report)) stop_ = true;
}

Json Progress::step(const StepReport& r, double held_out_psnr) {
  if (since_ < 0) {  // the time before the first step is not its own
    since_ = r.seconds;
    pace_.add(r);
  }
  last_ = r;
  ++steps_;
  rays_ += r.rays;
  samples_ += r.samples;
  loss_ += r.loss;
  squared_error_ += double(r.rays) * std::pow(10, -r.psnr / 10);
  return r.seconds - since_ < kReportEvery && r.progress < 1 ? Json() : report(held_out_psnr);
}

Json Progress::unreported(double held_out_psnr) { return steps_ > 0 ? report(held_out_psnr) : Json(); }

Json Progress::report(double held_out_psnr) {
  const double loss = loss_ / double(steps_), took = last_.seconds - since_;
  Json j{{"step", last_.step}, {"seconds", last_.seconds}, {"progress", last_.progress}, {"loss", loss}};
  j["psnr"] = capped_psnr(-10 * std::log10(squared_error_ / double(rays_)));
  if (std::isfinite(held_out_psnr)) j["held_psnr"] = held_out_psnr;
  j.update({{"rays", rays_},
            {"samples", samples_},
            {"rays_per_second", took > 1e-6 ? double(rays_) / took : 0.0}});
  steps_ = rays_ = samples_ = 0;
  loss_ = squared_error_ = 0;
  since_ = last_.seconds;
  pace_.add(last_);
  draw(j);
  return j;
}

void Progress::draw(const Json& j) {
  event("progress", j);
  if (talk_ == Talk::json || talk_ == Talk::quiet) return;
  const double progress = last_.progress;
  if (talk_ == Talk::lines && last_.seconds - spoken_ < kLineEvery && progress < 1) return;
  spoken_ = last_.seconds;
  const std::string held_out =
      j.contains("held_psnr") ? fmt::format("{:.1f}", j["held_psnr"].get<double>()) : "-";
  const std::optional<double> rest = left();
  const std::string left = rest ? duration(*rest) + " left" : "";
  const LineParts parts{progress,
                        fmt::format("step {:>6}", last_.step),
                        fmt::format("loss {:.2e}", j["loss"].get<double>()),
                        fmt::format("PSNR {} {}", held_out, of_training_ ? "train view" : "held-out"),
                        fmt::format("{:.1f} rays", j["psnr"].get<double>()),
                        fmt::format("{:.0f} krays/s", j["rays_per_second"].get<double>() / 1e3),
                        left};
  if (talk_ == Talk::bar) {
    try_say("\r\033[K" + bar_line(parts, columns(STDERR_FILENO)));
    drawn_ = true;
  } else {
    try_say(fmt::format("{:3.0f}%  {}  {}  {}, {}  {}{}{}\n", 100 * progress, parts.step, parts.loss,
                        parts.held_out, parts.rays, parts.rate, left.empty() ? "" : "  ", left));
  }
}

void Progress::finish() {
  if (drawn_) try_say("\n");
  drawn_ = false;
}

}  // namespace splinevox::run
