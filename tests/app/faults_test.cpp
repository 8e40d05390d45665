// SPDX-License-Identifier: Apache-2.0
// Faults F1 to F21 (docs/reliability.md lists them) as a user meets them, where no other test has them.
#include <doctest/doctest.h>
#include <sys/file.h>

#include <chrono>
#include <csignal>
#include <memory>
#include <thread>

#include "program.hpp"
#include "run/support.hpp"

using namespace splinevox::test;
namespace fs = std::filesystem;
using splinevox::run::Json;

namespace {

struct Small {
  TempFolder temp;
  std::string data = temp.str() + "/ball";
  Small() { write_moving_ball(data, {6, 0, 2, 12, 0.8}); }
  std::string path(const std::string& name) const { return temp.str() + "/" + name; }
  std::vector<std::string> train(const std::string& run, const std::string& steps,
                                 std::vector<std::string> more = {}) const {
    std::vector<std::string> words = {"train",       data,
                                      "--out",       path(run),
                                      "--preset",    "draft",
                                      "--max-steps", steps,
                                      "--set",       "sampling.rays=128",
                                      "--set",       "grid.radiance=8,12,16",
                                      "--set",       "grid.motion=4,8",
                                      "--set",       "grid.motion_start=0,0.2",
                                      "--set",       "motion.points=4",
                                      "--set",       "effects.steps=0"};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
};

/// The program in a shell: for redirections and limits.
Ended shell(const std::string& before, std::vector<std::string> words, const std::string& after = "") {
  std::string line = before + " '" + SPLINEVOX_PROGRAM + "'";
  for (const std::string& w : words) line += " '" + w + "'";
  return Started({"sh", "-c", line + " " + after}).wait();
}

/// Trains to "whole", and to "run" on a disk that has room for the model and none for the checkpoint.
Ended without_room(const Small& small, const std::string& steps, const std::vector<std::string>& more) {
  REQUIRE(program(small.train("whole", steps, more)).code == 0);
  const auto model = fs::file_size(small.path("whole") + "/model.vdb"),
             checkpoint = fs::file_size(small.path("whole") + "/checkpoint.bin");
  REQUIRE(checkpoint > 2 * model);
  return shell("ulimit -f " + std::to_string((model + model / 2) / 512) + "; exec",
               small.train("run", steps, more));
}

/// A run that goes on until it is told to stop, and has begun.
struct Endless {
  Small small;
  Started started;
  Endless() : started(words(small)) {
    REQUIRE(comes([&] { return fs::exists(small.path("run") + "/metrics.jsonl"); }));
  }
  static std::vector<std::string> words(const Small& small) {
    std::vector<std::string> all = small.train("run", "100000000", {"--quiet"});
    all.insert(all.begin(), SPLINEVOX_PROGRAM);
    return all;
  }
};

}  // namespace

TEST_SUITE("app/faults") {
  TEST_CASE("F1: what a killed run left half written is cleared away and does not stand in the way") {
    const Small small;
    fs::create_directories(small.path("run"));
    for (const char* name :
         {"config.toml.4194305-0.tmp", ".probe.4194305", "checkpoint.bin.prev.tmp", "effects.json"})
      write_text(small.path("run") + "/" + name, "half");
    CHECK(program(small.train("run", "4", {"--quiet"})).code == 0);
    for (const auto& entry : fs::directory_iterator(small.path("run")))
      CHECK_FALSE(entry.path().extension() == ".tmp");
    CHECK_FALSE(fs::exists(small.path("run") + "/.probe.4194305"));
    // A draft of a process that lives, and files that only look like one, are somebody's.
    const std::string living = small.path("run") + "/x." + std::to_string(::getpid()) + "-0.tmp",
                      mine = small.path("run") + "/notes.tmp";
    write_text(living, "living");
    write_text(mine, "mine");
    CHECK(program({"train", small.data, "--out", small.path("run"), "--resume", "--quiet"}).code == 0);
    CHECK(fs::exists(living));
    CHECK(fs::exists(mine));
  }

  TEST_CASE("F5: an output that leads round in a circle is found before the data is read") {
    const TempFolder temp;
    fs::create_symlink("b", temp.path() / "a");
    fs::create_symlink("a", temp.path() / "b");
    const Ended e = program({"train", "no/data", "--out", temp.str() + "/a"});
    CHECK(e.code == 2);
    CHECK(contains(e.err, temp.str() + "/a"));
    CHECK_FALSE(contains(e.err, "no/data"));
  }

  TEST_CASE("F7, F8: camera paths, reports and tables of points have limits too") {
    const Small small;
    REQUIRE(program(small.train("run", "4", {"--quiet"})).code == 0);
    const auto render = [&](const std::string& text) {
      write_text(small.path("path.json"), text);
      return program({"render", small.path("run"), "--out", small.path("pictures"), "--camera",
                      small.path("path.json")});
    };
    const std::string deep(200000, '[');
    for (const auto& [text, says] :
         {std::pair<std::string, const char*>{"{\"frames\": [" + deep + std::string(200000, ']') + "]}",
                                              "nested too deeply"},
          {"{\"frames\": " + deep, "nested too deeply"},
          {"{\"frames\": [], \"frames\": []}", "there twice"},
          {"{\"frames\": [{\"transform_matrix\": [[1e999]]}]}", "malformed JSON"},
          {"{\"w\": 1e300, \"frames\": [{\"transform_matrix\": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}]}",
           "not a picture's size"}}) {
      const Ended e = render(text);
      CAPTURE(e.err);
      CHECK(e.code == 2);
      CHECK(contains(e.err, says));
    }
    write_text(small.path("run") + "/metrics.json", "{\"a\": " + deep);
    CHECK(program({"report", small.path("run"), "--out", small.path("page.html")}).code == 2);
    write_text(small.path("points.csv"), "x,y,z\n");
    fs::resize_file(small.path("points.csv"), (std::uintmax_t(1) << 30) + 1);  // a hole: no disk is used
    const Ended points = program({"track", small.path("run"), "--points", small.path("points.csv"), "--to",
                                  "1", "--out", small.path("out.csv")});
    CHECK(points.code == 2);
    CHECK(contains(points.err, "too large"));
  }

  TEST_CASE("F11: a second signal ends the program at once") {
    Endless run;
    // Until one of them is the second: two that arrive together count as one.
    for (int i = 0; i < 500; ++i) {
      ::kill(run.started.process(), SIGINT);
      std::this_thread::sleep_for(std::chrono::microseconds(50));
    }
    CHECK(run.started.wait().code == 1);
  }

  TEST_CASE(
      "F11: a termination that a launcher passes on once more is one; so is a terminal that is closed") {
    for (const int signal : {SIGTERM, SIGHUP}) {
      CAPTURE(signal);
      Endless run;
      for (int i = 0; i < 3; ++i) {
        ::kill(run.started.process(), signal);
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
      CHECK(run.started.wait().code == 130);
      CHECK(program({"verify", run.small.path("run")}).code == 0);
    }
  }

  TEST_CASE("F3: where there is room for the model and none for the checkpoint, the model is saved") {
    const Small small;
    const Ended e = without_room(small, "10", {"--quiet"});
    CAPTURE(e.err);
    CHECK(e.code == 1);
    CHECK(contains(e.err, "checkpoint.bin: could not be written"));
    CHECK(slurp(small.path("run") + "/model.vdb") == slurp(small.path("whole") + "/model.vdb"));
    for (const auto& entry : fs::directory_iterator(small.path("run")))
      CHECK_FALSE(entry.path().extension() == ".tmp");
  }

  TEST_CASE("F3: a checkpoint on the way that finds no room does not end the training") {
    const Small small;
    // One stage: the first checkpoint, begun at the first step, is as large as the one at the end.
    const Ended e =
        without_room(small, "40",
                     {"--set", "run.checkpoint_every=0", "--set", "grid.radiance=16", "--set",
                      "grid.radiance_start=0", "--set", "grid.motion=8", "--set", "grid.motion_start=0"});
    CAPTURE(e.err);
    CHECK(e.code == 1);
    CHECK(contains(e.err, "training goes on"));
    CHECK(contains(e.err, "checkpoint.bin: could not be written"));
    CHECK(slurp(small.path("run") + "/model.vdb") == slurp(small.path("whole") + "/model.vdb"));
  }

  TEST_CASE("F2: effects that were listed are those of the run also where it begins afresh") {
    const Small small;
    REQUIRE(program(small.train("run", "4", {"--effects", "motion,presence", "--quiet"})).code == 0);
    for (const char* name : {"checkpoint.bin", "metrics.json", "model.vdb"})
      fs::remove(small.path("run") + "/" + name);  // killed before its first checkpoint
    const Ended e = program({"train", small.data, "--out", small.path("run"), "--resume"});
    CAPTURE(e.err);
    CHECK(e.code == 0);
    CHECK(contains(e.err, "starting afresh"));
    CHECK(contains(e.err, "what was asked for is used"));
    CHECK(contains(slurp(small.path("run") + "/config.toml"), "presence = true"));
  }

  TEST_CASE("F11: who asks to stop while effects are tried out gets no run") {
    const Small small;
    write_moving_ball(small.path("long"), {24, 0, 2, 12, 0.8});
    std::vector<std::string> words = small.train("run", "100000", {"--set", "effects.steps=400"});
    words[1] = small.path("long");
    words.insert(words.begin(), SPLINEVOX_PROGRAM);
    Started started(words);
    REQUIRE(comes([&] { return contains(started.err(), "trying out"); }));
    ::kill(started.process(), SIGINT);
    const Ended e = started.wait();
    CAPTURE(e.err);
    CHECK(e.code == 130);
    CHECK(contains(e.err, "interrupted before the first step; nothing is saved"));
    CHECK_FALSE(fs::exists(small.path("run")));
  }

  TEST_CASE("F12: with too little memory it ends with a message, and a later run goes on") {
#ifdef __SANITIZE_ADDRESS__
    MESSAGE("skipped: the address sanitizer wants terabytes of address space");
    return;
#endif
    const Small small;
    int ended = 0;
    for (const char* kilobytes : {"180000", "220000", "260000", "300000", "400000", "2000000"}) {
      const Ended e = shell(std::string("ulimit -v ") + kilobytes + "; exec",
                            small.train("run", "4", {"--quiet", "--resume"}));
      CAPTURE(kilobytes);
      CAPTURE(e.err);
      CHECK((e.code == 0 || e.code == 1 || e.code == 2));  // 2: known before it begins
      if (e.code > 0) CHECK(contains(e.err, "memory"));
      ended += e.code == 0;
    }
    CHECK(ended > 0);
    CHECK(ended < 6);  // the tightest limit is one
    CHECK(program({"verify", small.path("run")}).code == 0);
  }

  TEST_CASE("F13: of many that start at once one writes") {
    const Small small;
    std::vector<std::unique_ptr<Started>> all;
    for (int i = 0; i < 8; ++i) {
      std::vector<std::string> words = small.train("run", "20", {"--quiet"});
      words.insert(words.begin(), SPLINEVOX_PROGRAM);
      all.push_back(std::make_unique<Started>(words));
    }
    int done = 0, refused = 0;
    for (auto& started : all) {
      const Ended e = started->wait();
      done += e.code == 0;
      refused += e.code == 2;
    }
    CHECK(done == 1);
    CHECK(refused == 7);
    CHECK(program({"verify", small.path("run")}).code == 0);

    fs::create_directory(small.path("vdb"));
    const int folder = ::open(small.path("vdb").c_str(), O_RDONLY | O_DIRECTORY);
    REQUIRE(::flock(folder, LOCK_EX) == 0);
    const Ended busy = program({"export", small.path("run"), "--out", small.path("vdb"), "--frames", "1-2"});
    ::close(folder);
    CHECK(busy.code == 2);
    CHECK(contains(busy.err, "another process is writing into this folder"));
  }

  TEST_CASE("F16: a run is not resumed with data in which one pixel has changed") {
    const Small small;
    REQUIRE(program(small.train("run", "4", {"--quiet"})).code == 0);
    std::array<std::uint8_t, 4> colour = {200, 100, 50, 255};
    TinyPng picture = flat_png(12, 12, colour);
    write_png(small.data + "/train/r_3.png", picture);
    REQUIRE(program(small.train("other", "4", {"--quiet"})).code == 0);
    picture.rows[5] ^= 1;
    write_png(small.data + "/train/r_3.png", picture);
    const Ended e = program({"train", small.data, "--out", small.path("other"), "--resume"});
    CHECK(e.code == 2);
    CHECK(contains(e.err, "other training data"));
  }

  TEST_CASE("F18: a reader that went away and a full disk for the log do not stop training") {
    const Small small;
    const Ended gone = shell("", small.train("a", "400", {"--json"}), "| head -c 1 >/dev/null");
    CHECK(Json::parse(slurp(small.path("a") + "/metrics.json"))["finished"] == true);
    const Ended full = shell("", small.train("b", "50"), ">/dev/full 2>/dev/full");
    CHECK(full.code == 1);  // the summary at the end was lost
    CHECK(Json::parse(slurp(small.path("b") + "/metrics.json"))["finished"] == true);
    CHECK(shell("", {"info", small.path("b"), "--json"}, ">/dev/full").code == 1);
    CHECK(shell("", {"eval", small.path("b")}, ">/dev/full").code == 1);
    CHECK(contains(shell("", {"info", small.path("b"), "--json=true"}).out, "\"verb\":\"info\""));
    CHECK(shell("", {"info", small.path("b"), "--json=yes"}).code == 2);
    const Ended piped = shell("", {"train", "--list-settings"}, "| true");
    CHECK(piped.err.empty());
    CHECK(shell("", small.train("c", "10"), ">&- 2>&-").code == 0);
    CHECK(program({"verify", small.path("c")}).code == 0);
  }

  TEST_CASE("F21: many more threads than cores, and one core, give the same model") {
    const Small small;
    CHECK(program(small.train("many", "10", {"--quiet", "--threads", "300"})).code == 0);
    CHECK(shell("exec taskset -c 0", small.train("one", "10", {"--quiet"})).code == 0);
    CHECK(slurp(small.path("many") + "/model.vdb") == slurp(small.path("one") + "/model.vdb"));
  }

  TEST_CASE("five steps in a row that are not finite: the run stops as it was before them, with a replay") {
    const Small small;
    const Ended e =
        program(small.train("run", "60", {"--set", "loss.tv_color=1e30", "--set", "loss.tv_share=1"}));
    CAPTURE(e.err);
    CHECK(e.code == 1);
    CHECK(contains(e.err, "5 steps in a row were not finite"));
    CHECK(contains(e.err, "replay.json"));
    const Json replay = Json::parse(slurp(small.path("run") + "/replay.json"));
    CHECK(replay["discarded"].size() == 5);
    CHECK(replay["discarded"][0]["step"] == replay["step"].get<int>() + 1);
    CHECK(program({"verify", small.path("run")}).code == 0);
    // The same steps fail again: draws depend on seed and step alone.
    CHECK(program({"train", small.data, "--out", small.path("run"), "--resume", "--quiet"}).code == 1);
    CHECK(Json::parse(slurp(small.path("run") + "/replay.json"))["discarded"] == replay["discarded"]);
  }
}
