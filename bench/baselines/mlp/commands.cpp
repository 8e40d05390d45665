// SPDX-License-Identifier: Apache-2.0
// The perceptron variants of the paper beside the voxel model: same data, box, metrics and run folder.
//
//   splinevox-mlp train DATASET --out RUN [--kind spline|nr-nerf|t-nerf] [--preset paper|nerf_atlas]
//   [--max-time S] ... splinevox-mlp eval RUN [--split test] [--stride 4] splinevox-mlp render RUN --out DIR
//   [--split test] [--stride 1]
#include "commands.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <thread>

#include "core/atomic_file.hpp"
#include "run/exit_code.hpp"
#include "run/signals.hpp"
#include "session.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/data/image_io.hpp"

namespace fs = std::filesystem;
using namespace splinevox;
using namespace splinevox::mlp;

namespace {

struct Options {
  std::string dataset, run, out, kind = "spline", preset = "paper", split = "test", background,
                                 device = "auto";
  std::optional<double> max_time, lr, divergence, offset;
  std::optional<int> max_steps, downscale, points, samples, stride, shrink;
  std::optional<std::uint64_t> seed;
  std::vector<double> test_at;
  int threads = 0;
  bool quiet = false, json = false, cpu_time = false;
};

void use_threads(int threads) {
  torch::set_num_threads(threads > 0 ? threads : int(std::max(1u, std::thread::hardware_concurrency())));
}

Settings effective(const Options& o) {
  Settings s = preset(o.preset, kind_of(o.kind));
  const auto set = [](auto& to, const auto& from) {
    if (from) to = *from;
  };
  set(s.max_time, o.max_time);
  set(s.max_steps, o.max_steps);
  set(s.seed, o.seed);
  set(s.downscale, o.downscale);
  set(s.points, o.points);
  set(s.samples, o.samples);
  set(s.test_stride, o.stride);
  set(s.lr, o.lr);
  set(s.divergence, o.divergence);
  set(s.offset, o.offset);
  if (o.max_steps && !o.max_time) s.max_time = 0;
  if (o.shrink) {
    s.shrink = {*o.shrink};
    s.shrink_start = {0};
  }
  if (s.max_time <= 0 && s.max_steps <= 0)
    fail({.where = "--max-time and --max-steps",
          .what = "nothing would ever end this training",
          .expected = "one of them above 0",
          .got = "0 and 0",
          .hint = {}});
  s.cpu_time = o.cpu_time;
  s.device = o.cpu_time && o.device == "auto" ? "cpu" : o.device;
  if (o.cpu_time && s.device != "cpu")
    fail({.where = "--cpu-time",
          .what = "a device's time is no processor time",
          .expected = "--device cpu",
          .got = s.device,
          .hint = {}});
  torch_device(s.device);  // before anything is written
  s.test_at = o.test_at;
  std::sort(s.test_at.begin(), s.test_at.end());
  if (!o.background.empty()) {
    s.background = o.background == "white" ? std::vector<double>{1, 1, 1}
                   : o.background == "black"
                       ? std::vector<double>{0, 0, 0}
                       : run::numbers(o.background, ',', "--background", "white, black or R,G,B");
    if (s.background.size() != 3)
      fail({.where = "--background",
            .what = "is not a colour",
            .expected = "white, black or R,G,B",
            .got = o.background,
            .hint = {}});
  }
  return s;
}

int train(const Options& o) {
  use_threads(o.threads);
  const Settings settings = effective(o);
  run::RunFolder folder(o.out, false);
  LoadOptions load{.downscale = settings.downscale, .splits = {"train"}, .time_map = {}};
  for (const char* split : {"val", "test"})
    if (fs::exists(fs::path(o.dataset) / fmt::format("transforms_{}.json", split)))
      load.splits.emplace_back(split);
  Dataset data = load_dataset(o.dataset, load);
  run::Progress progress(run::choose_talk(o.quiet, o.json));
  run::catch_stop_signals();
  MlpSession session(settings, data, folder, progress);
  const Json figures = session.run();
  write_file(folder.file("metrics.json"), {figures.dump(2) + "\n"});
  if (!o.quiet) fmt::print("{}\n", o.json ? figures.dump() : figures.dump(2));
  return run::stop_asked() ? run::kInterrupted : 0;
}

Dataset split_of(const MlpRun& run, const Options& o) {
  return load_dataset(
      o.dataset.empty() ? run.record.dataset : o.dataset,
      {.downscale = run.settings.downscale, .splits = {o.split}, .time_map = run.record.time_map});
}

int evaluate(const Options& o) {
  use_threads(o.threads);
  MlpRun run = open_run(o.run, o.device);
  const Dataset data = split_of(run, o);
  const int stride = o.stride.value_or(run.settings.test_stride);
  const Measured m = measure(run.model, run.settings, run.box, *data.find(o.split), stride);
  Json result{{"psnr", m.psnr}, {"split", o.split}, {"stride", stride}, {"frames", m.frames}};
  if (stride == 1) {
    result["ssim"] = m.ssim;
    result["ms_ssim"] = m.ms_ssim;
  }
  const std::string path = run.path + (o.split == "test" ? "/metrics.json" : "/metrics_" + o.split + ".json");
  if (o.split == "test" && fs::exists(path)) {
    const Json before = run::read_json(path);
    for (const auto& [key, value] : before.items())
      if (!result.contains(key) && key != "ssim" && key != "ms_ssim")
        result[key] = value;  // those were of other pixels
  }
  write_file(path, {result.dump(2) + "\n"});
  if (o.json)
    fmt::print("{}\n", result.dump(2));
  else
    fmt::print("mean PSNR {:.3f} dB over {} views, every {}th pixel and row\n", m.psnr, m.frames.size(),
               stride);
  return 0;
}

int render(const Options& o) {
  use_threads(o.threads);
  MlpRun run = open_run(o.run, o.device);
  run::probe_output_folder(o.out);
  const Dataset data = split_of(run, o);
  for (const Frame& f : data.find(o.split)->frames) {
    write_png(fmt::format("{}/{}.png", o.out, f.name),
              view_picture(run.model, f, run.box, o.stride.value_or(1)));
    if (!o.quiet) {
      fmt::print("{}\n", f.name);
      std::fflush(stdout);
    }
  }
  return 0;
}

}  // namespace

