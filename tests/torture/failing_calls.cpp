// SPDX-License-Identifier: Apache-2.0
// Allocations and system calls that fail, one after the other (failing.cpp makes them).
#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <random>

#include "torture/folder_files.hpp"
#include "torture/scene.hpp"
#include "torture/trial.hpp"

namespace splinevox::torture {
namespace fs = std::filesystem;

namespace {

struct Verb {
  const char* name;
  std::vector<std::string> words;
  std::string out = {};  ///< what it writes; empty: nothing
  bool listed = false;   ///< `verify` can tell whether it is whole
};

class Stage {
 public:
  Stage(const Options& o, const char* log_name) : scene(o), log(o.out + "/" + log_name), o_(o) {
    if (o.failing.empty()) throw std::runtime_error("these trials need --failing");
    const std::string run = scene.path("run"), p = o.program;
    const auto with = [](std::vector<std::string> words, const std::vector<std::string>& more) {
      words.insert(words.end(), more.begin(), more.end());
      return words;
    };
    verbs = {{"info", {p, "info", run + "/model.vdb"}},
             {"verify", {p, "verify", run}},
             {"train", with(scene.train_words(), {"--out", out()}), out(), true},
             {"export", with(scene.export_words(), {"--out", out()}), out(), true},
             {"edit", {p, "edit", run, "--reverse", "--quiet", "--out", out()}, out(), true},
             {"render",
              {p, "render", run, "--camera", "orbit", "--times", "0", "--size", "16", "--format", "png",
               "--out", out()},
              out()},
             {"track",
              {p, "track", run, "--points", scene.path("points.csv"), "--to", "0,1", "--quiet", "--out",
               out() + "/tracks.csv"},
              out()}};
    std::ofstream(scene.path("points.csv")) << "x,y,z\n0.1,0.2,0.3\n0,0,0\n";
  }
  std::string out() const { return scene.path("out"); }

  void set_up() const {
    fs::remove_all(out());
    fs::create_directories(fs::path(out()).parent_path());
  }
  int execute(const Verb& verb, const std::string& wish) const {
    set_up();
    return Process(verb.words, log, -1,
                   {"LD_PRELOAD=" + o_.failing, "SPLINEVOX_FAIL=" + wish, "SPLINEVOX_COUNT=" + counts()})
        .wait(120);
  }
  /// How often a verb does what may fail.
  long count(const Verb& verb, const std::string& call) const {
    fs::remove(counts());
    if (const int code = execute(verb, "none 0 0 once"); code != 0)
      throw std::runtime_error(fmt::format("{} fails by itself ({}), see {}", verb.name, code, log));
    std::ifstream file(counts());
    std::string name;
    for (long n = 0; file >> name >> n;)
      if (name == call) return n;
    throw std::runtime_error("the library that counts calls was not in force");
  }

  /// Looks at what one execution left. @return what is wrong, "" if nothing
  std::string judge(const Verb& verb, int code, const std::map<std::string, FileDigest>& good, Line& line,
                    bool may_refuse) const {
    std::string wrong;
    if (code < 0) {
      ++line.hangs;
      wrong = "did not end";
    } else if (code > 128) {
      ++line.crashes;
      wrong = fmt::format("signal {}", code - 128);
    } else if (code > 2 || (code == 2 && !may_refuse)) {
      ++line.lost;
      wrong = fmt::format("exit code {}", code);
    }
    if (verb.out.empty()) return wrong;
    const auto found = files_of(verb.out);
    const std::string left = code > 128 || code < 0 ? "" : what_is_wrong(found, good);
    const bool false_success =
        code == 0 &&
        (found.size() != good.size() ||
         (verb.listed && Process({o_.program, "verify", verb.out}, log + ".verify").wait() != 0));
    if (left.empty() && !false_success) return wrong;
    ++line.lost;
    return left.empty() ? "said that all was well and it was not" : left;
  }

  Scene scene;
  std::string log;
  std::vector<Verb> verbs;

