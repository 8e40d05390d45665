// SPDX-License-Identifier: Apache-2.0
// What accuracy costs in time.
//
//   splinevox-bench cost --suite train|render|spline|versus [--micro] --out DIR [DATASET...]
//   splinevox-bench curves RUN... --out FILE.svg
//
// DIR/cost.jsonl gets one line per setting; from those lines alone come DIR/SUITE_SCENE.svg, DIR/cost.md and
// the exit code of
// --check. Measure on a quiet machine.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/global_control.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <set>
#include <thread>

#include "core/atomic_file.hpp"
#include "core/process.hpp"
#include "core/system.hpp"
#include "curves.hpp"
#include "present.hpp"
#include "run/exit_code.hpp"
#include "splinevox/core/error.hpp"
#include "suites.hpp"

namespace fs = std::filesystem;
using namespace splinevox;
using namespace splinevox::cost;

namespace {

struct Options {
  std::vector<std::string> suites{"spline", "render", "train"}, mlp;
  std::string out, commit = "unknown commit";
  SuiteOptions suite;
  int threads = 0;
  bool check = false, present_only = false;
};

std::vector<Record> read_lines(const fs::path& path) {
  std::vector<Record> out;
  std::ifstream in(path);
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) try {
      out.push_back(from_json(Json::parse(line)));
    } catch (const Json::exception& error) {
      fail({.where = fmt::format("{}, line {}", path.string(), number),
            .what = "is not a line of this program",
            .expected = "JSON with suite, scene, knob, ...",
            .got = error.what(),
            .hint = {}});
    }
  return out;
}

/// What the machine is, for every line.
std::string machine(int threads, const std::string& commit) {
  return fmt::format("{}, {} of {} threads, compiler {}, {}", processor_name(), threads,
                     std::thread::hardware_concurrency(), __VERSION__, commit);
}

/// Where a group's lines were measured, each place once.
std::string places(const std::vector<Record>& group) {
  std::vector<std::string> out;
  for (const Record& r : group)
    if (std::find(out.begin(), out.end(), r.where) == out.end()) out.push_back(r.where);
  return fmt::format("{}", fmt::join(out, "; "));
}

void present(const fs::path& folder, const std::vector<Record>& records) {
  std::string text =
      "# What accuracy costs in time\n\nMade by `splinevox-bench cost` from the lines of cost.jsonl alone. "
      "Medians with bootstrap intervals; `front` says how many times as long as the fastest setting of at "
      "most the same error.\n";
  for (const std::vector<Record>& group : by_scene(records)) {
    std::string file = group.front().suite + "_" + group.front().scene + ".svg";
    std::replace(file.begin(), file.end(), ' ', '_');
    std::ofstream(folder / file) << diagram(group,
                                            fmt::format("{}: {}", group.front().suite, group.front().scene));
    text += fmt::format("\n## {}: {}\n\n{}\n\n![{}]({})\n\n{}\n{}", group.front().suite, group.front().scene,
                        places(group), group.front().suite, file, table(group),
                        group.front().suite == "versus" ? versus_table(group) : sentences(group));
  }
  if (!(std::ofstream(folder / "cost.md") << text))
    fail_output({(folder / "cost.md").string(), "this file could not be written", "", "a full disk?", ""});
}

constexpr double kMargin = 1.05;  ///< of time, that counts as a difference

/// How many times as long the default took as itself.
double noise(const std::vector<Record>& group) {
  const auto seconds = [&](auto&& is) {
    const auto found = std::find_if(group.begin(), group.end(), is);
    return found == group.end() ? 0.0 : found->seconds.value;
  };
  const double again = seconds([](const Record&r) { return r.knob == "A/A"; }),
               base = seconds([](const Record&r) { return r.is_default; });
  return again > 0 && base > 0 ? std::max(again / base, base / again) : 1;
}

/// What must hold on any machine. @param order  of the renderer's convergence, where it was measured.
/// @return complaints
std::vector<std::string> check(const std::vector<Record>& records, bool micro, std::optional<double> order) {
  std::vector<std::string> bad;
  for (const std::vector<Record>& group : by_scene(records))
    for (const Record& r : group) {
      const std::string name = fmt::format("{} {}, {} {}", r.suite, r.scene, r.knob, r.value);
      const double distance = distance_to_front(group, r);
      if (r.failed)
        bad.push_back(fmt::format("{}: failed: {}", name, r.note));
      else if (r.expected_dominated && distance <= (micro ? 1 : kMargin))
        bad.push_back(fmt::format("{}: should be dominated and is not", name));
      else if (!micro && r.is_default && (r.suite == "train" || r.suite == "render") &&
               distance > kMargin * noise(group))
        bad.push_back(
            fmt::format("{}: takes {:.2f} times as long as another setting that is as good", name, distance));
    }
  if (order && !(std::abs(*order - 2) <= 0.1))
    bad.push_back(fmt::format("the renderer converges with order {:.3f}, not 2", *order));
  return bad;
}

