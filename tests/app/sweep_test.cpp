// SPDX-License-Identifier: Apache-2.0
#include "run/sweep/sweep.hpp"

#include <doctest/doctest.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <iterator>

#include "app/ball_scene.hpp"
#include "splinevox/core/error.hpp"

using namespace splinevox;
using namespace splinevox::run;
using namespace splinevox::test;

namespace {

/// A small sweep: two settings and two seeds of one scene.
std::string describe_small(const TempFolder& folder) {
  return describe_sweep(
      folder,
      "seeds = [1, 7]\n"
      "train = [\"--max-steps\", \"20\", \"--effects\", \"all\", \"--set\", \"sampling.rays=256\",\n"
      "\"--set\", \"grid.radiance=8,12,16\", \"--set\", \"motion.points=4\",\n"
      "\"--set\", \"grid.motion=4,8\", \"--set\", \"grid.motion_start=0,0.2\"]\n"
      "[settings]\nplain = []\nsmooth = [\"loss.tv_control=0.5\", \"loss.tv_density=0.01\"]\n");
}

}  // namespace

TEST_SUITE("app/sweep") {
  TEST_CASE("every combination is a task with a folder of its own") {
    const TempFolder folder;
    const std::vector<SweepTask> tasks = read_sweep(describe_small(folder), "out");
    REQUIRE(tasks.size() == 4);
    CHECK(tasks[0].name == "ball_draft_plain_s1");
    CHECK(tasks[3].name == "ball_draft_smooth_s7");
    CHECK(fmt::format("{}", fmt::join(tasks[3].train, "|")) ==
          "train|" + folder.str() +
              "/ball|--out|out/ball_draft_smooth_s7|--preset|draft|--seed|7|--resume|--set|"
              "loss.tv_control=0.5|--set|loss.tv_density=0.01|--max-steps|20|--effects|all|--set|"
              "sampling.rays=256|--set|grid.radiance=8,12,16|--set|motion.points=4|--set|grid.motion=4,8|"
              "--set|grid.motion_start=0,0.2");
    CHECK(contains(csv(tasks_table(tasks)),
                   "ball_draft_plain_s7," + folder.str() + "/ball,draft,plain,7,,,,,,,,,\n"));
    CHECK(contains(markdown(settings_table(tasks)), "| draft | smooth | 0 of 2 |"));
    CHECK(sweep_commands(tasks).starts_with(
        "splinevox train " + folder.str() +
        "/ball --out out/ball_draft_plain_s1 --preset draft --seed 1 --resume --max-steps 20 "));
    SweepTask spaced = tasks[0];
    spaced.run = "my run's";
    CHECK(sweep_commands({spaced}).ends_with(" && splinevox eval 'my run'\\''s'\n"));
    const std::string script = slurm_script(folder.str() + "/sweep.toml", "out", 4, 2);
    CHECK(script.find("#SBATCH --array=0-3\n") != std::string::npos);
    CHECK(script.find("--task \"$SLURM_ARRAY_TASK_ID\"") != std::string::npos);
  }

  TEST_CASE("a setting's own value counts, and not that which every training gets") {
    const TempFolder folder;
    const std::vector<SweepTask> tasks = read_sweep(
        describe_sweep(
            folder,
            "seeds = [1]\n"
            "train = [\"--set\", \"loss.tv_control=0.1\", \"--set=loss.tv_density=0.2\"]\n"
            "[settings]\nplain = []\nsmooth = [\"loss.tv_control=0.9\", \"loss.tv_density=0.3\"]\n"),
        "out");
    REQUIRE(tasks.size() == 2);
    const auto end_of = [](const SweepTask& t) {
      const auto from = std::find(t.train.begin(), t.train.end(), "--resume") + 1;
      return fmt::format("{}", fmt::join(from, t.train.end(), " "));
    };
    CHECK(end_of(tasks[0]) == "--set loss.tv_control=0.1 --set=loss.tv_density=0.2");
    CHECK(end_of(tasks[1]) == "--set loss.tv_control=0.9 --set loss.tv_density=0.3");
  }

  TEST_CASE("a folder that no script for Slurm can name is good enough without one") {
    const TempFolder folder;
    const std::string description = describe_small(folder), out = folder.str() + "/50%";
    const Ended table = program({"sweep", description, "--out", out, "--table"});
    CAPTURE(table.err);
    CHECK(table.code == 0);
    CHECK(contains(table.err, "no script for Slurm"));
    CHECK(std::filesystem::exists(out + "/table.md"));
    CHECK_FALSE(std::filesystem::exists(out + "/array.sh"));
    CHECK(program({"sweep", description, "--out", out, "--list"}).code == 2);
  }

  TEST_CASE("a table is the same in every form, whatever its cells hold") {
    const Table table{{{"name", "name", false}, {"psnr", "PSNR", true}},
                      {{"a|b, 50%_x \\", "31.5 ± 0.2"}, {"=1+1", "-2"}}};
    CHECK(csv(table) == "name,psnr\n\"a|b, 50%_x \\\",31.5 ± 0.2\n'=1+1,-2\n");
    CHECK(markdown(table) ==
          "| name | PSNR |\n| --- | ---: |\n| a\\|b, 50%_x \\\\ | 31.5 ± 0.2 |\n| =1+1 | -2 |\n");
    CHECK(latex(table) ==
          "\\begin{tabular}{lr}\n\\hline\nname & PSNR \\\\\n\\hline\n"
          "a$|$b, 50\\%\\_x \\textbackslash{} & 31.5 $\\pm$ 0.2 \\\\\n=1+1 & -2 "
          "\\\\\n\\hline\n\\end{tabular}\n");
  }

  TEST_CASE("what is wrong with a description is named") {
    const TempFolder folder;
    const std::string path = folder.str() + "/sweep.toml";
    struct Row {
      const char *text, *says;
    };
    for (const Row& row :
         {Row{"", "there are no datasets"},
          {"datasets = \"a\"\n", "'datasets' is not a list"},
          {"datasets = [\"a\"]\nseed = [1]\n", "there is no 'seed' in a sweep"},
          {"datasets = [\"a/x\", \"b/x\"]\n", "two tasks would have the same folder"},
          {"datasets = [\n\n\"a\"", "line"},
          {"datasets = [\"a\"]\n[settings]\nx = \"loss.tv_control=1\"\n", "'settings.x' is not a list"},
          {"datasets = [\"a\"]\nseeds = [1.5]\n", "'seeds' is not a list"}}) {
      write_text(path, row.text);
      CHECK_THROWS_WITH_AS(read_sweep(path, "out"), doctest::Contains(row.says), Error);
    }
    CHECK_THROWS_WITH_AS(read_sweep(folder.str() + "/none.toml", "out"),
                         doctest::Contains("there is no such configuration file"), Error);
  }

  TEST_CASE("a sweep replaces its own lists and tables, and nobody else's files of their names") {
    const TempFolder folder;
    const std::string description = describe_small(folder), out = folder.str() + "/paper";
    const auto sweep = [&](const char* how) { return program({"sweep", description, "--out", out, how}); };
    for (const std::string name :
         {"tasks.txt", "array.sh", "table.csv", "settings.csv", "table.md", "table.tex"}) {
      std::filesystem::remove_all(out);
      write_text(out + "/" + name, "splinevox of mine\n");
      for (const char* how : {"--list", "--table", "--quiet"}) {
        const Ended e = sweep(how);
        CAPTURE(name);
        CAPTURE(e.err);
        CHECK(e.code == 2);
        CHECK(contains(e.err, out + "/" + name + ": `sweep` did not write this file"));
        CHECK(contains(e.err, "another folder for --out"));
      }
      CHECK(slurp(out + "/" + name) == "splinevox of mine\n");
      const std::filesystem::directory_iterator files(out);
      CHECK(std::distance(begin(files), end(files)) == 1);
    }
    std::filesystem::remove_all(out);
    write_text(out + "/paper.tex", "mine");  // beside files of other names it is at home
    CHECK(sweep("--list").code == 0);
    CHECK(sweep("--table").code == 0);
    CHECK(sweep("--list").code == 0);
    CHECK(slurp(out + "/paper.tex") == "mine");
    // A sweep that an older version began has no mark, but its script for Slurm, to which a cluster's own
    // lines may have been added.
    std::string script = slurp(out + "/array.sh");
    CHECK(is_slurm_script(script));
    script.insert(script.find("#SBATCH --array"), "#SBATCH --partition=gpu\n");
    write_text(out + "/array.sh", script);
    CHECK_FALSE(is_slurm_script("#!/bin/bash\n#SBATCH --job-name=splinevox\n#SBATCH --array=0-3\n./mine\n"));
    std::filesystem::remove(out + "/sweep.json");
    CHECK(sweep("--table").code == 0);
    CHECK(contains(slurp(out + "/sweep.json"), "splinevox sweep"));
    // A file of the mark's name that is none.
    write_text(out + "/sweep.json", "{\"format\": \"mine\"}");
    const Ended e = sweep("--table");
    CHECK(e.code == 2);
    CHECK(contains(e.err, "/sweep.json: `sweep` did not write this file"));
    CHECK(slurp(out + "/sweep.json") == "{\"format\": \"mine\"}");
  }

  TEST_CASE("a pool trains and evaluates all; again, nothing is done twice; what is missing is made up for") {
    const TempFolder folder;
    const std::string description = describe_small(folder), out = folder.str() + "/out";
    const Ended first = program({"sweep", description, "--out", out, "--jobs", "2", "--threads", "1"});
    CHECK(first.code == 0);
    const std::string table = slurp(out + "/table.csv");
    CHECK(table.find(",,") == std::string::npos);
    CHECK(contains(first.out, "| draft | plain | 2 of 2 |"));
    const SweepState done = state_of(read_sweep(description, out)[0]);
    CHECK(done.metrics["peak_memory_bytes"].get<double>() > 1e6);
    const double second = Json::parse(slurp(out + "/ball_draft_plain_s7/metrics.json"))["psnr"],
                 own = done.metrics["psnr"];
    const std::string mean = fmt::format("{:.2f} ± {:.2f}", (own + second) / 2, std::abs(own - second) / 2);
    CAPTURE(mean);
    CHECK(contains(slurp(out + "/settings.csv"), mean));  // of the two seeds of a setting
    CHECK(done.effects == "motion rigidity view light presence");
    const std::string settings = slurp(out + "/settings.csv"), machine = done.metrics["machine"];
    CHECK(contains(settings, ",2 of 2,"));
    CHECK(contains(settings, done.effects + ","));
    CHECK(contains(table, machine.find(',') == machine.npos ? machine : '"' + machine + '"'));
    CHECK(contains(slurp(out + "/table.tex"), " & draft & smooth & 2 of 2 & "));
    const std::string model = slurp(out + "/ball_draft_smooth_s7/model.vdb");
    const Ended again = program({"sweep", description, "--out", out});
    CHECK(again.code == 0);
    CHECK(contains(again.out, "ball_draft_smooth_s7: was done"));
    CHECK(slurp(out + "/table.csv") == table);
    for (const std::string& spelled : {out + "/", folder.str() + "/moved"}) {
      if (spelled != out + "/") std::filesystem::rename(out, spelled);
      const Ended other = program({"sweep", description, "--out", spelled});
      CHECK(other.code == 0);
      CHECK(contains(other.out, "ball_draft_smooth_s7: was done"));
    }
    std::filesystem::rename(folder.str() + "/moved", out);

    // A run without a figure has an empty cell, and takes no part in a mean.
    const std::string of_run = out + "/ball_draft_smooth_s7/metrics.json", metrics = slurp(of_run);
    Json without = Json::parse(metrics);
    without["ssim"] = nullptr;
    write_text(of_run, without.dump());
    CHECK(program({"sweep", description, "--out", out, "--table"}).code == 0);
    CHECK(contains(slurp(out + "/table.csv"), ",,"));
    CHECK(contains(
        slurp(out + "/settings.csv"),
        fmt::format("{:.4f}", state_of(read_sweep(description, out)[2]).metrics["ssim"].get<double>())));
    const Ended said = program({"info", out + "/ball_draft_smooth_s7"});
    CHECK(contains(said.out, " dB, MS-SSIM"));
    write_text(of_run, metrics);

    std::filesystem::remove_all(out + "/ball_draft_smooth_s7");
    const Ended one = program({"sweep", description, "--out", out, "--task", "3", "--threads", "1",
                               "--quiet"});  // as an array job does
    CHECK(one.code == 0);
    CHECK(slurp(out + "/ball_draft_smooth_s7/model.vdb").size() == model.size());
    CHECK(program({"sweep", description, "--out", out, "--task", "4"}).code == 2);
  }

  TEST_CASE("a task that fails is named and the others are done") {
    const TempFolder folder;
    const std::string description = describe_small(folder), out = folder.str() + "/out";
    write_text(description, slurp(description) + "wrong = [\"loss.no_such=1\"]\n");
    const Ended e = program({"sweep", description, "--out", out, "--jobs", "2", "--threads", "1"});
    CHECK(e.code == 1);
    CHECK(contains(e.out, "ball_draft_wrong_s1: failed, see "));
    CHECK(contains(e.out, "| draft | plain | 2 of 2 |"));
    CHECK(contains(e.out, "| draft | wrong | 0 of 2 |"));
    CHECK(contains(slurp(out + "/ball_draft_wrong_s1.log"), "there is no setting"));
  }

  TEST_CASE("a signal stops the pool, the runs save themselves, and the next call goes on with them") {
    const TempFolder folder;
    const std::string description = describe_small(folder), out = folder.str() + "/out";
    std::string text = slurp(description);
    text.replace(text.find("\"20\""), 4, "\"200000\"");
    write_text(description, text);
    Started sweep({SPLINEVOX_PROGRAM, "sweep", description, "--out", out, "--threads", "1"});
    const std::string metrics = out + "/ball_draft_plain_s1/metrics.jsonl";
    REQUIRE(comes([&] { return !slurp(metrics).empty(); }));
    ::kill(sweep.process(), SIGINT);
    CHECK(sweep.wait().code == 130);
    CHECK(contains(slurp(out + "/ball_draft_plain_s1/metrics.json"), "\"finished\": false"));
    CHECK(std::filesystem::exists(out + "/ball_draft_plain_s1/checkpoint.bin"));
    CHECK_FALSE(std::filesystem::exists(out + "/ball_draft_plain_s7"));
  }
}
