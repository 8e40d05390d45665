// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/wait.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <thread>
#include <utility>

#include "core/atomic_file.hpp"
#include "core/handle.hpp"
#include "core/printable.hpp"
#include "core/spawn.hpp"
#include "core/system.hpp"
#include "run/signals.hpp"
#include "run/sweep/sweep.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox::run {
namespace {

/// Starts this program with other words; what it says is added to a file. The terminal's Ctrl-C comes to us,
/// and from us once.
pid_t start(std::vector<std::string> words, const std::string& log) {
  words.insert(words.begin(), "splinevox");
  const Handle said(log, O_CREAT | O_WRONLY | O_APPEND | O_NOFOLLOW);
  const pid_t process = !said.ok() ? -1
                                   : spawn({.program = own_program_again(),
                                            .words = std::move(words),
                                            .output = said.get(),
                                            .errors = said.get(),
                                            .own_group = true});
  if (process < 0)
    fail_output({own_program(), "could not be started", "a free process and a place for " + log,
                 std::strerror(errno), "fewer --jobs"});
  return process;
}

constexpr std::chrono::milliseconds kLook{50};

/// Words, a line each, without the folder of the run: it may have moved, and has many spellings.
std::string without_folder(const std::string& words) {
  const std::size_t at = words.find("\n--out\n");
  if (at == words.npos) return words;
  const std::size_t value = at + std::string_view("\n--out\n").size(), end = words.find('\n', value);
  return words.substr(0, at + 1) + (end == words.npos ? "" : words.substr(end + 1));
}

/// What is still to do for a task: training, then evaluation. Empty: nothing.
std::vector<std::string> next_words(const SweepTask& t, int threads) {
  const SweepState s = state_of(t);
  if (!s.fault.empty()) throw std::runtime_error(s.fault);
  const std::string path = t.run + ".words", asked = fmt::format("{}\n", fmt::join(t.train, "\n"));
  if (!s.trained)
    write_file(path, {asked});
  else if (const std::string trained = read_text_if_there(path);
           !trained.empty() && without_folder(trained) != without_folder(asked))
    throw std::runtime_error("was trained with other words than this sweep has for it, see " + path);
  if (s.done) return {};
  std::vector<std::string> words = s.trained ? std::vector<std::string>{"eval", t.run} : t.train;
  words.insert(words.end(), {"--threads", std::to_string(threads)});
  return words;
}

}  // namespace

std::vector<std::string> run_sweep(
    const std::vector<SweepTask>& tasks, const std::string& out, int jobs, int threads,
    const std::function<void(const SweepTask& task, std::size_t ended, const std::string& what)>& on_end) {
  std::vector<std::string> failed;
  std::map<pid_t, std::size_t> running;
  std::size_t next = 0, ended = 0;
  bool announced = false;
  const auto tell = [&](const SweepTask& t, const std::string& what) { on_end(t, ++ended, what); };
  const auto go_on = [&](std::size_t task) {  // false: there is nothing left to do for it
    const SweepTask& t = tasks[task];
    std::vector<std::string> words;
    try {
      words = next_words(t, threads);
    } catch (const std::runtime_error& e) {  // one bad run is no reason to leave the others
      failed.push_back(t.name);
      tell(t, fmt::format("failed: {}", all_printable(e.what())));
      return true;
    }
    if (words.empty()) return false;
    try {
      running[start(words, out + "/" + t.name + ".log")] = task;
    } catch (const Error&) {  // the others would go on without anyone who could stop them
      for (const auto& [process, other] : running) ::kill(process, SIGINT);
      throw;
    }
    return true;
  };
  while (!running.empty() || (next < tasks.size() && !stop_asked())) {
    while (next < tasks.size() && int(running.size()) < jobs && !stop_asked()) {
      if (!go_on(next)) tell(tasks[next], "was done");
      ++next;
    }
    if (running.empty()) continue;
    if (stop_asked() && !std::exchange(announced, true))
      for (const auto& [process, task] : running) ::kill(process, SIGINT);
    int status = 0;
    const pid_t process = ::waitpid(-1, &status, WNOHANG);
    if (process <= 0 || !running.contains(process)) {
      std::this_thread::sleep_for(kLook);
      continue;
    }
    const std::size_t task = running[process];
    running.erase(process);
    const SweepTask& t = tasks[task];
    const bool good = WIFEXITED(status) && WEXITSTATUS(status) == 0;
    if (stop_asked()) continue;
    if (!good || !state_of(t).trained) {
      failed.push_back(t.name);
      tell(t, fmt::format("failed, see {}/{}.log", out, t.name));
    } else if (!go_on(task)) {
      tell(t, fmt::format("PSNR {:.2f} dB", state_of(t).metrics.value("psnr", 0.0)));
    }
  }
  return failed;
}

}  // namespace splinevox::run
