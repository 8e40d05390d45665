// SPDX-License-Identifier: Apache-2.0
// What a stranger may do: runs, exports and data sets that come from somebody else neither write nor read
// elsewhere, and their texts are texts. docs/reliability.md, kind 11.
#include <doctest/doctest.h>
#include <sys/stat.h>

#include <algorithm>

#include "ball_scene.hpp"
#include "report/page.hpp"
#include "run/support.hpp"
#include "run/sweep/sweep.hpp"
#include "splinevox/core/error.hpp"
#include "view/page.hpp"

using namespace splinevox::test;
namespace fs = std::filesystem;
using run::Json;

namespace {

/// A small run, something of the user's beside it, and what a link may do to it.
struct Home : SmallRun {
  std::string precious = path("bashrc");
  Home() { write_text(precious, "alias ls=ls\n"); }
  /// Puts a link in place of a file or folder.
  void link(const std::string& at, const std::string& to) const {
    fs::remove_all(at);
    fs::create_symlink(to, at);
  }
  void check_untouched() const { CHECK(slurp(precious) == "alias ls=ls\n"); }
};

const char* const kClearScreen = "\x1b[2J\xe2\x80\xae";

}  // namespace

TEST_SUITE("app/stranger") {
  TEST_CASE("no file of a run may be a link out of it, for any verb; the message names it") {
    const Home home;
    const std::string kept = home.path("kept"), out = home.path("out");
    fs::rename(home.run, kept);
    for (const char* name : {"metrics.jsonl", "metrics.json", "model.vdb", "checkpoint.bin",
                             "checkpoint.bin.prev", "config.toml", "effects.json", "manifest.json",
                             "edit.json", "preview", "preview/x.png", "replay.json", "asked.toml"}) {
      fs::remove_all(home.run);
      fs::copy(kept, home.run, fs::copy_options::recursive);
      const bool folder = std::string(name) == "preview";
      home.link(home.run + "/" + name, folder ? home.temp.str() : home.precious);
      const std::vector<std::vector<std::string>> all = {
          {"train", home.data, "--out", home.run, "--resume", "--quiet"},
          {"eval", home.run},
          {"render", home.run, "--out", out, "--times", "0:1:2", "--size", "8"},
          {"edit", home.run, "--out", out, "--reverse"},
          {"export", home.run, "--out", out, "--frames", "1-1"},
          {"report", home.run, "--out", home.path("page.html")},
          {"view", home.run, "--out", home.path("page.html")},
          {"info", home.run}};
      for (const std::vector<std::string>& words : all) {
        const Ended e = program(words);
        CAPTURE(name);
        CAPTURE(words[0]);
        CAPTURE(e.err);
        CHECK(e.code == 2);
        CHECK(contains(e.err, "is a link that leads out of its folder"));
        CHECK(contains(e.err, name));
      }
      CHECK(fs::is_symlink(home.run + "/" + name));
      home.check_untouched();
    }
    CHECK_FALSE(fs::exists(out + "/config.toml"));
  }

  TEST_CASE("a pipe among the files of a run is refused and not waited for") {
    const Home home;
    fs::remove(home.run + "/metrics.json");
    REQUIRE(::mkfifo((home.run + "/metrics.json").c_str(), 0600) == 0);
    for (const char* verb : {"info", "eval"}) {
      const Ended e = program({verb, home.run});
      CHECK(e.code == 2);
      CHECK(contains(e.err, "neither a file nor a folder"));
    }
    CHECK(program({"verify", home.run}).code == 0);  // it is not in the list
  }

  TEST_CASE(
      "an output folder whose entries are links is refused; one that is a link itself is the user's own") {
    const Home home;
    const std::string out = home.path("out"), disk = home.path("disk");
    const std::vector<std::pair<std::vector<std::string>, std::vector<std::string>>> all = {
        {{"export", home.run, "--frames", "1-1", "--quiet"},
         {"frame_0001.vdb", "load_in_blender.py", "manifest.json", "manifest.partial.json"}},
        {{"render", home.run, "--times", "0:1:2", "--size", "8", "--quiet"}, {"rgb_0001.png"}},
        {{"edit", home.run, "--reverse", "--quiet"}, {"model.vdb"}},
        {home.train("run", {"--max-steps", "2"}), {"metrics.jsonl", "preview", "config.toml"}}};
    for (auto [words, files] : all) {
      if (const auto at = std::find(words.begin(), words.end(), "--out"); at != words.end())
        words.erase(at, at + 2);
      words.insert(words.end(), {"--out", out});
      for (const std::string& name : files) {
        fs::remove_all(out);
        fs::create_directories(out);
        fs::create_symlink(home.precious, out + "/" + name);
        const Ended e = program(words);
        CAPTURE(words[0]);
        CAPTURE(name);
        CAPTURE(e.err);
        CHECK(e.code == 2);
        CHECK(contains(e.err, "link"));
        home.check_untouched();
      }
      fs::remove_all(out);
      fs::remove_all(disk);
      fs::create_directories(disk);
      fs::create_directory_symlink(disk, out);
      const Ended e = program(words);
      CAPTURE(e.err);
      CHECK(e.code == 0);
      CHECK(fs::is_symlink(out));
      CHECK_FALSE(fs::is_empty(disk));
    }
  }

  TEST_CASE("the name of a picture runs nothing and goes nowhere") {
    const Home home;
    std::string text = slurp(home.data + "/transforms_test.json");
    const std::string evil = "$(touch pwned);..|`id`";
    const std::string mark = "./test/r_0";
    REQUIRE(text.find(mark) != text.npos);
    text.replace(text.find(mark), mark.size(), "./test/" + evil);
    write_text(home.data + "/transforms_test.json", text);
    fs::rename(home.data + "/test/r_0.png", home.data + "/test/" + evil + ".png");
    const Ended e = program({"eval", home.run, "--images", home.path("pictures")});
    CAPTURE(e.err);
    CHECK(e.code == 0);
    CHECK(fs::exists(home.path("pictures") + "/__touch pwned__..__id_.png"));
    CHECK(contains(slurp(home.run + "/metrics.json"), "__touch pwned__..__id_"));
    CHECK(program({"convert", home.data, "--out", home.path("converted"), "--quiet"}).code == 0);
    for (const auto& entry : fs::recursive_directory_iterator(home.path("converted")))
      CHECK(entry.path().filename().string().find_first_of("$();|`&'\"\n") == std::string::npos);
  }

  TEST_CASE("texts of a run do not reach the terminal as commands") {
    const Home home;
    std::string config = slurp(home.run + "/config.toml");
    const std::string key = "\ndataset = \"";
    REQUIRE(config.find(key) != config.npos);
    config.insert(config.find(key) + key.size(), "\\u001b[2J\\u202e\\n");
    write_text(home.run + "/config.toml", config);
    Json metrics = Json::parse(slurp(home.run + "/metrics.json"));
    metrics["device"] = kClearScreen;
    metrics["split"] = kClearScreen;
    metrics["psnr"] = 1;
    write_text(home.run + "/metrics.json", metrics.dump());
    write_text(
        home.run + "/edit.json",
        Json({{"history", {{{"from", std::string("a\n") + kClearScreen}, {"operations", Json::array()}}}}})
            .dump());
    for (const char* json : {"", "--json"}) {
      std::vector<std::string> words = {"info", home.run};
      if (*json) words.push_back(json);
      const Ended e = program(words);
      CAPTURE(e.err);
      CHECK(e.code == 0);
      CHECK_FALSE(contains(e.out, "\x1b"));
      CHECK_FALSE(contains(e.out, "\xe2\x80\xae"));
    }
    const Ended eval = program({"eval", home.run});  // its data set's name is in the message
    CHECK(eval.code == 2);
    CHECK_FALSE(contains(eval.err, "\x1b"));
    const Ended none = program({"info", home.path(std::string("x\n") + kClearScreen)});
    CHECK(none.code == 2);
    CHECK_FALSE(contains(none.err, "\x1b"));
    CHECK(contains(none.err, "x\\x0a\\x1b[2J\\u202e"));
  }

  TEST_CASE("texts of a run are texts in its pages: no element, no mark to be filled in") {
    const std::string script = "<script>alert(1)</script>'\"&", marks = "/*scripts*/<!--data--><!--header-->";
    splinevox::run::ReportRun run;
    run.name = script;
    run.config = script;
    run.views_note = script;
    run.model_file = "model.vdb";
    run.metrics = {
        {"split", script},           {"device", script},
        {"preset", script},          {"psnr", 1.0},
        {"phases", {{script, 1.0}}}, {"frames", {{{"name", script}, {"psnr", 1.0}, {"time", 0.5}}}}};
    run.effects = {{"note", script},
                   {"effects", {{{"effect", script}, {"used", true}, {"decision", script}}}}};
    for (const std::vector<splinevox::run::ReportRun>& runs : {std::vector{run}, std::vector{run, run}}) {
      const std::string page = splinevox::run::report_page(runs);
      CHECK_FALSE(contains(page, "<script>alert"));
      CHECK_FALSE(contains(page, "script>'\""));
      CHECK(contains(page, "&lt;script&gt;alert(1)&lt;/script&gt;&#39;&quot;&amp;"));
    }
    run.metrics["split"] = 7;  // of another kind than expected
    run.metrics["device"] = Json::array();
    CHECK(splinevox::run::report_page({run}).size() > 1000);

    splinevox::run::ViewPage view;
    view.name = marks;
    view.about = marks + script;
    view.note = marks + script;
    view.shots.push_back({marks + script, {}, 0.5, {}});
    const std::string page = splinevox::run::view_page(view, {});
    const auto count = [&](const std::string& part) {
      int n = 0;
      for (std::size_t at = page.find(part); at != page.npos; at = page.find(part, at + 1)) ++n;
      return n;
    };
    CHECK(count("id=\"header\"") == 1);
    CHECK(count("id=\"data\"") == 1);
    CHECK(contains(page, "<title>splinevox: /*scripts*/&lt;"));  // nothing was put in there
    CHECK_FALSE(contains(page, "<script>alert"));
    CHECK_FALSE(contains(page, "<!--data-->"));
  }

  TEST_CASE("a sweep's words are looked at before they go into paths, scripts and tables") {
    using namespace splinevox;
    using namespace splinevox::run;
    const TempFolder folder;
    const std::string path = folder.str() + "/sweep.toml";
    struct Row {
      const char *text, *says;
    };
    for (const Row& row : {Row{"datasets = [\"a\"]\npresets = [\"../../evil\"]\n", "there is no preset"},
                           {"datasets = [\"a\"]\nseeds = [\"../1\"]\n", "'seeds' has one that is no seed"},
                           {"datasets = [\"a\"]\nseeds = [-1]\n", "'seeds' has one that is no seed"},
                           {"datasets = [\"a\"]\nseeds = [\"1; rm\"]\n", "'seeds' has one that is no seed"},
                           {"datasets = [\"--out=x\"]\n", "would be an option"},
                           {"datasets = [\"a\\nb\"]\n", "control characters"},
                           {"datasets = [\"a\"]\ntrain = [\"a\\nb\"]\n", "control characters"},
                           {"datasets = [\"a\"]\n[settings]\n\"x\\ny\" = []\n", "control characters"}}) {
      write_text(path, row.text);
      CHECK_THROWS_WITH_AS(read_sweep(path, "out"), doctest::Contains(row.says), Error);
    }
    write_text(
        path,
        "datasets = [\"=cmd|x\", \"@a,b\", \"+\\\"q\\\"\", \"d|e\"]\n[settings]\n\"-2\" = []\n\"-x\" = []\n");
    CHECK_THROWS_AS(read_sweep(path, "out\n#SBATCH --x"), Error);
    const std::vector<SweepTask> tasks = read_sweep(path, folder.str() + "/out");
    const std::string text = csv(tasks_table(tasks));
    CHECK(contains(text, ",'=cmd|x,fast,"));
    CHECK(contains(text, ",\"'@a,b\",fast,"));
    CHECK(contains(text, ",\"'+\"\"q\"\"\",fast,"));
    CHECK(contains(text, ",fast,-2,1,"));
    CHECK(contains(text, ",fast,'-x,1,"));
    CHECK(contains(markdown(settings_table(tasks)), "| d\\|e | fast |"));
    for (const char* out : {"a\"b", "a%j", "a\\b", "a\n#SBATCH --uid=0"})
      CHECK_THROWS_WITH_AS(slurm_script(path, folder.str() + "/" + out, 2, 1),
                           doctest::Contains("cannot stand in a script"), Error);
    CHECK(contains(slurm_script(path, folder.str() + "/my runs", 2, 1), "/my runs/slurm_%a.log\"\n"));
  }

  TEST_CASE("a film's draft is no name that can be waited for, and a film is not written through a link") {
    if (Started({"ffmpeg", "-version"}).wait().code != 0) {
      MESSAGE("skipped: there is no ffmpeg");
      return;
    }
    const Home home;
    const std::string out = home.path("film");
    fs::create_directories(out);
    const std::vector<std::string> words = {"render", home.run, "--out",    out,   "--times", "0:1:5",
                                            "--size", "16",     "--format", "mp4", "--quiet"};
    const Ended e = program(words);
    CAPTURE(e.err);
    CHECK(e.code == 0);
    REQUIRE(fs::exists(out + "/rgb.mp4"));
    CHECK(std::distance(fs::directory_iterator(out), {}) == 2);  // and render.json
    home.link(out + "/rgb.mp4", home.precious);
    CHECK(program(words).code == 2);
    home.check_untouched();
  }
}
