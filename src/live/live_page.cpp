// SPDX-License-Identifier: Apache-2.0
#include "live/live_page.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <utility>

#include "core/number_text.hpp"
#include "core/process.hpp"
#include "core/stopwatch.hpp"
#include "live/html.hpp"
#include "run/own_json.hpp"
#include "run/run_folder.hpp"
#include "run/training_cameras.hpp"
#include "train/paced.hpp"

namespace splinevox::run {
namespace {

constexpr double kModelShare = 0.006;       // of the processor time of a training, for models on the page
constexpr double kModelCredit = 0.15;       // seconds of it that the first models may take before that
constexpr double kModelEvery = 2;           // seconds between two of them at least
constexpr double kOpen = 8;                 // seconds after which a page that has not asked is not there
constexpr double kFarewell = 5;             // seconds that an open page has to fetch the last model
constexpr int kShots = 6, kShotSize = 240;  // true pictures on the page; longest side, pixels
constexpr double kMostAdded = 7 * 86400;    // seconds

Answer text(int status, const std::string& what, const char* type = "text/plain; charset=utf-8") {
  return {status, type, std::make_shared<const std::string>(what)};
}

std::shared_ptr<const std::string> shared(const std::vector<char>& bytes) {
  return std::make_shared<const std::string>(bytes.begin(), bytes.end());
}

/// A whole number from 0 on; 0 where it is none.
std::size_t count_of(const std::string& word) {
  std::size_t n = 0;
  std::from_chars(word.data(), word.data() + word.size(), n);
  return n;
}

std::vector<std::string> from(const std::vector<std::string>& all, std::size_t first) {
  return {all.begin() + std::ptrdiff_t(std::min(first, all.size())), all.end()};
}

}  // namespace

LivePage::LivePage(int port, std::string name)
    : page_(std::make_shared<const std::string>(live_html(name))),
      server_(port, [this](const Ask& ask) { return answer(ask); }) {}

LivePage::~LivePage() {
  std::unique_lock lock(mutex_);
  if (!ended() || running_seconds() - seen_at_ > kOpen) return;
  told_.wait_for(lock, std::chrono::duration<double>(kFarewell),
                 [&] { return told_end_ && (!followed() || fetched_ >= handed_); });
}

void LivePage::note(const std::string& what) {
  const std::lock_guard lock(mutex_);
  notes_.push_back(what);
}

void LivePage::begin(const Watched& training) {
  const Config& config = training.config;
  const Json effects = read_effects_if_there(training.folder + "/" + kEffects);
  const std::vector<float>& c = config.run.background;
  const TrueShot truth = true_shot(training.held_out, Vec3{c[0], c[1], c[2]}, 2 * kShotSize);
  std::vector<std::string> lines;
  for (const MetricsLine& line : read_metrics_lines(training.folder + "/metrics.jsonl"))
    lines.push_back(json_text(line.json));
  const std::lock_guard lock(mutex_);
  training_.emplace(training);
  phase_ = Phase::training;
  folder_ = training.folder;
  lines_ = std::move(lines);
  truth_ = shared(truth.png);
  by_clock_ = by_clock(config.run);
  max_time_ = config.run.max_time;
  begun_at_ = processor_seconds();
  about_ = {{"folder", training.folder},           {"preset", config.preset},
            {"dataset", training.data.path},       {"view", training.held_out.name},
            {"of_training", training.of_training}, {"by_clock", by_clock_},
            {"max_steps", config.run.max_steps},   {"effects", effects}};
}

void LivePage::line(const std::string& what, std::optional<double> left) {
  const std::lock_guard lock(mutex_);
  lines_.push_back(what);
  left_ = left;
  if (training_) max_time_ = training_->config.run.max_time;
}

bool LivePage::followed() const { return running_seconds() - asked_at_ < kOpen; }

bool LivePage::wants_model(std::int64_t step) const {
  const std::lock_guard lock(mutex_);
  if (step == handed_ || !followed() || !packer_.idle()) return false;
  if (wishes_.pause) return true;
  const double allowed = kModelCredit + kModelShare * (processor_seconds() - begun_at_);
  return running_seconds() - handed_at_ > kModelEvery && copies_ + packer_.spent() + packer_.last() < allowed;
}

/// Once, when the first model is asked for: only then are the pictures needed.
void LivePage::lay_beside(const VoxelModel& model) {
  if (beside_) return;
  const Dataset& data = training_->data;
  const Split* split = data.find("val");
  if (!split || split->frames.empty()) split = data.find("train");
  beside_.emplace();
  beside_->name = folder_name(about_["folder"].get<std::string>());
  beside_->note = "The model as it was at the step that the page names; it is still being trained.";
  beside_->split = split->name;
  beside_->shots = page_shots(*split, model, kShots, kShotSize);
  const TrainingCameras train = survey(data, model.box, CameraRequest().elevation);
  beside_->taken = taken_from(train);
  beside_->start = plain_sight(beside_->shots, &train);
}

void LivePage::model(VoxelModel model, std::int64_t step, double cost) {
  const double start = thread_seconds();
  lay_beside(model);
  packer_.take(std::move(model), *beside_, step);
  const std::lock_guard lock(mutex_);
  copies_ += cost + thread_seconds() - start;
  handed_ = step;
  handed_at_ = running_seconds();
}

bool LivePage::stop_wished() const {
  const std::lock_guard lock(mutex_);
  return wishes_.stop;
}

Wishes LivePage::take_wishes() {
  const std::lock_guard lock(mutex_);
  return {wishes_.stop, wishes_.pause, std::exchange(wishes_.more_time, 0)};
}

void LivePage::wait() {
  std::unique_lock lock(mutex_);
  wished_.wait_for(lock, std::chrono::milliseconds(100));
}

bool LivePage::close(bool anyway) {
  const std::lock_guard lock(mutex_);
  if (!anyway && wishes_.more_time > 0) return false;
  phase_ = Phase::saving;
  wishes_.pause = false;
  return true;
}

void LivePage::end(const VoxelModel& model, std::int64_t step, bool finished) {
  std::unique_lock lock(mutex_);
  if (followed() && step != handed_) {
    while (!packer_.idle()) wished_.wait_for(lock, std::chrono::milliseconds(10));
    lock.unlock();
    this->model(model, step, 0);
    lock.lock();
  }
  training_.reset();
  phase_ = finished ? Phase::finished : Phase::saved;
}

Answer LivePage::answer(const Ask& ask) {
  if (ask.post) return wish(ask);
  if (ask.path.empty()) return {200, "text/html; charset=utf-8", page_};
  if (ask.path == "state") return state(ask);
  if (ask.path == "truth.png") {
    const std::lock_guard lock(mutex_);
    return truth_ ? Answer{200, "image/png", truth_} : text(404, "there is no such picture yet");
  }
  if (ask.path == "model") {
    const LiveModel model = packer_.latest();
    if (!model.bytes) return text(404, "there is no model yet");
    const std::lock_guard lock(mutex_);
    fetched_ = model.step;
    told_.notify_all();
    return {200, "application/octet-stream", model.bytes};
  }
  if (ask.path.starts_with("preview/")) return preview(ask.path.substr(8));
  return text(404, "there is nothing of that name");
}

/// A picture of the run's folder that training made, and nothing else of it.
Answer LivePage::preview(const std::string& file) const {
  const std::string start = "step_", end = ".png";
  const bool named = file.starts_with(start) && file.ends_with(end) && file.size() < 32 &&
                     file.find_first_not_of("0123456789", start.size()) == file.size() - end.size();
  if (!named) return text(404, "there is no such preview");
  std::string path;
  {
    const std::lock_guard lock(mutex_);
    path = folder_ + "/preview/" + file;
  }
  const std::string bytes = read_text_if_there(path);
  return bytes.empty() ? text(404, "there is no such preview") : text(200, bytes, "image/png");
}

/// How far it is. `lines`, `notes`: how many of them the page has already. `follow`: 1 asks for the model.
Answer LivePage::state(const Ask& ask) {
  constexpr const char* kPhases[] = {"preparing", "training", "saving", "saved", "finished"};
  const std::size_t lines = count_of(ask.value("lines")), notes = count_of(ask.value("notes"));
  const LiveModel model = packer_.latest();
  const std::lock_guard lock(mutex_);
  seen_at_ = running_seconds();
  if (ask.value("follow") == "1") asked_at_ = seen_at_;
  Json j{{"phase", kPhases[int(phase_)]},
         {"paused", wishes_.pause},
         {"stopping", wishes_.stop},
         {"model", model.step},
         {"left", left_ ? Json(*left_) : Json()},
         {"max_time", max_time_},
         {"notes", from(notes_, notes)}};
  if (notes == 0 || lines == 0) j["about"] = about_;
  if (ended() && (!followed() || model.step >= handed_)) {
    told_end_ = true;
    told_.notify_all();
  }
  std::string out = json_text(j);
  out.back() = ',';
  return text(200, fmt::format("{}\"lines\":[{}]}}", out, fmt::join(from(lines_, lines), ",")),
              "application/json");
}

Answer LivePage::wish(const Ask& ask) {
  const std::lock_guard lock(mutex_);
  if (ended()) return text(409, "the training has ended");
  if (phase_ == Phase::saving) return text(409, "the last step is made, and the model is being saved");
  if (ask.path == "pause" || ask.path == "go") {
    wishes_.pause = ask.path == "pause";
  } else if (ask.path == "stop") {
    wishes_.stop = true;
  } else if (ask.path == "more") {
    const double seconds = parse_number<double>(ask.value("seconds")).value_or(0);
    if (!(seconds >= 1 && seconds <= kMostAdded))
      return text(400, fmt::format("seconds: a number from 1 to {:.0f}", kMostAdded));
    if (phase_ == Phase::preparing) return text(409, "training has not begun");
    if (!by_clock_) return text(409, "this run counts steps, so time is not what ends it");
    wishes_.more_time += seconds;
  } else {
    return text(404, "there is nothing of that name");
  }
  wished_.notify_all();
  return text(200, "yes");
}

}  // namespace splinevox::run
