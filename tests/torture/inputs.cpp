// SPDX-License-Identifier: Apache-2.0
#include <signal.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <new>

#include "torture/mutate.hpp"
#include "torture/trial.hpp"

namespace splinevox::torture {
namespace {

constexpr double kHang = 2;                                // seconds of processor time
constexpr std::uint64_t kMemory = std::uint64_t(6) << 30;  // address space of a child beyond what it has

/// What a child says while it works, in memory that both see.
struct Told {
  std::atomic<std::uint64_t> next{0}, tried{0}, refused{0}, strange{0};
  std::atomic<double> began{0};  ///< clock of the input at hand; 0: none
  char words[200] = "";          ///< of the last strange exception
};

double now() { return std::chrono::duration<double>(Clock::now().time_since_epoch()).count(); }

void keep(const Options& o, const fuzz::Target& target, const char* why, std::uint64_t index,
          const std::string& file) {
  const std::filesystem::path path =
      std::filesystem::path(o.out) / (std::string(why) + "_" + target.name + "_" + std::to_string(index));
  std::ofstream(path, std::ios::binary) << file;
}

/// Until the time is up, or to the end of one input. Never returns.
[[noreturn]] void child(const Options& o, const fuzz::Target& target, Told& told, double until, bool one) {
  std::uint64_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  const rlimit memory{pages * 4096 + kMemory, RLIM_INFINITY}, no_core{0, 0};
  ::setrlimit(RLIMIT_AS, &memory);
  ::setrlimit(RLIMIT_CORE, &no_core);
  if (!std::freopen("/dev/null", "w", stderr)) ::_exit(3);
  const std::vector<std::string> seeds = target.seeds();
  do {
    const std::uint64_t index = told.next;
    const std::string file = index < seeds.size() ? seeds[index] : mutate(target, seeds, o.seed, index);
    told.began = now();
    try {
      told.refused +=
          std::uint64_t(target.run(reinterpret_cast<const std::uint8_t*>(file.data()), file.size()));
    } catch (const std::exception& e) {
      ++told.strange;
      std::snprintf(told.words, sizeof told.words, "%s", e.what());
      keep(o, target, "strange", index, file);
    }
    told.began = 0;
    ++told.tried;
    ++told.next;
  } while (!one && now() < until);
  ::_exit(0);
}

pid_t start(const Options& o, const fuzz::Target& target, Told& told, double until, bool one) {
  const pid_t process = ::fork();
  if (process == 0) {
    ::setpgid(0, 0);
    child(o, target, told, until, one);
  }
  return process;
}

/// Processor seconds that one input takes, its children's included, or kHang and more.
double cost_of(const Options& o, const fuzz::Target& target, Told& told) {
  const pid_t process = start(o, target, told, 0, true);
  rusage usage{};
  int status = 0;
  for (const double end = now() + 60;;) {
    if (::wait4(process, &status, WNOHANG, &usage) == process) break;
    if (now() > end) {
      ::kill(-process, SIGKILL);
      ::waitpid(process, &status, 0);
      return kHang + 58;
    }
    ::usleep(10000);
  }
  fuzz::remove_folder(process);
  const auto seconds = [](const timeval& t) { return double(t.tv_sec) + 1e-6 * double(t.tv_usec); };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

}  // namespace

Line try_inputs(const Options& o, const fuzz::Target& target, double seconds) {
  const Clock::time_point begin = Clock::now();
  void* memory = ::mmap(nullptr, sizeof(Told), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) throw std::bad_alloc();
  Told& told = *new (memory) Told;
  Line line{"inputs", target.name};
  const double until = now() + seconds;
  while (now() < until) {
    const pid_t process = start(o, target, told, until, false);
    int status = 0;
    bool slow = false;
    while (::waitpid(process, &status, WNOHANG) == 0) {
      const double began = told.began;
      if (began > 0 && now() - began > kHang) {
        slow = true;
        ::kill(-process, SIGKILL);
        ::waitpid(process, &status, 0);
        break;
      }
      ::usleep(20000);
    }
    fuzz::remove_folder(process);
    if (!slow && WIFEXITED(status) && WEXITSTATUS(status) == 0) continue;
    const std::uint64_t index = told.next;
    const auto save = [&](const char* why) {
      // In a fork: making seeds may start threads, which the next child must not inherit.
      in_fork([&] {
        const std::vector<std::string> seeds = target.seeds();
        keep(o, target, why, index,
             index < seeds.size() ? seeds[index] : mutate(target, seeds, o.seed, index));
        return Line{};
      });
    };
    if (slow) {
      if (cost_of(o, target, told) >= kHang) {
        ++line.hangs;
        save("hang");
      }
    } else {
      ++line.crashes;
      save("crash");
    }
    told.next = index + 1;
    ++told.tried;
    told.began = 0;
  }
  line.tried = told.tried;
  line.crashes += told.strange;
  line.seconds = since(begin);
  line.note = std::to_string(told.refused.load()) + " refused";
  if (told.words[0]) line.note += std::string("; threw: ") + told.words;
  ::munmap(memory, sizeof(Told));
  return line;
}

}  // namespace splinevox::torture
