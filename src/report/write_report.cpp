// SPDX-License-Identifier: Apache-2.0
#include "report/write_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <set>
#include <utility>

#include "core/atomic_file.hpp"
#include "core/own_folder.hpp"
#include "report/page.hpp"
#include "run/colours.hpp"
#include "run/html.hpp"
#include "run/own_json.hpp"
#include "run/run_folder.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/data/image_io.hpp"
#include "splinevox/run/evaluate.hpp"
#include "splinevox/run/run.hpp"

namespace fs = std::filesystem;

namespace splinevox::run {
namespace {

/// Whether these very frames were evaluated.
bool were_measured(const Json& metrics, const Split& split) {
  if (!metrics.contains("frames") || metrics.value("split", "") != split.name) return false;
  return std::equal(split.frames.begin(), split.frames.end(), metrics["frames"].begin(),
                    metrics["frames"].end(),
                    [](const Frame& f, const Json& j) { return j.value("name", "") == f.name; });
}

/// Which frames to show: the worst by PSNR if they were measured, else evenly spaced ones.
std::vector<std::size_t> choose_views(const Json& metrics, const Split& split, bool known, int count) {
  std::vector<std::pair<double, std::size_t>> order;
  const std::size_t n = split.frames.size();
  for (std::size_t i = 0; i < n; ++i)
    order.emplace_back(known ? metrics["frames"][i].value("psnr", 0.0) : 0.0, i);
  std::stable_sort(order.begin(), order.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<std::size_t> chosen;
  for (std::size_t k = 0; k < std::min(n, std::size_t(count)); ++k)
    chosen.push_back(known ? order[k].second : k * n / std::min(n, std::size_t(count)));
  return chosen;
}

/// Where the run is from, as its own files say.
void add_facts(ReportRun& page, const std::string& path, bool network) {
  const auto add = [&](const char* what, const std::string& text) {
    if (!text.empty()) page.facts.emplace_back(what, text);
  };
  const auto noted = [&](const char* key) {
    return page.metrics.contains(key) && page.metrics[key].is_string() ? page.metrics[key].get<std::string>()
                                                                       : std::string();
  };
  RunRecord record;
  if (!network) try {
      Config config;
      read_run_config(path, config, record);
      add("data set", fmt::format("{} (fingerprint {:016x})", record.dataset, record.fingerprint));
    } catch (const Error&) {  // of which the pictures' place tells
    }
  add("trained", noted("date"));
  const std::string commit = noted("commit");
  page.version = record.version;
  if (!record.version.empty())
    add("by", fmt::format("splinevox {}{}, {}", record.version, commit.empty() ? "" : ", commit " + commit,
                          record.compiler));
  add("on", noted("machine"));
  add("command", noted("command"));
}

/// An address within a page of a file beside it.
std::string address(const std::string& path) {
  std::string out;
  for (const char c : path)
    if (std::isalnum(static_cast<unsigned char>(c)) || std::strchr("-._~/", c))
      out += c;
    else
      out += fmt::format("%{:02X}", static_cast<unsigned char>(c));
  return out;
}

/// A page of `view` about this run. @param model  its model_mark; of a page that has none the name tells
/// @param own  whether the page lies in the run
bool shows_run(const fs::path& file, const std::string& name, const std::string& model, bool own) {
  std::ifstream in(file, std::ios::binary);
  std::string start(4096, '\0');
  in.read(start.data(), std::streamsize(start.size()));
  start.resize(std::size_t(in.gcount()));
  if (!is_view(start) || start.find("<title>splinevox: " + escape(name) + "</title>") == start.npos)
    return false;
  const std::string mark = "<meta name=\"model\" content=\"";  // pages of older versions have none
  return own || start.find(mark) == start.npos || start.find(mark + model + "\">") != start.npos;
}

/// Pages of `view` and films that lie beside the report, in its folder's film*/ or in the run.
void add_links(ReportRun& page, const std::string& run, const std::string& out, bool alone) {
  const fs::path here = fs::absolute(out).lexically_normal().parent_path();
  const fs::path own = fs::absolute(run).lexically_normal();
  const std::string model = page.model_file == "model.vdb" ? model_mark(run) : "";
  std::vector<fs::path> found;
  const auto look = [&](const fs::path& folder, bool films) {
    std::error_code ignored;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored)) {
      if (!entry.is_regular_file(ignored)) continue;
      const std::string end = entry.path().extension().string();
      if ((films && (end == ".mp4" || end == ".webm")) ||
          (end == ".html" && shows_run(entry.path(), page.name, model, folder == own)))
        found.push_back(entry.path());
    }
  };
  look(here, alone);
  look(own, true);
  std::error_code ignored;
  for (const fs::path& parent : {here, own})
    for (const fs::directory_entry& entry : fs::directory_iterator(parent, ignored))
      if (entry.path().filename().string().starts_with("film") && entry.is_directory(ignored) &&
          (alone || parent == own))
        look(entry.path(), true);
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  for (const fs::path& file : found) {
    const std::string path = file.lexically_relative(here).string();
    page.links.emplace_back((file.extension() == ".html" ? "The scene, to turn and play: " : "Film: ") + path,
                            address(path));
  }
}

void add_views(ReportRun& page, const ReportRequest& o, const std::string& path) {
  try {
    const Run run = open_run(path);
    const std::string split = page.metrics.value("split", "test");
    const Dataset data = open_split(run, o.data, split);
    const bool measured = were_measured(page.metrics, *data.find(split));
    Renderer renderer(run.model);
    for (const std::size_t i : choose_views(page.metrics, *data.find(split), measured, o.views)) {
      const Frame& frame = data.find(split)->frames[i];
      const View v = evaluate_view(run.model, renderer, frame);
      const auto layer = [&](bool there, const char* name) {
        return there ? encode_png(layer_picture(run.model, v.layers, name, frame.camera))
                     : std::vector<char>{};
      };
      const MotionField& motion = run.model.motion;
      page.views.push_back({fmt::format("{} view {}", split, frame.name), frame.time, v.psnr, v.ssim,
                            encode_png(v.truth), encode_png(v.render), encode_png(error_picture(v, frame)),
                            layer(motion.moves(), "flow"),
                            layer(motion.moves() && motion.rigidity, "rigidity")});
    }
    std::stable_sort(page.views.begin(), page.views.end(),
                     [](const auto& a, const auto& b) { return a.psnr < b.psnr; });
    page.views_note =
        fmt::format("{} split, {}", split,
                    measured ? "the worst views first"
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
  add_facts(page, path, network);
  add_links(page, path, o.out, o.runs.size() == 1);
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

std::size_t write_report(const ReportRequest& o) {
  probe_output_file(o.out, [](std::string_view start) { return is_page(start) && !is_view(start); });
  std::vector<ReportRun> runs;
  for (const std::string& path : o.runs) runs.push_back(read_run(o, path));
  std::multiset<std::string> names;
  for (const ReportRun& run : runs) names.insert(run.name);
  for (std::size_t i = 0; i < runs.size(); ++i)
    if (names.count(runs[i].name) > 1) runs[i].name = o.runs[i];  // the paths tell folders of one name apart
  const std::string html = report_page(runs);
  write_file(o.out, {html}, Named::by_user);
  return html.size();
}

}  // namespace splinevox::run
