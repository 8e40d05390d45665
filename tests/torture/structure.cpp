// SPDX-License-Identifier: Apache-2.0
// Data sets whose truth is known, read by the loader.
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <map>
#include <new>
#include <stdexcept>

#include "torture/structure/case.hpp"
#include "torture/trial.hpp"

namespace splinevox::torture {
namespace {

namespace fs = std::filesystem;
using structure::Outcome;

/// What the child says, in memory that both see.
struct Told {
  std::atomic<std::uint64_t> next{0};
  std::atomic<std::uint64_t> counts[structure::kOutcomes] = {};
};

std::string folder_of(const std::string& name) {
  const fs::path memory = "/dev/shm";
  const fs::path root = fs::is_directory(memory) ? memory : fs::temp_directory_path();
  return (root / ("splinevox_structure_" + name)).string();
}

/// Keeps the set beside the table, with what was found.
void keep(const Options& o, const structure::Case& c, std::uint64_t index, const char* why,
          const std::string& words) {
  constexpr std::uint64_t kMost = 200;  // of a kind
  static std::map<std::string, std::uint64_t> kept;
  const fs::path path = fs::path(o.out) / fmt::format("{}_structure_{}_{}", why, o.seed, index);
  if (++kept[why] > kMost) return;
  std::string text = words + "\n\n";
  for (const std::string& drawn : c.drawn) text += "drawn: " + drawn + "\n";
  for (const structure::Shot& s : c.shots)
    text += fmt::format("{} camera {} moment {} time {} {}{}\n", s.path, s.camera, s.moment, s.time, s.split,
                        s.there ? "" : " not there");
  fs::remove_all(path);
  fs::create_directories(path);
  std::ofstream(path / "found.txt") << text;
  fs::copy(c.folder, path / "data", fs::copy_options::recursive);
}

void child(const Options& o, Told& told, Clock::time_point end, std::uint64_t most) {
  const std::string folder = folder_of(std::to_string(::getpid()));
  while (told.next < most && Clock::now() < end) {
    const std::uint64_t index = told.next;
    fs::remove_all(folder);
    fs::create_directories(folder);
    const structure::Case c = structure::make_case(o.seed, index, folder);
    std::string words;
    const Outcome outcome = structure::check(c, words);
    ++told.counts[int(outcome)];
    if (outcome == Outcome::silent) keep(o, c, index, "silent", words);
    if (outcome == Outcome::unneeded && o.keep_all) keep(o, c, index, "unneeded", words);
    if (outcome == Outcome::wrong_noted && o.keep_all) keep(o, c, index, "wrong", words);
    if (outcome == Outcome::asked && o.keep_all && index % 10 == 0) keep(o, c, index, "asked", words);
    ++told.next;
  }
  fs::remove_all(folder);
  structure::remove_pool();
}

}  // namespace

Line try_structure(const Options& o, double seconds) {
  const Clock::time_point begin = Clock::now();
  void* memory = ::mmap(nullptr, sizeof(Told), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) throw std::bad_alloc();
  Told& told = *new (memory) Told;
  Line line{"structure", "data sets"};
  const Clock::time_point end =
      begin + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
  while (told.next < o.structure_cases && Clock::now() < end) {
    const pid_t process = ::fork();
    if (process < 0) throw std::runtime_error("the structure trial cannot fork");
    if (process == 0) {
      try {
        child(o, told, end, o.structure_cases);
      } catch (const std::exception& e) {
        fmt::print(stderr, "structure, case {}: {}\n", told.next.load(), e.what());
        ::_exit(1);
      }
      ::_exit(0);
    }
    int status = 0;
    ::waitpid(process, &status, 0);
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) continue;
    std::error_code ignored;
    fs::remove_all(folder_of(std::to_string(process)), ignored);
    fs::remove_all(folder_of("pool_" + std::to_string(process)), ignored);
    fmt::print(stderr, "structure: case {} of seed {} ended its process\n", told.next.load(), o.seed);
    ++line.crashes;
    ++told.next;
  }
  line.tried = told.next;
  line.lost = told.counts[int(Outcome::silent)];
  line.seconds = since(begin);
  const auto count = [&](Outcome outcome) { return told.counts[int(outcome)].load(); };
  line.note = fmt::format(
      "{} right, {} right with a note, {} wrong with a note that it is a guess, {} asked for times, {} "
      "refused for a "
      "fault put in, {} refused besides, {} silent errors",
      count(Outcome::right), count(Outcome::right_noted), count(Outcome::wrong_noted), count(Outcome::asked),
      count(Outcome::refused), count(Outcome::unneeded), count(Outcome::silent));
  ::munmap(memory, sizeof(Told));
  return line;
}

}  // namespace splinevox::torture
