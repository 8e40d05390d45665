// SPDX-License-Identifier: Apache-2.0
// splinevox-torture: everything that can go wrong with files, tried for a given time. Writes torture.jsonl, a line a trial, and from these
// lines torture.md. Exit code 1 if anything crashed, hung or was lost.
#include <fmt/format.h>
#include <sys/utsname.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <fstream>
#include <thread>

#include "splinevox/core/atomic_file.hpp"
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

}  // namespace

int main(int argc, char** argv) {
  CLI::App words("splinevox-torture: kills, full disks, damaged files and long runs");
  Options o;
  words.add_option("--program", o.program, "the splinevox binary")->required()->check(CLI::ExistingFile);
  words.add_option("--out", o.out, "folder for torture.jsonl, torture.md and whatever broke")->required();
  words.add_option("--seconds", o.seconds, "for all trials together")->check(CLI::Range(5.0, 1e6))->capture_default_str();
  words.add_option("--seed", o.seed, "of every random draw")->capture_default_str();
  words.add_option("--soak-steps", o.soak_steps, "training steps of the soak at most")->check(CLI::Range(1000, 100'000'000))->capture_default_str();
  CLI11_PARSE(words, argc, argv);
  try {
    std::filesystem::create_directories(o.out);
    const std::string where = machine();
    std::vector<Line> lines;
    std::string text;
    const auto told = [&](const Line& l) {
      lines.push_back(l);
      text += to_json(l) + "\n";
      splinevox::write_file(o.out + "/torture.jsonl", {text});
      fmt::print("{:<20} {:<16} {:>9} cases, {} crashes, {} hangs, {} lost, {:.1f} s. {}\n", l.trial, l.what, l.tried, l.crashes, l.hangs, l.lost, l.seconds, l.note), std::fflush(stdout);
    };
    const auto& targets = splinevox::fuzz::targets();
    for (const auto& target : targets) told(try_inputs(o, target, 0.35 * o.seconds / double(targets.size())));
    told(in_fork([&] { return try_float_double(o, 0.08 * o.seconds); }));
    for (const Line& l : try_kills(o, 0.25 * o.seconds)) told(l);
    for (const Line& l : try_full_disk(o, 0.17 * o.seconds)) told(l);
    told(in_fork([&] { return try_soak(o, 0.15 * o.seconds); }));
    splinevox::write_file(o.out + "/torture.md", {table(lines, o, where)});
    std::uint64_t bad = 0;
    for (const Line& l : lines) bad += l.crashes + l.hangs + l.lost;
    fmt::print("{} things went wrong; table: {}/torture.md\n", bad, o.out);
    return bad == 0 ? 0 : 1;
  } catch (const std::exception& e) {
    fmt::print(stderr, "splinevox-torture: {}\n", e.what());
    return 2;
  }
}
