// SPDX-License-Identifier: Apache-2.0
#include "report/write_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <utility>

#include "core/atomic_file.hpp"
#include "core/own_folder.hpp"
#include "report/page.hpp"
#include "run/html.hpp"
#include "run/own_json.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/data/image_io.hpp"
#include "splinevox/run/evaluate.hpp"
#include "splinevox/run/run.hpp"

namespace fs = std::filesystem;

namespace splinevox::run {
namespace {

/// Which frames to show: the worst by PSNR if the split was evaluated, else evenly spaced ones.
std::vector<std::size_t> choose_views(const Json& metrics, const Split& split, int count) {
  std::vector<std::pair<double, std::size_t>> order;
  const std::size_t n = split.frames.size();
  const bool known =
      metrics.contains("frames") && metrics["frames"].size() == n && metrics.value("split", "") == split.name;
  for (std::size_t i = 0; i < n; ++i)
    order.emplace_back(known ? metrics["frames"][i].value("psnr", 0.0) : 0.0, i);
  std::stable_sort(order.begin(), order.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<std::size_t> chosen;
  for (std::size_t k = 0; k < std::min(n, std::size_t(count)); ++k)
    chosen.push_back(known ? order[k].second : k * n / std::min(n, std::size_t(count)));
  return chosen;
}

void add_views(ReportRun& page, const ReportRequest& o, const std::string& path) {
  try {
    const Run run = open_run(path);
    const std::string split = page.metrics.value("split", "test");
    const Dataset data = open_split(run, o.data, split);
    Renderer renderer(run.model);
    for (const std::size_t i : choose_views(page.metrics, *data.find(split), o.views)) {
      const Frame& frame = data.find(split)->frames[i];
      const View v = evaluate_view(run.model, renderer, frame);
      const auto layer = [&](bool there, const char* name) {
        return there ? encode_png(layer_picture(run.model, v.layers, name, frame.camera))
                     : std::vector<char>{};
      };
      const MotionField& motion = run.model.motion;
      page.views.push_back({frame.name, frame.time, v.psnr, v.ssim, encode_png(v.truth), encode_png(v.render),
                            encode_png(error_picture(v, frame)), layer(motion.moves(), "flow"),
                            layer(motion.moves() && motion.rigidity, "rigidity")});
    }
    std::stable_sort(page.views.begin(), page.views.end(),
                     [](const auto& a, const auto& b) { return a.psnr < b.psnr; });
    page.views_note = fmt::format("{} split, {}", split,
                                  page.metrics.contains("frames")
                                      ? "the worst views first"
                                      : "some views, the worst of them first; `splinevox eval` measures all");
  } catch (const Error& e) {
    page.views_note = std::string("There are no pictures: ") + e.what();
  }
}

ReportRun read_run(const ReportRequest& o, std::string path) {
  while (path.size() > 1 && path.back() == '/') path.pop_back();
  // Runs of the perceptron variants (bench/baselines/mlp) have a network where ours have grids, and their
  // figures look the same.
  const bool network = fs::is_regular_file(path + "/model.pt");
  if (!network) check_run(path);
  check_own_folder(path, Depth::all);
  ReportRun page;
  page.model_file = network ? "model.pt" : "model.vdb";
  page.name = fs::weakly_canonical(path).filename().string();
  page.metrics = read_metrics_if_there(path + "/metrics.json");
  for (MetricsLine& line : read_metrics_lines(path + "/metrics.jsonl"))
    page.lines.push_back(std::move(line.json));
  page.effects = read_effects_if_there(path + "/effects.json");
  page.config = read_text_if_there(path + "/config.toml");
  page.model_bytes = double(fs::file_size(path + "/" + page.model_file));
  if (network)
    page.views_note =
        "There are no pictures of a perceptron here: `splinevox-mlp render` makes them, minutes each on a "
        "CPU.";
  else
    add_views(page, o, path);
  return page;
}

}  // namespace

void write_report(const ReportRequest& o) {
  probe_output_file(o.out, is_page);
  std::vector<ReportRun> runs;
  for (const std::string& path : o.runs) runs.push_back(read_run(o, path));
  std::set<std::string> names;
  for (std::size_t i = 0; i < runs.size(); ++i)
    if (!names.insert(runs[i].name).second)
      runs[i].name = o.runs[i];  // two folders of one name: the paths tell them apart
  write_file(o.out, {report_page(runs)}, Named::by_user);
}

}  // namespace splinevox::run
