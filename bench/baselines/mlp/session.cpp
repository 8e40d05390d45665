// SPDX-License-Identifier: Apache-2.0
#include "session.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <numbers>
#include <sstream>

#include "core/atomic_file.hpp"
#include "core/process.hpp"
#include "run/signals.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/core/image.hpp"
#include "splinevox/data/image_io.hpp"
#include "splinevox/math/metrics.hpp"
#include "splinevox/train/prepare.hpp"
#include "train/start.hpp"

namespace fs = std::filesystem;

namespace splinevox::mlp {
namespace {

constexpr double kHeldOutShare = 0.1;  ///< of training time at most, for the held-out view
constexpr const char* kModel = "model.pt";

double clock(bool cpu_time) {
  if (!cpu_time)
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  return processor_seconds() / torch::get_num_threads();
}

Vec3 background(const Settings& s) {
  return {float(s.background[0]), float(s.background[1]), float(s.background[2])};
}

double psnr_of(const torch::Tensor& render, const torch::Tensor& truth) {
  return psnr_from_mse(
      torch::mean(torch::square(render.clamp(0, 1) - truth).to(torch::kDouble)).item<double>());
}

/// Rays' colours as the picture they were taken for, within [0, 1].
Image as_image(const torch::Tensor& rgb, const Camera& camera, int stride) {
  Image picture(strided(camera.width, stride), strided(camera.height, stride), 3);
  std::copy_n(rgb.contiguous().data_ptr<float>(), picture.data.size(), picture.data.begin());
  return clamped(std::move(picture));
}

/// The box the voxel model starts from, so that both march through the same space. Pictures stay as they are.
Box scene_box(Dataset& data) {
  Config asked;
  asked.run.find_ground = false;
  const Config voxel = prepare(asked, data, {.effects = EffectPolicy::keep}).config;
  const Split& train = *data.find("train");
  return starting_bounds(voxel, train, picture_stats(train)).box;
}

const Frame& held_out_frame(const Dataset& data) {
  const Split* split = data.find("val");
  if (!split || split->frames.empty()) split = data.find("train");
  return split->frames[split->frames.size() / 2];
}

}  // namespace

torch::Device torch_device(const std::string& name) {
  const bool there = torch::cuda::is_available();
  if (name == "cpu" || (name == "auto" && !there)) return torch::kCPU;
  if (name != "cuda" && name != "auto")
    fail({.where = "--device",
          .what = "there is no such device",
          .expected = "auto, cpu or cuda",
          .got = name,
          .hint = {}});
  if (!there)
    fail({.where = "--device",
          .what = "there is no CUDA here",
          .expected = "a LibTorch built with CUDA, and a GPU",
          .got = name,
          .hint = "--device cpu"});
  return torch::kCUDA;
}

MlpRun open_run(const std::string& path, const std::string& device) {
  MlpRun run;
  run.path = path;
  const std::string model = path + "/" + kModel, config = path + "/config.toml";
  if (!fs::is_regular_file(model))
    fail({.where = path,
          .what = fmt::format("there is no {} in it", kModel),
          .expected = "the folder that `splinevox-mlp train --out` made",
          .got = {},
          .hint = {}});
  run.settings = read_settings(config);
  const toml::table table = toml::parse_file(config);
  const auto text = [&](const char* key) { return table["record"][key].value_or(std::string()); };
  const auto number = [&](const toml::node_view<const toml::node>& node) {
    const auto value = node.value<double>();
    if (!value)
      fail({.where = config,
            .what = "[record] is incomplete",
            .expected = "the file that the run wrote, unchanged",
            .got = {},
            .hint = {}});
    return *value;
  };
  run.record = {text("splinevox"),
                text("compiler"),
                text("dataset"),
                std::strtoull(text("fingerprint").c_str(), nullptr, 16),
                {number(table["record"]["time_origin"]), number(table["record"]["time_scale"])},
                {},
                {}};
  for (int a = 0; a < 3; ++a) {
    run.box.lo[a] = float(number(table["record"]["box"][std::size_t(a)]));
    run.box.hi[a] = float(number(table["record"]["box"][std::size_t(a) + 3]));
  }
  const torch::Device there = torch_device(device);
  run.model = MlpModel(run.settings);
  try {
    torch::load(run.model, model, there);
    run.model->to(there);
  } catch (const c10::Error& error) {
    fail({.where = model,
          .what = "cannot be read",
          .expected = "the file that the run wrote",
          .got = error.what_without_backtrace(),
          .hint = {}});
  }
  return run;
}

Measured measure(MlpModel& model, const Settings& settings, const Box& box, const Split& split, int stride) {
  Measured out;
  for (const Frame& f : split.frames) {
    const torch::Tensor rgb = model->picture(view_rays(f.camera, f.time, box, stride));
    const double db = psnr_of(rgb, view_colors(f.image, background(settings), stride));
    out.frames.push_back({{"name", f.name}, {"time", f.time}, {"psnr", capped_psnr(db)}});
    const double share = 1 / double(split.frames.size());
    out.psnr += share * capped_psnr(db);
    if (stride > 1) continue;
    const Image picture = as_image(rgb, f.camera, 1), truth = composite(f.image, background(settings));
    out.ssim += share * ssim(picture, truth);
    out.ms_ssim += share * ms_ssim(picture, truth);
  }
  return out;
}

Image view_picture(MlpModel& model, const Frame& frame, const Box& box, int stride) {
  return as_image(model->picture(view_rays(frame.camera, frame.time, box, stride)), frame.camera, stride);
}

MlpSession::MlpSession(const Settings& settings, Dataset& data, const run::RunFolder& folder,
                       run::Progress& progress)
    : settings_(settings),
      data_(data),
      folder_(folder),
      progress_(progress),
      box_(scene_box(data)),
      sampler_(*data.find("train"), box_, settings),
      model_((torch::manual_seed(settings.seed), settings)),
      optimiser_(model_->parameters(), torch::optim::AdamOptions(settings.lr)),
      held_out_psnr_(std::numeric_limits<double>::quiet_NaN()) {
  model_->to(torch_device(settings.device));  // parameters keep their identity, so the optimiser goes along
}

Json MlpSession::run() {
  const run::RunRecord record{run::kVersion,
                              SPLINEVOX_COMPILER,
                              fs::absolute(data_.path).lexically_normal().string(),
                              data_.fingerprint,
                              data_.time_map,
                              {},
                              {}};
  write_file(folder_.file("config.toml"),
             {settings_text(settings_) + run::record_text(record) +
              fmt::format("box = [{}, {}, {}, {}, {}, {}]\n", box_.lo.x, box_.lo.y, box_.lo.z, box_.hi.x,
                          box_.hi.y, box_.hi.z)});
  write_file(folder_.file("metrics.jsonl"), {std::string()});
  double spent = 0;  // on the held-out view
  const auto now = [&] { return clock(settings_.cpu_time); };
  const auto used = [&] {
    double p = 0;
    if (settings_.max_time > 0) p = std::max(p, seconds_ / settings_.max_time);
    if (settings_.max_steps > 0) p = std::max(p, double(step_) / settings_.max_steps);
    return p;
  };
  const std::int64_t rays = std::int64_t(settings_.crops) * settings_.crop * settings_.crop;
  while (used() < 1 && !run::stop_asked()) {
    const double start = now();
    StepReport report;
    report.progress = used();
    report.loss = step(report.progress);
    seconds_ += now() - start;
    report.step = ++step_;
    report.seconds = seconds_;
    report.rays = rays;
    report.samples = rays * settings_.samples;
    report.psnr = -10 * std::log10(std::max(1e-10, loss_));
    report.progress = std::min(1.0, used());
    const Json line = progress_.step(report, held_out_psnr_);
    if (!line.is_null()) report_line(line);
    if (spent + held_out_seconds_ <= kHeldOutShare * seconds_) {
      const double before = now();
      show_held_out();
      held_out_seconds_ = now() - before;
      spent += held_out_seconds_;
    }
    measure_due(false);
  }
  progress_.finish();
  save();
  const bool interrupted = run::stop_asked();
  if (!interrupted) measure_due(true);
  return {{"kind", name(settings_.kind)},
          {"finished", !interrupted},
          {"steps", step_},
          {"train_seconds", seconds_},
          {"cpu_time", settings_.cpu_time},
          {"rays_per_second", double(rays) * double(step_) / seconds_},
          {"peak_memory_bytes", peak_memory()},
          {"threads", torch::get_num_threads()},
          {"device", model_->device().str()},
          {"parameters",
           [&] {
             std::int64_t count = 0;
             for (const torch::Tensor& p : model_->parameters()) count += p.numel();
             return count;
           }()},
          {"test_stride", settings_.test_stride},
          {"tests", tests_}};
}

double MlpSession::step(double progress) {
  std::size_t stage = 0;
  while (stage + 1 < settings_.shrink.size() && progress >= settings_.shrink_start[stage + 1]) ++stage;
  sampler_.set_shrink(settings_.shrink[stage]);
  const double cosine = 0.5 * (1 + std::cos(std::numbers::pi * progress));
  for (auto& group : optimiser_.param_groups())
    group.options().set_lr(settings_.lr_final + (settings_.lr - settings_.lr_final) * cosine);
  const CropBatch batch = sampler_.draw(step_);
  optimiser_.zero_grad();
  const Marched m = model_->train_march(batch.rays);
  const torch::Tensor error = torch::mse_loss(m.rgb, batch.color.to(model_->device()));
  const double ramp = settings_.ramp ? std::pow(0.01, 1 - progress) : 1.0;
  torch::Tensor loss = error;
  if (m.offset.defined()) loss = loss + ramp * settings_.offset * m.offset;
  if (m.divergence.defined()) loss = loss + ramp * settings_.divergence * m.divergence;
  loss.backward();
  optimiser_.step();
  loss_ = error.item<double>();
  return loss.item<double>();
}

void MlpSession::measure_due(bool all) {
  const Split* test = data_.find("test");
  for (; test && tested_ < settings_.test_at.size() && (all || seconds_ >= settings_.test_at[tested_]);
       ++tested_) {
    const double psnr = measure(model_, settings_, box_, *test, settings_.test_stride).psnr;
    tests_.push_back(
        {{"at", settings_.test_at[tested_]}, {"seconds", seconds_}, {"step", step_}, {"psnr", psnr}});
    report_line({{"step", step_}, {"seconds", seconds_}, {"test_psnr", psnr}});
    progress_.note(fmt::format("{:.0f} s, step {}: test PSNR {:.2f} dB on every {}th pixel and row", seconds_,
                               step_, psnr, settings_.test_stride));
  }
}

void MlpSession::show_held_out() {
  const Frame& f = held_out_frame(data_);
  const torch::Tensor rgb = model_->picture(view_rays(f.camera, f.time, box_, settings_.test_stride));
  held_out_psnr_ =
      capped_psnr(psnr_of(rgb, view_colors(f.image, background(settings_), settings_.test_stride)));
  report_line({{"step", step_}, {"seconds", seconds_}, {"held_psnr", held_out_psnr_}, {"held_view", f.name}});
  fs::create_directories(folder_.file("preview"));
  const std::vector<char> png = encode_png(as_image(rgb, f.camera, settings_.test_stride));
  std::ofstream(fmt::format("{}/step_{:06}.png", folder_.file("preview"), step_), std::ios::binary)
      .write(png.data(), std::streamsize(png.size()));
}

void MlpSession::report_line(const Json& line) const {
  const std::string path = folder_.file("metrics.jsonl");
  if (!(std::ofstream(path, std::ios::app) << line.dump() << "\n" << std::flush))
    fail_output({path, "this file could not be written", "", "a full disk?", ""});
}

void MlpSession::save() const {
  std::ostringstream bytes;
  torch::save(model_, bytes);
  write_file(folder_.file(kModel), {bytes.str()});
}

}  // namespace splinevox::mlp
