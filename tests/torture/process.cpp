// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "torture/trial.hpp"

namespace splinevox::torture {

Process::Process(std::vector<std::string> words, const std::string& log, std::int64_t file_bytes,
                 const std::vector<std::string>& environment) {
  std::vector<char*> arguments;
  for (std::string& w : words) arguments.push_back(w.data());
  arguments.push_back(nullptr);
  process_ = ::fork();
  if (process_ != 0) return;
  const int out = ::open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600), in = ::open("/dev/null", O_RDONLY);
  ::dup2(in, 0);
  ::dup2(out, 1);
  ::dup2(out, 2);
  if (file_bytes >= 0) {
    const rlimit limit{rlim_t(file_bytes), rlim_t(file_bytes)};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  const rlimit no_core{0, 0};
  ::setrlimit(RLIMIT_CORE, &no_core);
  for (const std::string& e : environment)
    ::setenv(e.substr(0, e.find('=')).c_str(), e.substr(e.find('=') + 1).c_str(), 1);
  ::execv(arguments[0], arguments.data());
  ::_exit(127);
}

void Process::send(int signal) { ::kill(process_, signal); }

bool Process::ended() {
  if (ended_) return true;
  rusage usage{};
  ended_ = ::wait4(process_, &status_, WNOHANG, &usage) == process_;
  const auto seconds = [](const timeval& t) { return double(t.tv_sec) + 1e-6 * double(t.tv_usec); };
  if (ended_) processor_seconds_ = seconds(usage.ru_utime) + seconds(usage.ru_stime);
  return ended_;
}

int Process::wait(double seconds) {
  const Clock::time_point start = Clock::now();
  while (!ended()) {
    if (since(start) > seconds) {
      send(SIGKILL);
      ::waitpid(process_, &status_, 0);
      ended_ = true;
      return -1;
    }
    ::usleep(2000);
  }
  return WIFEXITED(status_) ? WEXITSTATUS(status_) : 128 + WTERMSIG(status_);
}

std::string to_json(const Line& l) {
  return nlohmann::ordered_json{{"trial", l.trial},     {"what", l.what},   {"tried", l.tried},
                                {"crashes", l.crashes}, {"hangs", l.hangs}, {"lost", l.lost},
                                {"seconds", l.seconds}, {"note", l.note}}
      .dump();
}

Line in_fork(const std::function<Line()>& work) {
  int ends[2];
  if (::pipe(ends) != 0) throw std::runtime_error("no pipe");
  const pid_t process = ::fork();
  if (process == 0) {
    ::close(ends[0]);
    int code = 1;
    try {
      const std::string text = to_json(work());
      code = ::write(ends[1], text.data(), text.size()) == ssize_t(text.size()) ? 0 : 1;
    } catch (const std::exception& e) {
      ::dprintf(2, "torture: %s\n", e.what());
    }
    fuzz::remove_folder(::getpid());
    ::_exit(code);
  }
  ::close(ends[1]);
  std::string text;
  char buffer[4096];
  for (ssize_t n; (n = ::read(ends[0], buffer, sizeof buffer)) > 0;) text.append(buffer, std::size_t(n));
  ::close(ends[0]);
  int status = 0;
  ::waitpid(process, &status, 0);
  Line line;
  if (status != 0) {
    line.crashes = 1;
    line.note = "the trial itself ended early";
  }
  if (text.empty()) return line;
  const auto j = nlohmann::json::parse(text);
  return {j["trial"], j["what"], j["tried"], j["crashes"], j["hangs"], j["lost"], j["seconds"], j["note"]};
}

}  // namespace splinevox::torture
