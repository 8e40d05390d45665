// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>
#include <sys/file.h>

#include "program.hpp"

using namespace splinevox::test;
namespace fs = std::filesystem;

TEST_SUITE("app/bad input") {
  TEST_CASE("help and version are no errors, and the help lists every verb") {
    const Ended help = program({"--help"});
    CHECK(help.code == 0);
    for (const char* verb :
         {"train", "eval", "render", "track", "export", "import", "info", "verify", "synth", "report"}) {
      CHECK(contains(help.out, verb));
      CHECK(program({verb, "--help"}).code == 0);
    }
    CHECK(contains(program({"train", "--help"}).out, "nerf_atlas"));
    CHECK(contains(program({"--version"}).out, "splinevox "));
    CHECK(program({}).code == 2);
    CHECK(contains(program({"help", "train"}).out, "nerf_atlas"));
    CHECK(contains(program({"help"}).out, "export"));
  }

  TEST_CASE("a misspelt verb, option, preset, setting or effect is answered with the nearest right one") {
    const TempFolder temp;
    const std::string run = temp.str() + "/run";
    struct Row {
      std::vector<std::string> words;
      const char* says;
      const char* suggests;
    };
    const std::vector<Row> rows = {
        {{"trian"}, "there is no verb 'trian'", "splinevox train"},
        {{"train", "data", "--out", run, "--preste", "fast"}, "there is no option --preste", "--preset"},
        {{"train", "data", "--out", run, "--steps", "60"}, "there is no option --steps", "--max-steps"},
        {{"train", "data", "--out", run, "--iterations", "60"}, "no option --iterations", "train --help"},
        {{"train", "data", "--out", run, "--effects", ","},
         "no effect is listed",
         "none, or a list of motion"},
        {{"data", "train"}, "there is no verb 'data'", "splinevox train data"},
        {{"train", "data", "--out", run, "--memory", "6"}, "this has no unit", "--memory 6G"},
        {{"train", "data", "--out", run, "--preset", "fats"}, "there is no preset 'fats'", "--preset fast"},
        {{"train", "data", "--out", run, "--set", "optimiser.lr_colour=1"},
         "there is no setting 'optimiser.lr_colour'",
         "optimiser.lr_color"},
        {{"train", "data", "--out", run, "--set", "motion.points=999"},
         "'motion.points' is out of range",
         "in [2, 256]"},
        {{"train", "data", "--out", run, "--effects", "glow"},
         "there is no effect 'glow'",
         "motion, rigidity, view"},
        {{"train", "data", "--out", run, "--effects", "rigidity"},
         "rigidity scales motion",
         "motion,rigidity"},
        {{"train", "data", "--out", run, "--preset", "nerf_atlas", "--effects", "presence"},
         "other settings rule presence out",
         "motion.first_point=free"},
        {{"train", "data", "--out", run, "--device", "tpu"}, "there is no such device", "auto, cpu or cuda"},
        {{"train", "data", "--out", run, "--background", "mauve"}, "'mauve' is not a number", "R,G,B"},
        {{"train", "data", "--out", run, "--background", "1,2,3"}, "this is not a colour", "R,G,B"},
        {{"train", "data", "--out", run, "--max-time", "-3"},
         "'run.max_time' is out of range",
         "a number in [0"},
        {{"train", "data", "--out", run, "--config", "nowhere.toml"},
         "no such configuration file",
         "a TOML file"},
        {{"train", "data", "--resume"}, "--out is missing", "splinevox train DATASET --out RUN"},
        {{"train", "data", "--out", run, "--threads", "-1"}, "--threads", ""},
        {{"synth", "dancre", "--out", run}, "dancre", "dancer"},
        {{"eval", run}, "there is no such run", "splinevox train --out"},
        {{"render", run, "--out", run, "--layers", "rgbb"}, "there is no layer 'rgbb'", "rgb"},
        {{"render", run, "--out", run, "--format", "gif"},
         "there is no such format",
         "png, exr, mp4 or cameras"},
        {{"render", run, "--out", run, "--share", "5/4"}, "this is not a share", "1/4 is the first of four"},
        {{"export", run, "--out", run, "--share", "half"}, "'half' is not a number", "K/N"},
        {{"render", run, "--out", run, "--format", "mp4", "--share", "1/2"},
         "a film is written by one process",
         "png or exr"},
        {{"info", run}, "there is nothing of that name", "a run, an export, a .vdb file or a data set"},
        {{"report", run, "--out", temp.str() + "/page.html"}, "there is no such run", ""},
    };
    for (const Row& row : rows) {
      const Ended e = program(row.words);
      CAPTURE(row.words.back());
      CAPTURE(e.err);
      CHECK(e.code == 2);
      CHECK(e.err.starts_with("splinevox"));
      CHECK(contains(e.err, row.says));
      CHECK(contains(e.err, row.suggests));
      CHECK_FALSE(contains(e.err, "terminate"));
    }
  }

  TEST_CASE("a data set that is missing or broken is named before training starts") {
    const TempFolder temp;
    const auto train = [&](const std::string& data) {
      return program(
          {"train", temp.str() + "/" + data, "--out", temp.str() + "/run_" + data, "--max-steps", "2"});
    };
    const Ended missing = train("nowhere");
    CHECK(missing.code == 2);
    CHECK(contains(missing.err, "nowhere: the data set does not exist"));
    CHECK_FALSE(fs::exists(temp.path() / "run_nowhere"));

    write_moving_ball(temp.path() / "json");
    write_text(temp.path() / "json/transforms_train.json", "{\"frames\": [");
    const Ended json = train("json");
    CHECK(json.code == 2);
    CHECK(contains(json.err, "json/transforms_train.json"));

    write_moving_ball(temp.path() / "picture");
    write_text(temp.path() / "picture/train/r_3.png", "not a picture");
    const Ended picture = train("picture");
    CHECK(picture.code == 2);
    CHECK(contains(picture.err, "r_3.png"));

    write_moving_ball(temp.path() / "time");
    std::string text = slurp(temp.path() / "time/transforms_train.json");
    text.replace(text.find("\"time\": 0"), 9, "\"time\": \"x\"");
    write_text(temp.path() / "time/transforms_train.json", text);
    const Ended time = train("time");
    CHECK(time.code == 2);
    CHECK(contains(time.err, "time"));
  }

  TEST_CASE("an output folder that cannot be written is found before the data is read") {
    const TempFolder temp;
    write_text(temp.path() / "file", "mine");
    for (const std::string& out :
         {temp.str() + "/file", temp.str() + "/file/run", std::string("/proc/none/run")}) {
      CAPTURE(out);
      const Ended e = program({"train", "no/data/at/all", "--out", out});
      CHECK(e.code == 2);
      CHECK(contains(e.err, out));
      CHECK_FALSE(contains(e.err, "no/data/at/all"));
    }
    CHECK(slurp(temp.path() / "file") == "mine");
    if (::geteuid() != 0) {
      fs::create_directory(temp.path() / "locked");
      fs::permissions(temp.path() / "locked", fs::perms::owner_read | fs::perms::owner_exec);
      CHECK(program({"train", "no/data", "--out", temp.str() + "/locked/run"}).code == 2);
    }
    CHECK(program({"synth", "ball", "--out", temp.str() + "/file/scene"}).code == 2);
    CHECK(program({"report", temp.str(), "--out", temp.str()}).code == 2);
  }

  TEST_CASE("a folder in use, or full of something else, is left alone") {
    const TempFolder temp;
    fs::create_directory(temp.path() / "other");
    write_text(temp.path() / "other/letter.txt", "dear");
    for (const bool resume : {false, true}) {
      std::vector<std::string> words = {"train", "no/data", "--out", temp.str() + "/other"};
      if (resume) words.push_back("--resume");
      const Ended e = program(words);
      CHECK(e.code == 2);
      CHECK(contains(e.err, "this folder is not empty and holds no run"));
    }
    CHECK(slurp(temp.path() / "other/letter.txt") == "dear");

    fs::create_directory(temp.path() / "busy");
    const int folder = ::open((temp.str() + "/busy").c_str(), O_RDONLY | O_DIRECTORY);
    REQUIRE(::flock(folder, LOCK_EX) == 0);
    const Ended busy = program({"train", "no/data", "--out", temp.str() + "/busy"});
    ::close(folder);
    CHECK(busy.code == 2);
    CHECK(contains(busy.err, "another process is training into this folder"));
  }
}