int splinevox::mlp::run_command_line(int argc, char** argv) {
  CLI::App words("splinevox-mlp: the paper's perceptron variants, for comparison");
  words.require_subcommand(1);
  Options o;
  const auto common = [&](CLI::App* verb) {
    verb->add_option("--threads", o.threads, "0 = every core");
    verb->add_option("--stride", o.stride, "every n-th pixel of every n-th row is rendered")
        ->check(CLI::PositiveNumber);
    verb->add_option("--device", o.device, "auto, cpu or cuda")->capture_default_str();
    verb->add_flag("--quiet", o.quiet);
    verb->add_flag("--json", o.json);
  };
  CLI::App* t = words.add_subcommand("train", "train one variant");
  common(t);
  t->add_option("DATASET", o.dataset)->required();
  t->add_option("--out", o.out, "run folder")->required();
  t->add_option("--kind", o.kind, "spline, nr-nerf or t-nerf")->capture_default_str();
  t->add_option("--preset", o.preset, "paper or nerf_atlas (its released code)")->capture_default_str();
  t->add_option("--max-time", o.max_time, "seconds");
  t->add_option("--max-steps", o.max_steps);
  t->add_flag("--cpu-time", o.cpu_time,
              "every second is one of processor time, divided by the threads: for a machine that has other "
              "work to do");
  t->add_option("--seed", o.seed);
  t->add_option("--downscale", o.downscale);
  t->add_option("--background", o.background);
  t->add_option("--points", o.points, "control points")->check(CLI::Range(2, 20));
  t->add_option("--samples", o.samples, "per ray")->check(CLI::Range(2, 1024));
  t->add_option("--lr", o.lr);
  t->add_option("--offset", o.offset);
  t->add_option("--divergence", o.divergence);
  t->add_option("--shrink", o.shrink, "one block size for all stages instead of small pictures first")
      ->check(CLI::PositiveNumber);
  t->add_option("--test-at", o.test_at, "seconds of training at which the test split is measured")
      ->delimiter(',');
  CLI::App* e = words.add_subcommand("eval", "PSNR of a split");
  CLI::App* r = words.add_subcommand("render", "pictures of a split");
  for (CLI::App* verb : {e, r}) {
    common(verb);
    verb->add_option("RUN", o.run)->required();
    verb->add_option("--data", o.dataset);
    verb->add_option("--split", o.split)->capture_default_str();
  }
  r->add_option("--out", o.out, "folder")->required();
  try {
    words.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return words.exit(error) == 0 ? 0 : 2;  // --help is no mistake
  }
  return run::exit_code_of("splinevox-mlp", [&] { return *t ? train(o) : *e ? evaluate(o) : render(o); });
}
