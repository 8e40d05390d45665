// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>
#include <fmt/format.h>

#include "ball_scene.hpp"
#include "run/memory_needs.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/data/synth.hpp"
#include "splinevox/run/train.hpp"

using namespace splinevox;
using namespace splinevox::test;
namespace fs = std::filesystem;
using Scene = BallScene;

TEST_SUITE("app/memory") {
  TEST_CASE("amounts of memory are read with their units, others are refused by name") {
    using run::parse_memory;
    CHECK(parse_memory("6G", "") == 6e9);
    CHECK(parse_memory("6gb", "") == 6e9);
    CHECK(parse_memory("1.5MiB", "") == 1.5 * 1024 * 1024);
    CHECK(parse_memory("2Ti", "") == 2 * 1099511627776.0);
    CHECK(parse_memory("1000000", "") == 1e6);
    for (const char* text : {"", "G", "-1G", "0", "6X", "6GG", "6i", "nan", "inf", "6 G 7"}) {
      CAPTURE(text);
      CHECK_THROWS_AS(parse_memory(text, "--memory"), Error);
    }
    const Scene scene;
    const Ended e = program(scene.train("run", "5", {"--memory", "much"}));
    CHECK(e.code == 2);
    CHECK(contains(e.err, "--memory: this is no amount of memory"));
    CHECK_FALSE(fs::exists(scene.path("run")));
  }

  TEST_CASE("a training that cannot fit is refused before any picture is decoded") {
    const Scene scene;
    const Ended e = program(scene.train("run", "5", {"--memory", "20M"}));
    CHECK(e.code == 2);
    CHECK(contains(e.err, "the training does not fit into it"));
    CHECK(contains(e.err, "occupancy"));
    CHECK_FALSE(fs::exists(scene.path("run")));
  }

  TEST_CASE("a rig of few cameras needs the memory of the coarser lattice that it ends with") {
    const Config config = preset("fast");
    const run::MemoryNeeds all = run::memory_needs(config, make_synth("ball", {.frames = 8, .size = 8})),
                           few = run::memory_needs(
                               config, make_synth("ball", {.frames = 8, .size = 8, .rig = {.cameras = 4}}));
    CHECK(all.cells == 256);
    CHECK(few.cells == 144);
    CHECK(few.lattices < 0.3 * all.lattices);
    // A long sequence has no more occupancies than are made.
    const run::MemoryNeeds longer = run::memory_needs(config, make_synth("ball", {.frames = 600, .size = 8}));
    CHECK(longer.occupancy ==
          run::memory_needs(config, make_synth("ball", {.frames = 700, .size = 8})).occupancy);
  }

  TEST_CASE("from the cache: the same model to the last byte, also resumed, and eval finds the file") {
    const Scene scene;
    const std::string data = scene.path("many"), cache = scene.path("cache");
    write_moving_ball(data, {.train = 80, .val = 0, .test = 40, .size = 48});
    const auto words = [&](const std::string& run, std::vector<std::string> more) {
      std::vector<std::string> all = scene.train(run, "20", std::move(more));
      all[1] = data;
      return all;
    };
    const Ended memory = program(words("memory", {"--threads", "2"}));
    CAPTURE(memory.err);
    REQUIRE(memory.code == 0);
    CHECK(contains(memory.err, "memory: pictures 0.00 GB; lattices"));
    run::TrainOptions as;
    as.preset = "draft";
    as.sets = {"sampling.rays=512", "grid.radiance=16,24,32", "grid.motion=4,8", "grid.motion_start=0,0.2",
               "sampling.occupancy_cells=24"};
    const Config config = run::effective_config(as);
    const Dataset frames = load_dataset(data, {.splits = {"train"}, .pixels = false});
    const std::string bound =
        fmt::format("{:.0f}", run::memory_needs(config, frames).in_memory() + 40 * 4.0 * 48 * 48);
    const std::vector<std::string> less = {"--threads", "2", "--memory", bound, "--cache", cache};
    const Ended file = program(words("file", less));
    CAPTURE(file.err);
    REQUIRE(file.code == 0);
    CHECK(contains(file.err, "kept in files of a cache"));
    CHECK(contains(file.err, cache));
    CHECK(contains(file.err, "in files, mapped"));
    CHECK(slurp(scene.path("file") + "/model.vdb") == slurp(scene.path("memory") + "/model.vdb"));
    REQUIRE_FALSE(fs::is_empty(cache));
    const auto time = fs::last_write_time(fs::directory_iterator(cache)->path());
    std::vector<std::string> resume = words("file", less);
    resume.push_back("--resume");
    CHECK(program(resume).code == 0);
    CHECK(fs::last_write_time(fs::directory_iterator(cache)->path()) == time);
    const Ended eval =
        program({"eval", scene.path("file"), "--threads", "2", "--cache", cache, "--memory", "250k"});
    CAPTURE(eval.err);
    CHECK(eval.code == 0);
    CHECK(contains(eval.out, "kept in files of a cache"));
    CHECK(std::distance(fs::directory_iterator(cache), {}) == 2);  // of another split
  }
}
