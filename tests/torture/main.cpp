// SPDX-License-Identifier: Apache-2.0
// splinevox-torture: everything that can go wrong with files, tried for a given time. Writes torture.jsonl, a
// line a trial, and from these lines torture.md. Exit code 1 if anything crashed, hung or was lost.
#include <fmt/format.h>
#include <sys/utsname.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <thread>

#include "core/atomic_file.hpp"
#include "torture/trial.hpp"

namespace {

using namespace splinevox::torture;

std::string machine() {
  std::string model = "unknown processor", line;
  std::ifstream info("/proc/cpuinfo");
  while (std::getline(info, line))
    if (line.starts_with("model name")) {
      model = line.substr(line.find(": ") + 2);
      break;
    }
  double load = 0;
  std::ifstream("/proc/loadavg") >> load;
  return fmt::format("{} ({} threads), load {:.1f}", model, std::thread::hardware_concurrency(), load);
}

/// What an hour must reach; a share of it says nothing.
struct Least {
  const char *trial, *what;  ///< what: empty for all of a trial together
  std::uint64_t cases;
};
constexpr double kHour = 3600;
constexpr Least kLeast[] = {{"inputs", "dataset_json", 1'000'000},
                            {"inputs", "png", 100'000},
                            {"inputs", "model_vdb", 10'000},
                            {"structure", "", 10'000},
                            {"kills", "", 300},
                            {"soak", "", 200'000}};

/// Trials that had too few cases, a line each.
std::vector<std::string> too_few(const std::vector<Line>& lines) {
  std::vector<std::string> out;
  for (const Least& l : kLeast) {
    std::uint64_t tried = 0;
    for (const Line& line : lines)
      if (line.trial == l.trial && (!*l.what || line.what == l.what)) tried += line.tried;
    if (tried < l.cases)
      out.push_back(
          fmt::format("{} {}: {} cases where an hour should have {}", l.trial, l.what, tried, l.cases));
  }
  return out;
}

/// Data sets are the largest of the texts, and an hour should try a million.
double weight(const std::string& parser) { return parser == "dataset_json" ? 3 : 1; }

}  // namespace

int main(int argc, char** argv) {
  CLI::App words("splinevox-torture: kills, full disks, damaged files and long runs");
  Options o;
  words.add_option("--program", o.program, "the splinevox binary")->required()->check(CLI::ExistingFile);
  words.add_option("--out", o.out, "folder for torture.jsonl, torture.md and whatever broke")
      ->required()
      ->take_last();
  words.add_option("--failing", o.failing, "libsplinevox_failing.so, for the trials calls and memory");
  words.add_option("--seconds", o.seconds, "for all trials together")
      ->check(CLI::Range(5.0, 1e6))
      ->capture_default_str();
  words.add_option("--seed", o.seed, "of every random draw")->capture_default_str();
  words.add_option("--soak-steps", o.soak_steps, "training steps of the soak at most")
      ->check(CLI::Range(1000, 100'000'000))
      ->capture_default_str();
  words.add_option("--structure-cases", o.structure_cases, "data sets of the structure trial at most")
      ->capture_default_str();
  words.add_flag("--keep-all", o.keep_all, "keep data sets that were refused or guessed wrongly too");
  std::vector<std::string> only;
  words
      .add_option(
          "--only", only,
          "some of inputs, structure, float, kills, disk, links, siblings, memory, calls, suspend, soak")
      ->delimiter(',')
      ->check(CLI::IsMember({"inputs", "structure", "float", "kills", "disk", "links", "siblings", "memory",
                             "calls", "suspend", "soak"}));
  CLI11_PARSE(words, argc, argv);
  try {
    std::filesystem::create_directories(o.out);
    const std::string where = machine();
    std::vector<Line> lines;
    std::string text;
    const auto report = [&](const Line& l) {
      lines.push_back(l);
      text += to_json(l) + "\n";
      splinevox::write_file(o.out + "/torture.jsonl", {text});
      fmt::print("{:<20} {:<16} {:>9} cases, {} crashes, {} hangs, {} lost, {:.1f} s. {}\n", l.trial, l.what,
                 l.tried, l.crashes, l.hangs, l.lost, l.seconds, l.note);
      std::fflush(stdout);
    };
    struct Trial {
      const char* name;
      double share;  ///< of the time
      std::function<void(double seconds)> run;
      bool only_if_named = false;
    };
    const auto inputs = [&](double seconds) {
      double all = 0;
      for (const auto& target : splinevox::fuzz::targets()) all += weight(target.name);
      for (const auto& target : splinevox::fuzz::targets())
        report(try_inputs(o, target, seconds * weight(target.name) / all));
    };
    const std::vector<Trial> trials = {
        {"inputs", 0.25, inputs},
        {"structure", 0.05, [&](double s) { report(try_structure(o, s)); }},
        {"float", 0.05, [&](double s) { report(in_fork([&] { return try_float_double(o, s); })); }},
        {"kills", 0.2,
         [&](double s) {
           for (const Line& l : try_kills(o, s)) report(l);
         }},
        {"disk", 0.15,
         [&](double s) {
           for (const Line& l : try_full_disk(o, s)) report(l);
         }},
        {"links", 0.05, [&](double s) { report(try_links(o, s)); }},
        {"siblings", 0.05, [&](double s) { report(try_siblings(o, s)); }},
        {"memory", 0.05, [&](double s) { report(try_allocations(o, s)); }, /*only_if_named=*/true},
        {"calls", 0.05,
         [&](double s) {
           for (const Line& l : try_system_calls(o, s)) report(l);
         }},
        {"suspend", 0.03, [&](double s) { report(try_suspended(o, s)); }},
        {"soak", 0.07, [&](double s) { report(in_fork([&] { return try_soak(o, s); })); }}};
    const auto wanted = [&](const Trial& t) {
      return only.empty() ? !t.only_if_named : std::find(only.begin(), only.end(), t.name) != only.end();
    };
    double all = 0;
    for (const Trial& t : trials) all += wanted(t) ? t.share : 0;
    for (const Trial& t : trials)
      if (wanted(t)) t.run(o.seconds * t.share / all);
    splinevox::write_file(o.out + "/torture.md", {table(lines, o, where)});
    std::uint64_t bad = 0;
    for (const Line& l : lines) {
      bad += l.crashes + l.hangs + l.lost;
      if (l.tried > 0) continue;
      fmt::print("{} {}: nothing was tried\n", l.trial, l.what);
      ++bad;
    }
    if (only.empty() && o.seconds >= kHour)
      for (const std::string& shortfall : too_few(lines)) {
        fmt::print("{}\n", shortfall);
        ++bad;
      }
    fmt::print("{} things went wrong; table: {}/torture.md\n", bad, o.out);
    return bad == 0 ? 0 : 1;
  } catch (const std::exception& e) {
    fmt::print(stderr, "splinevox-torture: {}\n", e.what());
    return 2;
  }
}
