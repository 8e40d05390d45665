// SPDX-License-Identifier: Apache-2.0
#include <signal.h>
#include <sys/inotify.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <random>

#include "core/atomic_file.hpp"
#include "io/checkpoint.hpp"
#include "splinevox/core/error.hpp"
#include "torture/scene.hpp"
#include "torture/trial.hpp"

namespace splinevox::torture {
namespace fs = std::filesystem;

namespace {

constexpr int kMostKills = 4;  // of one run before it is let to its end
constexpr int kEvents = 40;    // on files, about as many as a job has
constexpr int kStopped = 130;  // exit code of a program that was asked to and saved what it had

/// Whether a folder's files are all there and whole, by the program's own word.
bool whole(const Options& o, const std::string& folder, const std::string& log) {
  return Process({o.program, "verify", folder}, log).wait() == 0;
}

std::string bytes_of(const std::string& path) {
  try {
    return read_file(path);
  } catch (const Error&) {
    return "";
  }
}

int drafts_in(const std::string& folder) {
  int n = 0;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) n += entry.path().extension() == ".tmp";
  return n;
}

/// Waits for the n-th thing that a process does to the files of a folder (a draft made, written to, renamed)
/// and kills it there and then.
/// @return false if the process ended before.
bool kill_while_writing(Process& process, const std::string& folder, int nth) {
  const int watch = ::inotify_init1(IN_CLOEXEC | IN_NONBLOCK);
  ::inotify_add_watch(watch, folder.c_str(),
                      IN_CREATE | IN_MODIFY | IN_CLOSE_WRITE | IN_MOVED_FROM | IN_MOVED_TO | IN_DELETE);
  bool killed = false;
  for (int seen = 0; !killed;) {
    char events[4096];
    const ssize_t n = ::read(watch, events, sizeof events);
    for (ssize_t at = 0; at + ssize_t(sizeof(inotify_event)) <= n; ++seen) {
      inotify_event event;
      std::memcpy(&event, events + at, sizeof event);
      at += ssize_t(sizeof event + event.len);
    }
    if (seen >= nth) {
      process.send(SIGKILL);
      killed = true;
    } else if (process.ended())
      break;
    else if (n <= 0)
      ::usleep(100);
  }
  ::close(watch);
  return killed;
}

/// Whether a run's folder has a checkpoint from before its end, to go on from.
bool in_the_middle(const std::string& folder) {
  try {
    const std::uint64_t step = read_checkpoint(folder + "/checkpoint.bin").header.step;
    return step > 0 && step < std::uint64_t(Scene::kSteps);
  } catch (const Error&) {
    return false;
  }
}

/// What is killed, how it is begun and gone on with, and the files that must come out as if it never had
/// been.
struct Job {
  const char* name;
  std::vector<std::string> words;
  std::vector<std::string> files;
};

Line kill_again_and_again(const Options& o, const Job& job, const std::string& folder, double seconds) {
  const std::string log = o.out + "/kills.log", reference = folder + "_reference", out = folder + "_out";
  const auto words = [&](const std::string& to) {
    std::vector<std::string> all = job.words;
    all.insert(all.end(), {"--out", to});
    return all;
  };
  Line line{"kills", job.name};
  const Clock::time_point first = Clock::now();
  if (Process(words(reference), log).wait() != 0)
    throw std::runtime_error("the program cannot do it without being killed, see " + log);
  double length = since(first);
  const Clock::time_point begin = Clock::now();
  std::mt19937_64 random(o.seed);
  std::uint64_t drafts = 0, ends = 0, stops = 0, resumed = 0;
  while (since(begin) < seconds) {
    fs::remove_all(out);
    const std::string kept = o.out + "/lost_" + job.name + "_" + std::to_string(line.lost + 1);
    std::string fault;  // the first thing that was not as it should be
    const auto must = [&](bool good, const std::string& what) {
      if (good || !fault.empty()) return;
      fault = what;
      fs::copy_file(log, kept + ".log", fs::copy_options::overwrite_existing);
    };
    const int kills = 1 + int(random() % kMostKills);
    for (int k = 0; k < kills; ++k) {
      fs::create_directories(out);
      resumed += in_the_middle(out);
      Process process(words(out), log);
      std::uniform_real_distribution<double> moment(0, 1.1 * length);
      int code = -1;
      switch (random() % 3) {
        case 0:
          code = process.wait(moment(random));  // kills it
          break;
        case 1:
          ::usleep(useconds_t(1e6 * moment(random)));
          if (!process.ended()) process.send(SIGTERM);
          code = process.wait();
          if (code == -1) {
            ++line.hangs;
            must(false, "it did not end when it was asked to");
          }
          if (code == kStopped || code == 128 + SIGTERM) {
            code = 0;
            ++stops;
          }  // the latter: before it listens
          break;
        default: {
          const bool killed = kill_while_writing(process, out, 1 + int(random() % kEvents));
          code = process.wait();
          if (code == -1) {
            ++line.hangs;
            must(false, "it did not end");
          }
          if (killed && code == 128 + SIGKILL) code = -1;
        }
      }
      if (code == -1) ++line.tried;
      must(code == -1 || code == 0, "start " + std::to_string(k) + " ended with " + std::to_string(code));
      drafts += std::uint64_t(drafts_in(out));
    }
    resumed += in_the_middle(out);
    const Clock::time_point last = Clock::now();
    must(Process(words(out), log).wait() == 0, "the last start failed");
    length = 0.7 * length + 0.3 * std::max(since(last), 0.05);  // other programs come and go
    must(whole(o, out, log), "verify is not content");
    must(drafts_in(out) == 0, "a draft is left");
    for (const std::string& file : job.files)
      must(!bytes_of(reference + "/" + file).empty() &&
               bytes_of(out + "/" + file) == bytes_of(reference + "/" + file),
           file + " differs");
    ++ends;
    if (fault.empty()) continue;
    ++line.lost;
    fs::copy(out, kept, fs::copy_options::recursive | fs::copy_options::overwrite_existing);
    write_file(kept + ".txt", {fault + "\n"});
  }
  line.seconds = since(begin);
  line.note = std::to_string(ends) +
              " runs ended as one that was left alone, bit for bit, but for those lost; " +
              std::to_string(drafts) + " kills hit a file half written; " + std::to_string(stops) +
              " were asked to stop besides";
  if (resumed > 0) line.note += "; " + std::to_string(resumed) + " starts went on from the middle";
  return line;
}

}  // namespace

std::vector<Line> try_kills(const Options& o, double seconds) {
  const Scene scene(o);
  std::vector<std::string> train = scene.train_words();
  train.push_back("--resume");
  const std::vector<Job> jobs = {
      {"train", train, {"model.vdb", "config.toml", "effects.json"}},
      {"export",
       scene.export_words(),
       {"manifest.json", "frame_0001.vdb", "frame_0004.vdb", "load_in_blender.py"}}};
  std::vector<Line> lines;
  for (const Job& job : jobs)
    lines.push_back(kill_again_and_again(o, job, scene.path(job.name), seconds / double(jobs.size())));
  return lines;
}

}  // namespace splinevox::torture