int run_suites(Options o) {
  const int threads = o.threads > 0 ? o.threads : int(std::thread::hardware_concurrency());
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, std::size_t(threads));
  o.suite.where = machine(threads, o.commit);
  const fs::path folder = o.out, lines = folder / "cost.jsonl";
  fs::create_directories(folder);
  if (o.suite.micro) {
    o.suite.steps = 200;
    o.suite.seeds = 1;
  }
  std::optional<double> order;
  if (!o.present_only) {
    // Lines of other suites stay, so that suites can be run one after the other.
    // Until a suite has a line of its own, so do those that it had.
    std::vector<Record> all = read_lines(lines);
    std::set<std::string> begun;
    const OnRecord on_record = [&](Record r) {
      if (r.where.empty()) r.where = o.suite.where;
      if (begun.insert(r.suite).second)
        std::erase_if(all, [&](const Record& old) { return old.suite == r.suite; });
      all.push_back(r);
      std::string text;
      for (const Record& line : all) text += to_json(line).dump() + "\n";
      write_file(lines.string(), {text}, Named::by_user);
      fmt::print("{:<7} {:<18} {:<20} {:<36} {:>12.4g} s  error {:.3g}\n", r.suite, r.scene, r.knob, r.value,
                 r.seconds.value, r.error.value);
      std::fflush(stdout);
    };
    for (const std::string& suite : o.suites)
      suite == "spline"   ? spline_suite(o.suite, on_record)
      : suite == "render" ? void(order = render_suite(o.suite, on_record))
      : suite == "versus" ? versus_suite(o.suite, o.mlp, on_record)
                          : train_suite(o.suite, (folder / "train_runs.jsonl").string(), on_record);
  }
  const std::vector<Record> records = read_lines(lines);
  present(folder, records);
  if (!o.check) return 0;
  if (order) fmt::print("order of the renderer's convergence: {:.3f}\n", *order);
  const std::vector<std::string> bad = check(records, o.suite.micro, order);
  for (const std::string& b : bad) fmt::print(stderr, "splinevox-bench: {}\n", b);
  return bad.empty() ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App words("splinevox-bench: measurements");
  words.require_subcommand(1);
  Options o;
  CLI::App* cost = words.add_subcommand(
      "cost", "what accuracy costs in time: lines, diagrams with their Pareto front, tables, sentences");
  cost->add_option("--suite", o.suites, "train, render, spline (default: these three), versus")
      ->check(CLI::IsMember({"train", "render", "spline", "versus"}))
      ->delimiter(',');
  cost->add_option("--out", o.out, "folder")->required();
  cost->add_option("DATASET", o.suite.scenes,
                   "data sets for all but spline (default: the built-in dancer; versus has none)");
  cost->add_flag("--micro", o.suite.micro, "within a minute, on small built-in data");
  cost->add_flag("--check", o.check, "exit with 1 unless the measurements make sense");
  cost->add_flag("--present-only", o.present_only, "only tables and diagrams, from the lines that are there");
  cost->add_option("--steps", o.suite.steps, "training steps of the default setting")->capture_default_str();
  cost->add_option("--seeds", o.suite.seeds, "runs per training setting")->capture_default_str();
  cost->add_option("--knobs", o.suite.knobs, "train: only these knobs, beside the default and A/A")
      ->delimiter(',');
  cost->add_option("--rounds", o.suite.rounds, "interleaved repetitions of timed settings")
      ->capture_default_str();
  cost->add_option("--mlp", o.mlp, "versus: finished splinevox-mlp runs, made with --cpu-time and --test-at")
      ->delimiter(',');
  cost->add_option("--versus-steps", o.suite.versus_steps, "versus: training steps of the voxels' runs")
      ->delimiter(',')
      ->capture_default_str();
  cost->add_option("--threads", o.threads, "0 = every core");
  cost->add_option("--commit", o.commit, "of this program, for every line");
  std::vector<std::string> runs;
  CLI::App* curve =
      words.add_subcommand("curves", "PSNR of the held-out view against seconds of training, as a picture");
  curve->add_option("RUN", runs, "runs")->required();
  curve->add_option("--out", o.out, "SVG file")->required();
  try {
    words.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return words.exit(error) == 0 ? 0 : 2;  // --help is no mistake
  }
  return run::exit_code_of("splinevox-bench", [&] {
    if (!*curve) return run_suites(o);
    if (!(std::ofstream(o.out) << curves(runs)))
      fail_output({o.out, "this file could not be written", "", "a full disk?", ""});
    return 0;
  });
}
