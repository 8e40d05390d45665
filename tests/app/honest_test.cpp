// SPDX-License-Identifier: Apache-2.0
// Success is said where there is success, and nobody's work is lost. docs/reliability.md, kind 12.
#include <doctest/doctest.h>
#include <sys/file.h>
#include <sys/stat.h>

#include <map>

#include "ball_scene.hpp"
#include "run/support.hpp"
#include "splinevox/core/error.hpp"

using namespace splinevox::test;
namespace fs = std::filesystem;
using run::Json;

namespace {

/// A regular file, by its kind, that cannot be read even by root.
constexpr const char* kUnreadable = "/proc/self/mem";

}  // namespace

TEST_SUITE("app/honest") {
  TEST_CASE("a film that the disk did not take whole is an error and leaves nothing") {
    if (Started({"ffmpeg", "-version"}).wait().code != 0) {
      MESSAGE("skipped: there is no ffmpeg");
      return;
    }
    const SmallRun home;
    const auto film = [&](const std::string& limit) {
      fs::remove_all(home.path("film"));
      return Started({"sh", "-c",
                      limit + "exec '" SPLINEVOX_PROGRAM "' render '" + home.run + "' --out '" +
                          home.path("film") +
                          "' --times 0:1:30 --size 320 --layers depth --format mp4 --quiet"})
          .wait();
    };
    const Ended good = film("");
    CAPTURE(good.err);
    REQUIRE(good.code == 0);
    const auto size = fs::file_size(home.path("film") + "/depth.mp4");
    REQUIRE(size > 10 * 512);
    int failed = 0;
    for (std::uintmax_t blocks = 9; blocks * 512 < size;
         blocks += std::max<std::uintmax_t>(1, size / 512 / 6)) {
      const Ended e = film("ulimit -f " + std::to_string(blocks) + "; ");
      CAPTURE(blocks);
      CAPTURE(e.err);
      CHECK(e.code == 1);
      CHECK(std::distance(fs::directory_iterator(home.path("film")), {}) == 1);  // render.json
      ++failed;
    }
    CHECK(failed > 0);
  }

  TEST_CASE("a configuration that cannot be read is an error, and so is one within a run") {
    const SmallRun home;
    for (const char* file : {kUnreadable, "/dev/null/x", "/"}) {
      const Ended e = program(home.train("other", {"--max-steps", "2", "--config", file}));
      CAPTURE(file);
      CAPTURE(e.err);
      CHECK(e.code == 2);
      CHECK_FALSE(fs::exists(home.path("other") + "/model.vdb"));
    }
  }

  TEST_CASE("texts of a run come whole or not at all; only one that is not there is empty") {
    using namespace splinevox;
    CHECK_THROWS_AS(run::read_text_if_there(kUnreadable), Error);
    CHECK_THROWS_AS(run::read_text("/nowhere/metrics.jsonl"), Error);
    CHECK(run::read_text_if_there("/nowhere/metrics.jsonl").empty());
    // `--resume` cuts the lines that it has read: those of a file that it cannot read would be lost.
    const SmallRun home;
    fs::remove(home.run + "/metrics.json");
    fs::remove(home.run + "/metrics.jsonl");
    fs::create_directory(home.run + "/metrics.jsonl");
    const Ended e = program({"train", home.data, "--out", home.run, "--resume", "--quiet"});
    CAPTURE(e.err);
    CHECK(e.code == 2);
    CHECK(contains(e.err, "metrics.jsonl: could not be read"));
  }

  TEST_CASE("a run cannot lead to more grids than its readers take, and says so before it trains") {
    const SmallRun home;
    const Ended e = program(home.train("other", {"--max-steps", "2", "--effects", "all", "--set",
                                                 "motion.points=140", "--set", "motion.halve_start="}));
    CAPTURE(e.err);
    CHECK(e.code == 2);
    CHECK(contains(e.err, "leads to more grids than a model file may have"));
    CHECK_FALSE(fs::exists(home.path("other")));
  }

  TEST_CASE("eval never writes its pictures among files that are not its own") {
    const SmallRun home;
    const auto before = files_of(home.data);
    for (const char* name : {"test", "train", ""}) {
      const Ended e = program({"eval", home.run, "--images", home.data + "/" + name});
      CAPTURE(e.err);
      CHECK(e.code == 2);
      CHECK(contains(e.err, "did not write"));
    }
    CHECK(program({"eval", home.run, "--images", home.run}).code == 2);
    CHECK(files_of(home.data) == before);
    fs::create_directories(home.path("pictures"));
    for (int i = 0; i < 2; ++i)
      CHECK(program({"eval", home.run, "--images", home.path("pictures")}).code == 0);
    CHECK(program({"eval", home.run, "--images", home.run + "/eval"}).code == 0);
    CHECK(fs::exists(home.run + "/eval/r_0.png"));
  }

  TEST_CASE("a page or a table replaces only what is one") {
    const SmallRun home;
    write_text(home.path("points.csv"), "x,y,z\n0,0,0\n");
    for (const std::string& theirs :
         {home.run + "/model.vdb", home.run + "/config.toml", home.run + "/metrics.json",
          home.data + "/transforms_train.json", home.data + "/train/r_0.png", home.path("points.csv")}) {
      CAPTURE(theirs);
      const std::string bytes = slurp(theirs);
      for (const Ended& e :
           {program({"view", home.run, "--out", theirs}), program({"report", home.run, "--out", theirs}),
            program(
                {"track", home.run, "--points", home.path("points.csv"), "--to", "1", "--out", theirs})}) {
        CHECK(e.code == 2);
        CHECK(contains(e.err, "no earlier output of this command"));
      }
      CHECK(slurp(theirs) == bytes);
    }
    for (const char* name : {"page.html", "report.html"})
      write_text(home.path(name), "");  // as mktemp makes it
    for (int i = 0; i < 2; ++i) {
      CHECK(program({"view", home.run, "--out", home.path("page.html")}).code == 0);
      CHECK(program({"report", home.run, "--out", home.path("report.html")}).code == 0);
      for (const char* name : {"tracks.csv", "tracks.json"})
        CHECK(program({"track", home.run, "--points", home.path("points.csv"), "--to", "0,1", "--out",
                       home.path(name), "--quiet"})
                  .code == 0);
    }
    CHECK(program({"report", home.run, "--out", "/dev/null"}).code == 0);
  }

  TEST_CASE("eval prints its figures and then says that it could not keep them") {
    const SmallRun home;
    REQUIRE(program(home.train("other", {"--max-steps", "8"})).code == 0);
    const std::string metrics = slurp(home.run + "/metrics.json");
    // Somebody trains on.
    const int folder = ::open(home.run.c_str(), O_RDONLY | O_DIRECTORY);
    REQUIRE(::flock(folder, LOCK_EX) == 0);
    const Ended busy = program({"eval", home.run});
    ::close(folder);
    CHECK(busy.code == 1);
    CHECK(contains(busy.out, "mean"));
    CHECK(contains(busy.err, "the figures are not kept"));
    CHECK(slurp(home.run + "/metrics.json") == metrics);
    // A place that does not take the file.
    fs::create_directory(home.run + "/metrics_val.json");
    const Ended full = program({"eval", home.run, "--split", "val", "--json"});
    CHECK(full.code == 1);
    CHECK(Json::parse(full.out.substr(0, full.out.find('\n')))["split"] == "val");  // then comes the error
    CHECK(contains(full.err, "could not be written"));
  }

  TEST_CASE("eval of a model that was replaced meanwhile leaves the new model's figures alone") {
    const SmallRun home;
    REQUIRE(program(home.train("other", {"--max-steps", "8"})).code == 0);
    // A figure of another program is asked for when the model has been read, and holds it there.
    const std::string here = home.path("here"), go = home.path("go"), script = home.path("hold.sh");
    write_text(script, "touch '" + here + "'\nwhile [ -e '" + here + "' ] && [ ! -e '" + go +
                           "' ]; do sleep 0.02; done\necho 1\n");
    Started eval({SPLINEVOX_PROGRAM, "eval", home.run, "--metric", "hold=sh '" + script + "'"});
    REQUIRE(comes([&] { return fs::exists(here); }));
    const std::string metrics = slurp(home.run + "/metrics.json");
    fs::copy_file(home.path("other") + "/model.vdb", home.run + "/new.vdb");
    fs::rename(home.run + "/new.vdb", home.run + "/model.vdb");
    write_text(go, "");
    const Ended e = eval.wait();
    CAPTURE(e.err);
    CHECK(e.code == 1);
    CHECK(contains(e.err, "another model.vdb has taken its place"));
    CHECK(slurp(home.run + "/metrics.json") == metrics);
  }

  TEST_CASE("numbers that are none are refused where they are read, and never saved") {
    const SmallRun home;
    const std::string config = slurp(home.run + "/config.toml");
    for (const char* value : {"nan", "inf", "-inf", "\"1\""}) {
      std::string changed = config;
      const std::size_t at = changed.find("time_scale = ") + 13;
      changed.replace(at, changed.find('\n', at) - at, value);
      write_text(home.run + "/config.toml", changed);
      const Ended e = program({"eval", home.run});
      CAPTURE(value);
      CHECK(e.code == 2);
      CHECK(contains(e.err, "time_scale"));
    }
    write_text(home.run + "/config.toml", config);
    for (const char* factor : {"nan", "inf", "1e999", "-inf"})
      CHECK(program({"edit", home.run, "--out", home.path("edited"), "--scale-motion", factor}).code == 2);
    std::vector<std::string> words = {"edit", home.run, "--out", home.path("edited"), "--quiet"};
    for (int i = 0; i < 30; ++i) words.insert(words.end(), {"--scale-motion", "100"});
    const Ended e = program(words);
    CAPTURE(e.err);
    CHECK(e.code == 1);
    CHECK(contains(e.err, "not finite"));
    CHECK_FALSE(fs::exists(home.path("edited")));
  }

  TEST_CASE("training that ends in numbers that are none says so, and its checkpoint stays") {
    const SmallRun home;
    const Ended e = program(home.train("nan", {"--max-steps", "600", "--set", "loss.offset=1e30"}));
    CAPTURE(e.err);
    CHECK(e.code == 1);
    CHECK(contains(e.err, "not finite"));
    CHECK(fs::exists(home.path("nan") + "/checkpoint.bin"));
  }

  TEST_CASE("verify reads what it calls whole") {
    const SmallRun home;
    CHECK(program({"verify", home.run}).code == 0);
    Json manifest = Json::parse(slurp(home.run + "/manifest.json"));
    // A run that was written with half a configuration: size and hash are those of the half.
    std::string text = slurp(home.run + "/config.toml");
    write_text(home.run + "/config.toml", text.substr(0, text.find("[record]")));
    const Ended changed = program({"verify", home.run});
    CHECK(changed.code == 2);
    for (Json& file : manifest["files"])
      if (file["name"] == "config.toml") file["size"] = fs::file_size(home.run + "/config.toml");
    write_text(home.run + "/manifest.json", manifest.dump());
    const std::string out = program({"verify", home.run}).out;
    const std::string hash = out.substr(out.find("has hash ") + 9, 22);
    for (Json& file : manifest["files"])
      if (file["name"] == "config.toml") file["hash"] = hash;
    write_text(home.run + "/manifest.json", manifest.dump());
    const Ended half = program({"verify", home.run});
    CAPTURE(half.out);
    CHECK(half.code == 2);
    CHECK(contains(half.out, "BAD  config.toml: [record] has no"));
    manifest["files"] = Json::array();
    write_text(home.run + "/manifest.json", manifest.dump());
    const Ended empty = program({"verify", home.run});
    CHECK(empty.code == 2);
    CHECK(contains(empty.err, "lists no files"));
  }
}
