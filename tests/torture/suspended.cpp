// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <random>

#include "core/atomic_file.hpp"
#include "torture/scene.hpp"
#include "torture/trial.hpp"

namespace splinevox::torture {
namespace {

constexpr double kBudget = 2;   ///< seconds of training
constexpr double kAsleep = 4;   ///< more than all of it
constexpr double kShare = 0.4;  ///< of the steps of a run that was left alone; others may have the processors

std::int64_t steps_in(const std::string& run) {
  return nlohmann::json::parse(read_file(run + "/metrics.json")).at("steps");
}

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
  double fewest = 1e9;
  do {
    std::filesystem::remove_all(out);
    if (Process(words, log).wait() != 0) throw std::runtime_error("training fails by itself, see " + log);
    const std::int64_t alone = steps_in(out);
    std::filesystem::remove_all(out);
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
    const double share = double(steps_in(out)) / double(alone);
    fewest = std::min(fewest, share);
    line.lost += share < kShare;
  } while (since(begin) < seconds);
  line.seconds = since(begin);
  line.note = fmt::format(
      "asleep for {:.0f} s of a budget of {:.0f} s; at least {:.2f} of the steps of a run left alone",
      kAsleep, kBudget, fewest);
  return line;
}

}  // namespace splinevox::torture
