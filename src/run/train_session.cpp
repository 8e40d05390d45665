// SPDX-License-Identifier: Apache-2.0
#include "run/train_session.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string_view>
#include <system_error>
#include <utility>

#include "core/atomic_file.hpp"
#include "core/own_folder.hpp"
#include "core/process.hpp"
#include "core/stopwatch.hpp"
#include "io/checkpoint.hpp"
#include "io/manifest.hpp"
#include "run/cameras_report.hpp"
#include "run/own_json.hpp"
#include "run/signals.hpp"
#include "run/support.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/data/image_io.hpp"
#include "splinevox/io/model_vdb.hpp"
#include "splinevox/math/metrics.hpp"
#include "splinevox/render/render_image.hpp"
#include "train/effects/rig.hpp"

namespace fs = std::filesystem;

namespace splinevox::run {
namespace {

constexpr double kHeldOutShare = 0.025;    // of training time, for pictures of the held-out view
constexpr double kCheckpointShare = 0.02;  // of training time at most

/// A stable hash of a text (FNV-1a, 64 bit).
std::uint64_t fnv1a(const std::string& text) {
  std::uint64_t h = 14695981039346656037u;
  for (const char c : text) h = (h ^ std::uint8_t(c)) * 1099511628211u;
  return h;
}

/// A configuration's text without the line of a number.
std::string without(std::string text, const std::string& key) {
  const std::size_t before = text.find("\n" + key + " = ");
  return before == text.npos ? text : text.erase(before, text.find('\n', before + 1) - before);
}

/// What a checkpoint must have in common with the run that goes on from it: all but how often it is written,
/// and for how long one trains by the clock.
std::string kept_config(const Config& config) {
  const std::string text = without(write_config(config), "checkpoint_every");
  return config.run.max_time > 0 ? without(text, "max_time") : text;
}

/// Steps that the preset of a run was measured with; 0: nobody did.
int usual_steps(const Config& config) {
  for (const Preset& p : presets())
    if (config.preset == p.name) return p.usual_steps;
  return 0;
}

/// A discarded step and the rays that caused it.
Json discarded_json(const StepReport& r, const Split& train) {
  Json j{{"step", r.step}, {"discarded", true}, {"bad_rows", r.bad_rows}, {"rays", Json::array()}};
  for (const BadRay& ray : r.bad_rays)
    j["rays"].push_back({{"view", train.frames[std::size_t(ray.frame)].name},
                         {"index", ray.index},
                         {"time", ray.time},
                         {"origin", triple(ray.origin)},
                         {"direction", triple(ray.direction)},
                         {"target", triple(ray.target)}});
  return j;
}

/// metrics.jsonl without the lines after `step`: those of a run that died after its last checkpoint.
void cut_metrics(const std::string& path, std::int64_t step) {
  std::string kept;
  for (const MetricsLine& line : read_metrics_lines(path))
    if (line.json.value("step", 0.0) <= double(step)) kept += line.text + "\n";
  write_file(path, {kept});
}

}  // namespace

TrainSession::TrainSession(Setup setup, Progress& progress)
    : setup_(std::move(setup)),
      progress_(progress),
      trainer_(setup_.config, *setup_.data.find("train"), setup_.data.time_map, setup_.seconds_used,
               setup_.ranks, std::move(setup_.steps)) {
  if (setup_.resume)
    resume();
  else
    last_.seconds = trainer_.seconds();  // loading and trials
  progress_.expect(Pace(trainer_.settings()));
  const Split* split = setup_.data.find("val");
  no_held_out_ = !split || split->frames.empty();
  if (no_held_out_) split = setup_.data.find("train");
  progress_.show_training_view(no_held_out_);
  held_out_ = split->frames[split->frames.size() / 2];
}

double TrainSession::clock() const { return running_seconds(); }

/// Ranks hear signals at different steps, and must stop at the same one.
bool TrainSession::go_on() {
  if (setup_.watcher) obey();
  interrupted_ = stop_asked() || progress_.stop_asked() || stopped_by_watcher_;
  if (setup_.ranks) {
    const double mine = interrupted_;
    for (const double theirs : setup_.ranks->gather({&mine, 1})) interrupted_ |= theirs != 0;
  }
  if (!interrupted_ && !trainer_.done()) return true;
  return setup_.watcher && !setup_.watcher->close(interrupted_) && go_on();
}

Json TrainSession::run() {
  checkpoint_at_ = stepped_at_ = clock();
  if (setup_.watcher)
    setup_.watcher->begin({setup_.config, setup_.data, *held_out_, no_held_out_, setup_.folder.path()});
  while (go_on()) {
    step();
    if (!writes()) continue;
    look(held_out_view_due(last_.seconds));
    if (writing_.valid() && writing_.wait_for(std::chrono::seconds(0)) != std::future_status::timeout)
      try_finish_checkpoint();
    const bool due = clock() - checkpoint_at_ >
                     std::max(setup_.config.run.checkpoint_every, checkpoint_cost_ / kCheckpointShare);
    if (due && !writing_.valid()) start_checkpoint();
  }
  if (!writes()) return figures();
  report(progress_.unreported(held_out_psnr_));
  progress_.finish();
  const double start = clock();
  try_finish_checkpoint();
  if (written_step_ != last_.step) start_checkpoint();
  const VoxelModel model = trainer_.finish();
  const FileDigest digest = save_model(setup_.folder.file("model.vdb"), model,
                                       {{"splinevox", kVersion},
                                        {"preset", setup_.config.preset},
                                        {"dataset", folder_name(setup_.data.path)}});
  finish_checkpoint();
  saving_ = clock() - start;
  if (!interrupted_) {
    render_held_out_view(model, clock());
    hold_camera(model);
  }
  save_manifest(digest);
  if (setup_.watcher) setup_.watcher->end(model, last_.step, !interrupted_);
  return figures();
}

void TrainSession::step() {
  const double start = clock();
  try {
    last_ = trainer_.step(start - stepped_at_);
  } catch (const Error& error) {
    if (error.fault != Fault::numeric) throw;
    if (writes()) try {
        save_replay();
      } catch (const Error& unsaved) {  // which step it was and what to try matters more
        progress_.note(fmt::format("the steps that failed could not be saved: {}", unsaved.what()));
      }
    if (setup_.ranks) setup_.ranks->from_first(0);  // who leaves early ends the one that saves
    throw;
  }
  stepped_at_ = clock();
  stepping_ += stepped_at_ - start;
  ++steps_;
  rays_ += last_.rays;
  samples_ += last_.samples;
  progress_.tell(last_);
  if (!last_.discarded) return report(progress_.step(last_, held_out_psnr_));
  ++discarded_;
  const Json discarded = discarded_json(last_, *setup_.data.find("train"));
  progress_.event("discarded", discarded);
  report(discarded);
  progress_.note(fmt::format("step {} was not finite ({} rows, {} rays) and is discarded", last_.step,
                             last_.bad_rows, last_.bad_rays.size()));
}

/// The run as it was before the steps that failed, and those steps with their rays. Draws depend on (seed,
/// step) alone, so --resume meets the same rays again.
void TrainSession::save_replay() {
  const std::vector<StepReport>& bad = trainer_.discarded();
  last_ = bad.front();
  --last_.step;
  try_finish_checkpoint();
  start_checkpoint();
  const FileDigest model = save_model(setup_.folder.file("model.vdb"), trainer_.model());
  finish_checkpoint();
  Json replay{{"checkpoint", kCheckpoint},
              {"step", last_.step},
              {"seed", setup_.config.run.seed},
              {"discarded", Json::array()}};
  for (const StepReport& r : bad)
    replay["discarded"].push_back(discarded_json(r, *setup_.data.find("train")));
  const std::string path = setup_.folder.file("replay.json");
  write_file(path, {json_text(replay, 2) + "\n"});
  save_manifest(model);
  progress_.note(fmt::format("the steps and their rays are in {}; --resume meets them again", path));
}

/// A line that the disk does not take is counted and lost: the checkpoint at the end is what must not be.
void TrainSession::report(const Json& line) {
  if (line.is_null() || !writes()) return;
  const std::string text = json_text(line);
  if (!append_to_file(setup_.folder.file("metrics.jsonl"), text + "\n")) ++lines_lost_;
  if (setup_.watcher) setup_.watcher->line(text, progress_.left());
}

/// Rarely: what the pictures have cost so far, and the next one, stay a small share of the time spent.
bool TrainSession::held_out_view_due(double seconds) const {
  if (last_.stage_changed) return false;  // the step that just refined was slow already
  constexpr double kGuess = 2e-6;         // seconds a pixel
  const double expected = held_out_cost_ > 0 ? held_out_cost_ : kGuess * double(held_out_->image.pixels());
  return held_out_spent_ + expected < kHeldOutShare * (seconds - begun_at_) && last_.progress > 0.02 &&
         last_.progress < 0.98;
}

/// A device whose memory the training fills has none for a second model: then the host shows it.
Image TrainSession::picture_of(const VoxelModel& model, const Frame& view, Device device) const {
  try {
    Renderer renderer = make_renderer(model, device);
    const RenderOptions options{.across = 0};
    // Of a camera that no picture trains nothing tells the exposure and the clock.
    if (no_held_out_) return shown_by(trainer_.cameras(), view, model, renderer, options);
    return clamped(renderer.render(view.camera, view.time, options).rgb);
  } catch (const Error&) {
    if (device == Device::cpu) throw;
    return picture_of(model, view, Device::cpu);
  }
}

void TrainSession::render_held_out_view(const VoxelModel& model, double start) {
  if (held_out_step_ == double(last_.step)) return;
  const Image picture = picture_of(model, *held_out_, setup_.device);
  held_out_psnr_ =
      capped_psnr(psnr(picture, composite(held_out_->image, model.background.color), held_out_->ignored));
  held_out_step_ = double(last_.step);
  const std::string folder = setup_.folder.file("preview");
  if (make_inner_folder(folder)) try {
      const std::vector<char> png = encode_png(picture);
      FileWriter file(fmt::format("{}/step_{:06}.png", folder, last_.step), png.size());
      file.add({png.data(), png.size()});
      file.commit("", Wait::no);  // these are only to look at
    } catch (const Error&) {      // and can be done without
    }
  held_out_cost_ = clock() - start;
  held_out_spent_ += held_out_cost_;
  report({{"step", last_.step},
          {"seconds", last_.seconds},
          {"held_psnr", held_out_psnr_},
          {"held_view", held_out_->name},
          {"split", held_out_split()}});
}

void TrainSession::resume() {
  const std::string path = setup_.folder.file(kCheckpoint);
  const Checkpoint saved = read_checkpoint(path);
  const CheckpointHeader expected = header();
  if (saved.header.kind == expected.kind && saved.header.format != expected.format)
    fail({path, "was written by another version of splinevox",
          fmt::format("training state {}", expected.format), fmt::format("{}", saved.header.format),
          "resume with the version that wrote it, or another folder for --out"});
  if (saved.header.kind != expected.kind || saved.header.config != expected.config ||
      saved.header.dataset != expected.dataset)
    fail({path, "this checkpoint belongs to another run", "the checkpoint that config.toml was written with",
          "", "another folder for --out"});
  if (!saved.note.empty()) progress_.note("note: " + saved.note);
  trainer_.restore(saved.bytes);
  last_.step = std::int64_t(saved.header.step);
  begun_at_ = last_.seconds = trainer_.seconds();
  rays_before_ = trainer_.phases().rays;
  if (!writes()) return;
  std::error_code ignored;
  fs::remove(setup_.folder.file(kManifestName), ignored);  // it lists files as they will soon not be
  cut_metrics(setup_.folder.file("metrics.jsonl"), last_.step);
}

CheckpointHeader TrainSession::header() const {
  CheckpointHeader h;
  h.kind = "trainer";
  h.format = Trainer::kStateFormat;
  h.config = fnv1a(kept_config(setup_.config));
  h.dataset = setup_.data.fingerprint;
  h.step = std::uint64_t(last_.step);
  return h;
}

/// Hands the state to the system here, without a copy, and waits for the disk on a thread of its own. What
/// goes wrong comes out of finish_checkpoint: by then whoever is about to save more has tried to.
void TrainSession::start_checkpoint() {
  const double start = clock();
  std::function<FileDigest()> commit;
  try {
    trainer_.save([&](std::span<const std::string_view> pieces) {
      commit = [file = std::make_shared<PendingCheckpoint>(setup_.folder.file(kCheckpoint), header(),
                                                           pieces)] { return file->commit(); };
    });
  } catch (const Error&) {
    commit = [wrong = std::current_exception()]() -> FileDigest { std::rethrow_exception(wrong); };
  }
  try {
    writing_ = std::async(std::launch::async, commit);
  } catch (const std::system_error&) {  // no more threads to be had
    writing_ = std::async(std::launch::deferred, commit);
  }
  written_step_ = last_.step;
  checkpoint_at_ = clock();
  checkpoint_cost_ = checkpoint_at_ - start;
}

/// Throws what the writing threw.
void TrainSession::finish_checkpoint() {
  if (writing_.valid()) checkpoint_digest_ = writing_.get();
}

/// One on the way, which is no reason to stop if it fails: there may be room for the next one, and the one at
/// the end says what is wrong.
void TrainSession::try_finish_checkpoint() {
  try {
    finish_checkpoint();
  } catch (const Error& error) {
    written_step_ = -1;
    progress_.note(fmt::format("a checkpoint could not be saved, and training goes on: {}", error.what()));
  }
}

/// What `verify` checks. Written last: it says that everything else is there.
void TrainSession::save_manifest(const FileDigest& model) {
  const auto& folder = setup_.folder;
  Manifest manifest;
  manifest.kind = "run";
  manifest.info["splinevox"] = kVersion;
  manifest.info["preset"] = setup_.config.preset;
  manifest.info["steps"] = std::to_string(last_.step);
  if (const int usual = usual_steps(setup_.config)) manifest.info["preset_steps"] = std::to_string(usual);
  manifest.files = {manifest_entry(folder.path(), "config.toml"),
                    manifest_entry(folder.path(), "metrics.jsonl"),
                    {"model.vdb", model, {}},
                    {kCheckpoint, checkpoint_digest_, {{"step", double(last_.step)}}}};
  for (const char* name : {kAskedConfig, kEffects, kTrainingPictures})
    if (folder.has(name)) manifest.files.push_back(manifest_entry(folder.path(), name));
  write_manifest(folder.path(), manifest);
}

Json TrainSession::figures() const {
  const PhaseSeconds p = trainer_.phases();
  const double in_ray_loop = p.rays - rays_before_, all = std::max(stepping_, 1e-9);
  Json j{{"steps", last_.step}, {"train_seconds", last_.seconds}, {"finished", !interrupted_}};
  const int most = setup_.config.run.max_steps;
  j["ended"] = stopped_by_watcher_              ? "page"
               : interrupted_                   ? "signal"
               : most > 0 && last_.step >= most ? "steps"
                                                : "time";
  j["preset"] = setup_.config.preset;
  if (const int usual = usual_steps(setup_.config)) {
    j["preset_steps"] = usual;
    j["preset_share"] = double(last_.step) / usual;
  }
  j["seed"] = setup_.config.run.seed;
  j["loss"] = last_.loss;
  if (discarded_ > 0) j["discarded_steps"] = discarded_;
  if (lines_lost_ > 0) j["metrics_lines_lost"] = lines_lost_;
  if (std::isfinite(held_out_psnr_))
    j["held"] = {{"view", held_out_->name},
                 {"split", held_out_split()},
                 {"psnr", held_out_psnr_},
                 {"of_training_split", no_held_out_}};
  if (held_camera_) j[kHeldCamera] = held_camera_json(*held_camera_);
  j["phases"] = {{"slices", p.slices},         {"rays", p.rays},     {"scatter", p.scatter},
                 {"regularise", p.regularise}, {"update", p.update}, {"occupancy", p.occupancy},
                 {"refine", p.refine}};
  if (setup_.ranks) {
    const Ranks::Traffic& t = setup_.ranks->traffic;
    const double steps = std::max(1.0, double(steps_));
    j["ranks"] = {{"count", setup_.ranks->count()},
                  {"bytes_per_step", double(t.bytes) / steps},
                  {"seconds_per_step", t.seconds / steps}};
  }
  if (Json cameras = cameras_json(setup_.data, setup_.config.cameras, trainer_.cameras()); !cameras.empty())
    j["cameras"] = std::move(cameras);
  if (trainer_.moving_share() < 1) j["moving_share"] = trainer_.moving_share();
  j["outside_ray_loop"] = std::max(0.0, 1 - in_ray_loop / all);
  j["rays_per_second"] = double(rays_) / all;
  j["samples_per_second"] = double(samples_) / all;
  j["load_seconds"] = setup_.seconds_used;
  j["held_view_seconds"] = held_out_spent_;
  j["save_seconds"] = saving_;
  j["peak_memory_bytes"] = peak_memory();
  return j;
}

}  // namespace splinevox::run