 private:
  std::string counts() const { return scene.path("counts"); }
  const Options& o_;
};

std::map<std::string, FileDigest> good_files(const Stage& stage, const Verb& verb) {
  stage.execute(verb, "none 0 0 once");
  return verb.out.empty() ? std::map<std::string, FileDigest>{} : files_of(verb.out);
}

}  // namespace

Line try_allocations(const Options& o, double seconds) {
  const Clock::time_point begin = Clock::now();
  const Stage stage(o, "memory.log");
  Line line{"failing memory", "every verb"};
  std::mt19937_64 random(o.seed);
  std::uint64_t went_on = 0;
  std::map<std::string, int> wrong;
  for (const Verb& verb : stage.verbs) {
    const Clock::time_point start = Clock::now();
    const long all = stage.count(verb, "malloc");
    const auto good = good_files(stage, verb);
    do {
      // The child process that parses goes on counting from where it was made.
      const long nth = 1 + long(random() % std::uint64_t(all + all / 4 + 1));
      const bool on = random() % 3 == 0;
      const int code = stage.execute(verb, fmt::format("malloc {} {} {}", nth, ENOMEM, on ? "on" : "once"));
      ++line.tried;
      went_on += code == 0;
      const std::string what = stage.judge(verb, code, good, line, false);
      if (what.empty()) continue;
      ++wrong[fmt::format("{}: {}", verb.name, what)];
      fs::copy_file(stage.log, fmt::format("{}/memory_{}_{}{}.log", o.out, verb.name, nth, on ? "_on" : ""),
                    fs::copy_options::overwrite_existing);
    } while (since(start) < seconds / double(stage.verbs.size()));
  }
  line.seconds = since(begin);
  for (const auto& [what, times] : wrong) line.note += fmt::format("{} ({} times); ", what, times);
  line.note += fmt::format("{} went on to the end", went_on);
  return line;
}

std::vector<Line> try_system_calls(const Options& o, double seconds) {
  const Stage stage(o, "calls.log");
  std::mt19937_64 random(o.seed);
  struct Kind {
    const char* call;
    int reason;
    const char* name;
  };
  const std::vector<Kind> kinds = {
      {"write", EINTR, "write, interrupted"}, {"write", ENOSPC, "write, full disk"},
      {"write", EIO, "write, broken disk"},   {"read", EINTR, "read, interrupted"},
      {"read", EIO, "read, broken disk"},     {"open", EINTR, "open, interrupted"},
      {"open", EMFILE, "open, too many"},     {"open", EACCES, "open, not allowed"},
      {"fsync", EIO, "fsync, broken disk"},   {"fsync", EINTR, "fsync, interrupted"},
      {"rename", EIO, "rename, broken disk"}, {"mmap", ENOMEM, "mmap, no memory"},
      {"fork", EAGAIN, "fork, no process"},   {"pipe", EMFILE, "pipe, too many"}};
  std::vector<Line> lines;
  std::map<std::string, std::map<std::string, FileDigest>> good;
  for (const Verb& verb : stage.verbs) good[verb.name] = good_files(stage, verb);
  for (const Kind& kind : kinds) {
    const Clock::time_point begin = Clock::now();
    Line line{"failing calls", kind.name};
    std::uint64_t went_on = 0;
    std::map<std::string, int> wrong;
    std::map<std::string, long> counted;
    do {
      const Verb& verb = stage.verbs[random() % stage.verbs.size()];
      if (!counted.contains(verb.name)) counted[verb.name] = stage.count(verb, kind.call);
      const long nth = 1 + long(random() % std::uint64_t(counted[verb.name] + 1));
      const bool on = kind.reason != EINTR && random() % 3 == 0;
      const int code =
          stage.execute(verb, fmt::format("{} {} {} {}", kind.call, nth, kind.reason, on ? "on" : "once"));
      ++line.tried;
      went_on += code == 0;
      // Files that cannot be read, and places that cannot be written, are wrong arguments; a lack of memory
      // is not.
      std::string what = stage.judge(verb, code, good[verb.name], line, kind.reason != ENOMEM);
      if (what.empty() && kind.reason == EINTR && code != 0) {
        ++line.lost;
        what = "an interruption is an error";
      }
      if (what.empty()) continue;
      ++wrong[fmt::format("{}: {}", verb.name, what)];
      fs::copy_file(stage.log,
                    fmt::format("{}/calls_{}_{}_{}_{}.log", o.out, verb.name, kind.call, kind.reason, nth),
                    fs::copy_options::overwrite_existing);
    } while (since(begin) < seconds / double(kinds.size()));
    line.seconds = since(begin);
    for (const auto& [what, times] : wrong) line.note += fmt::format("{} ({} times); ", what, times);
    line.note += fmt::format("{} went on to the end", went_on);
    lines.push_back(line);
  }
  return lines;
}

}  // namespace splinevox::torture
