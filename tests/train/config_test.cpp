// SPDX-License-Identifier: Apache-2.0
#include "splinevox/train/config.hpp"

#include <doctest/doctest.h>

#include <fstream>
#include <functional>

#include "core/nearest.hpp"
#include "splinevox/core/error.hpp"
#include "support/tiny_dataset.hpp"

using namespace splinevox;

namespace {

/// A file that lives as long as the object.
struct TemporaryFile {
  test::TempFolder folder;
  std::string path = folder.str() + "/config.toml";
  explicit TemporaryFile(const std::string& text) { REQUIRE(bool(std::ofstream(path) << text)); }
};

std::string message(const std::function<void()>& f) {
  try {
    f();
  } catch (const Error& e) {
    CHECK(e.fault == Fault::input);
    return e.what();
  }
  return "(no error)";
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != text.npos; }

}  // namespace

TEST_SUITE("train/config") {
  TEST_CASE("every preset is valid, carries its own name and can be asked for by it") {
    CHECK(presets().size() >= 5);
    for (const Preset& p : presets()) {
      CAPTURE(p.name);
      CHECK(p.config.preset == p.name);
      CHECK_NOTHROW(validate(p.config));
      CHECK(write_config(preset(p.name)) == write_config(p.config));
    }
  }

  TEST_CASE("what write_config writes, read_config reads back number for number") {
    for (const Preset& p : presets()) {
      CAPTURE(p.name);
      Config c = p.config;
      c.run.seed = 1234567890123;
      c.optimiser.lr_color = 0.1f + 1e-8f;
      c.radiance.initial_alpha = 1e-7f;
      c.grid.box = {-1.25f, -1, -0.3333333f, 1, 1, 2};
      const TemporaryFile file(write_config(c));
      Config back;
      read_config(back, file.path);
      CHECK(write_config(back) == write_config(c));
      CHECK(back.optimiser.lr_color == c.optimiser.lr_color);
      CHECK(back.radiance.initial_alpha == c.radiance.initial_alpha);
      CHECK(back.run.seed == c.run.seed);
      CHECK(back.grid.box == c.grid.box);
    }
  }

  TEST_CASE("a file changes only what it names, and its preset is the ground") {
    const TemporaryFile file(
        "preset = \"draft\"\n[optimiser]\nlr_color = 1\n[motion]\nbasis = \"bezier\"\n"
        "[record]\nanything = 3\n");
    Config c;
    read_config(c, file.path);
    CHECK(c.preset == "draft");
    CHECK(c.optimiser.lr_color == 1);
    CHECK(c.motion.basis == BasisKind::bezier);
    CHECK(c.grid.radiance == preset("draft").grid.radiance);
  }

  TEST_CASE("set_config reads numbers, switches, choices and lists") {
    Config c;
    set_config(c, "optimiser.lr_color=0.25", "--set");
    set_config(c, "motion.enabled = false", "--set");
    set_config(c, "motion.basis=bezier", "--set");
    set_config(c, "grid.radiance=[16, 32]", "--set");
    set_config(c, "grid.radiance_start=0,0.5", "--set");
    set_config(c, "motion.elevate_points=", "--set");
    CHECK(c.optimiser.lr_color == 0.25f);
    CHECK_FALSE(c.motion.enabled);
    CHECK(c.motion.basis == BasisKind::bezier);
    CHECK(c.grid.radiance == std::vector<int>{16, 32});
    CHECK(c.grid.radiance_start == std::vector<float>{0, 0.5f});
    CHECK(c.motion.elevate_points.empty());
  }

  TEST_CASE("an unknown key names the nearest known one") {
    Config c;
    const std::string typo = message([&] { set_config(c, "optimizer.lr_colour=1", "--set"); });
    CHECK(contains(typo, "--set: there is no setting 'optimizer.lr_colour'"));
    CHECK(contains(typo, "optimiser.lr_color"));
    CHECK(contains(message([&] { set_config(c, "tv_density=1", "--set"); }), "loss.tv_density"));
    const TemporaryFile file("[grid]\nradiancy = [8]\n");
    const std::string in_file = message([&] { read_config(c, file.path); });
    CHECK(contains(in_file, ", line 2: there is no setting 'grid.radiancy'"));
    CHECK(contains(in_file, "grid.radiance"));
  }

  TEST_CASE("a file of an earlier version is read without its retired key, which nobody can set") {
    const TemporaryFile file("preset = \"draft\"\n[loss]\nalong = 0.01\nstill = 0.5\n");
    Config c;
    read_config(c, file.path);
    CHECK(c.loss.still == 0.5f);
    CHECK(contains(message([&] { set_config(c, "loss.along=1", "--set"); }), "there is no setting"));
  }

  TEST_CASE("a value out of range names the key, the range and what was given, and changes nothing") {
    Config c;
    CHECK(message([&] { set_config(c, "motion.points=257", "--set"); }) ==
          "--set: 'motion.points' is out of range\n  expected: a whole number in [2, 256]\n  got:      257");
    CHECK(c.motion.points == Config{}.motion.points);
    for (const char* bad :
         {"motion.points=1.5", "optimiser.lr_color=nan", "optimiser.lr_color=inf", "run.seed=-1",
          "motion.enabled=maybe", "motion.basis=hermite", "grid.radiance=8,x", "run.max_steps=99999999999",
          "optimiser.beta1=1", "optimiser.lr_color", "optimiser.lr_color="}) {
      CAPTURE(bad);
      CHECK(message([&] { set_config(c, bad, "--set"); }) != "(no error)");
    }
    CHECK(contains(message([&] { set_config(c, "motion.basis=hermite", "--set"); }), "bezier or bspline"));
    const TemporaryFile file("[motion]\n\npoints = 400\n");
    CHECK(contains(message([&] { read_config(c, file.path); }), ", line 3: 'motion.points' is out of range"));
    const TemporaryFile kind("[optimiser]\nlr_color = \"0.1\"\n");
    CHECK(contains(message([&] { read_config(c, kind.path); }), "has the wrong kind of value"));
    const TemporaryFile broken("[optimiser\n");
    CHECK(contains(message([&] { read_config(c, broken.path); }), "line 1: this is not TOML"));
    CHECK(
        contains(message([&] { read_config(c, "/nowhere/x.toml"); }), "there is no such configuration file"));
    // toml++ 3.3 reaches an unreachable branch for characters like U+018D in a key, or after a line break in
    // a long string.
    for (const char* text : {"\n\xC6\x8D"
                             "eset = \"paper\"\n",
                             "[motion] # \xC3\xA9\npoints \xC6\x8D = 4", "a = \"\"\"x\\\n \xC6\x8D\"\"\"",
                             "a = '''\"\n\xC6\x8D'''", "[record]\na = \"\\\"\"\xC6\x8D",
                             "[record]\na = '\\'\xC6\x8D", "\na = [0/'\xC6\x8D']"}) {
      const TemporaryFile stray(text);
      CHECK(contains(message([&] { read_config(c, stray.path); }),
                     "line 2: there is a character beyond ASCII"));
    }
    const TemporaryFile scripts(
        "\xEF\xBB\xBF# caf\xC3\xA9 \xC6\x8D\n[record]\ndataset = \"\xC6\x8D \\\" \xC3\xA9\"\nother = "
        "['\xC6\x8D']\n");
    CHECK(message([&] { read_config(c, scripts.path); }) == "(no error)");
    CHECK(contains(message([&] { preset("fats"); }), "--preset fast"));
  }

  TEST_CASE("validate finds what ranges alone cannot") {
    const std::vector<std::string> wrong = {"grid.radiance_start=0",
                                            "grid.radiance=",
                                            "grid.motion=4,8,16,30",
                                            "grid.radiance=64,40,96,128",
                                            "grid.box=0,0,0,1,1",
                                            "grid.box=0,0,0,1,1,0",
                                            "run.background=1",
                                            "grid.radiance_start=0,0.5,0.25,0.6",
                                            "motion.points=3",
                                            "motion.first_point=zero",
                                            "motion.elevate_points=8",
                                            "motion.halve_start=0.5,0.4",
                                            "motion.halve_start=0,0,0,0,0",
                                            "sampling.frames=64 ",
                                            "radiance.sh_start=0.5,0.4"};
    for (const std::string& w : wrong) {
      CAPTURE(w);
      Config c;
      if (w == "sampling.frames=64 ") c.sampling.rays = 64;
      set_config(c, w, "--set");
      CHECK(message([&] { validate(c); }) != "(no error)");
    }
    Config endless;
    endless.run.max_time = 0;
    CHECK(contains(message([&] { validate(endless); }), "the run would have no end"));
    Config still;
    still.motion.enabled = still.motion.light = still.motion.presence = false;
    still.grid.motion.clear();
    still.grid.motion_start.clear();
    CHECK_NOTHROW(validate(still));
    Config lit;  // light has curves of its own
    lit.motion.enabled = false;
    lit.motion.points = kMaxPoints;
    lit.motion.halve_start = {.3f};
    CHECK(contains(message([&] { validate(lit); }), "motion."));
  }

  TEST_CASE("harmonics join in turn, the last start for all that follow, or are there at once") {
    const auto orders = [](int order, std::vector<float> starts) {
      std::vector<int> out;
      for (const double p : {0.0, 0.35, 0.65, 0.95})
        out.push_back(order_at({.sh_order = order, .sh_start = starts}, p));
      return out;
    };
    CHECK(orders(3, {}) == std::vector{3, 3, 3, 3});
    CHECK(orders(3, {0.f, 0.6f}) == std::vector{1, 1, 3, 3});
    CHECK(orders(3, {0.3f, 0.6f, 0.9f}) == std::vector{0, 1, 2, 3});
    CHECK(orders(2, {0.3f, 0.6f, 0.9f}) == std::vector{0, 1, 2, 2});
    CHECK(orders(1, {0.f, 0.6f}) == std::vector{1, 1, 1, 1});
    CHECK(orders(-1, {0.f, 0.6f}) == std::vector{-1, -1, -1, -1});
  }
  TEST_CASE("edit distance counts insertions, deletions and replacements") {
    CHECK(edit_distance("", "abc") == 3);
    CHECK(edit_distance("kitten", "sitting") == 3);
    CHECK(edit_distance("train", "train") == 0);
    CHECK(nearest("evl", {"train", "eval", "export"}) == "eval");
    CHECK(nearest("x", {}).empty());
  }
}
