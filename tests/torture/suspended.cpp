// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <filesystem>
#include <random>

#include "torture/scene.hpp"
#include "torture/trial.hpp"

namespace splinevox::torture {
namespace {

constexpr double kBudget = 2;  ///< seconds of training
constexpr double kAsleep = 4;  ///< more than all of it

}  // namespace

Line try_suspended(const Options& o, double seconds) {
  const Clock::time_point begin = Clock::now();
  const Scene scene(o);
  const std::string log = o.out + "/suspended.log", out = scene.path("suspended");
  std::vector<std::string> words = scene.train_words();
  for (std::size_t i = 0; i + 1 < words.size(); ++i)
    if (words[i] == "--max-steps")
      words.erase(words.begin() + std::ptrdiff_t(i), words.begin() + std::ptrdiff_t(i) + 2);
  words.insert(words.end(), {"--max-time", std::to_string(int(kBudget)), "--out", out});
  Line line{"suspended", "train"};
  std::mt19937_64 random(o.seed);
  double shortest = 1e9;
  do {
    std::filesystem::remove_all(out);
    const Clock::time_point start = Clock::now();
    Process process(words, log);
    while (!process.ended() && !std::filesystem::exists(out + "/metrics.jsonl")) ::usleep(1000);  // it trains
    ::usleep(useconds_t(1000 * (random() % 1000)));
    process.send(SIGSTOP);
    ::usleep(useconds_t(1e6 * kAsleep));
    process.send(SIGCONT);
    const int code = process.wait();
    ++line.tried;
    line.hangs += code < 0;
    line.crashes += code > 128;
    if (code != 0) {
      ++line.lost;
      continue;
    }
    // Whatever else the processors had to do, a run that was asleep and used its budget took at least this.
    const double took = since(start);
    shortest = std::min(shortest, took);
    line.lost += took < kAsleep + kBudget;
  } while (since(begin) < seconds);
  line.seconds = since(begin);
  line.note = fmt::format("asleep for {:.0f} s of a budget of {:.0f} s: the shortest took {:.1f} s", kAsleep,
                          kBudget, shortest);
  return line;
}

}  // namespace splinevox::torture
