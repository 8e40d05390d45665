// SPDX-License-Identifier: Apache-2.0
#include "train/plan.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <type_traits>

#include "math/emission.hpp"
#include "splinevox/data/synth.hpp"
#include "splinevox/train/config_keys.hpp"
#include "train/paced.hpp"
#include "train/run_clock.hpp"

using namespace splinevox;

namespace {

const Split& planned() {
  static const Dataset data = make_synth("ball", {.frames = 8, .size = 24, .seed = 3});
  return *data.find("train");
}

/// A configuration in which nothing ever happens.
Config eventless() {
  Config c = preset("draft");
  visit_config(c, [](const std::string& key, auto& member, const char*, double, double) {
    if constexpr (std::is_same_v<std::decay_t<decltype(member)>, std::vector<float>>)
      if (key.ends_with("_start")) member.clear();
  });
  return c;
}

/// A run's volume and plan, as they come to a progress.
struct Course {
  Setting setting;
  Plan plan;
  Volume volume;
  TimeWindow window;
  std::vector<int> frames;

  explicit Course(const Config& config) : setting(config, planned()), volume{start(setting)} {
    for (int f = 0; f < int(planned().frames.size()); ++f) frames.push_back(f);
    window = {frames, true};
  }
  bool reach(double progress) { return plan.carry_out(setting, progress, progress > 0, window, volume); }

 private:
  static Volume start(const Setting& setting) {
    const SceneBounds bounds = starting_bounds(setting.config, setting.train, setting.stats);
    return {Lattices(setting, {}, bounds.box), {bounds.hull, {}, {}}, {}, {}};
  }
};

Config eventful() {
  Config c = preset("draft");
  c.grid.radiance = {12, 16, 20};
  c.sampling.occupancy_cells = 32;
  c.grid.radiance_start = {0, 0.3f, 0.6f};
  c.grid.motion = {4, 8};
  c.grid.motion_start = {0.1f, 0.5f};
  c.grid.empty_start = {0.7f};
  c.radiance.sh_order = 2;
  c.radiance.sh_start = {0, 0.4f};
  c.motion.basis = BasisKind::bspline;
  c.motion.points = 6;
  c.motion.halve_start = {0.2f, 0.8f};
  c.motion.elevate_points.clear();
  c.motion.elevate_start.clear();
  c.motion.rest = 0;
  return c;
}

}  // namespace

TEST_SUITE("train/plan") {
  TEST_CASE("every list of starts in the configuration is an event's, and due when it is reached") {
    CHECK(Plan().due(eventless(), 1).empty());
    std::set<std::string> events;
    int lists = 0;
    Config keys;
    visit_config(keys, [&](const std::string& key, auto& of_default, const char*, double, double) {
      if constexpr (std::is_same_v<std::decay_t<decltype(of_default)>, std::vector<float>>) {
        if (!key.ends_with("_start")) return;
        CAPTURE(key);
        if (key == "grid.surroundings_start") return;  // of what is learned beside the plan's volume
        ++lists;
        Config c = eventless();
        c.motion.basis = key == "motion.elevate_start" ? BasisKind::bezier : BasisKind::bspline;
        visit_config(c, [&](const std::string& other, auto& member, const char*, double, double) {
          if constexpr (std::is_same_v<std::decay_t<decltype(member)>, std::vector<float>>)
            if (other == key) member = {0.5f};
        });
        CHECK(Plan().due(c, 0.49).empty());
        const auto due = Plan().due(c, 0.5);
        REQUIRE(due.size() == 1);
        events.insert(std::string(due[0]));
      }
    });
    CHECK(lists == 6);
    CHECK(events.size() == 5);  // curves are halved or elevated
  }

  TEST_CASE("no lattice begins beyond those that a run has time for, and all else happens as ever") {
    Course few(eventful());
    few.plan.limit_stages(2);
    few.reach(0);
    few.reach(1);
    const Config& config = few.setting.config;
    CHECK(few.plan.due(config, 1).empty());
    CHECK(few.plan.counts().stages == 2);
    CHECK(few.plan.counts().levels == 2);
    CHECK(few.plan.fits(config, few.volume.lattices));
    const auto cells = [&] {
      const Lattices& l = few.volume.lattices;
      return l.edge() / l.model.radiance.raw.topology->lattice.spacing;
    };
    CHECK(cells() == doctest::Approx(16));
    few.plan.limit_stages(1);  // slower from here on: what has begun stays
    few.reach(1);
    CHECK(few.plan.counts().stages == 2);
    few.plan.limit_stages(3);
    few.reach(1);
    CHECK(few.plan.counts().stages == 3);
    CHECK(cells() == doctest::Approx(20));
  }

  TEST_CASE("by the clock the pace tells how many whole batches a run has time for") {
    Config c = preset("fast");
    c.run.max_time = 100;
    c.run.max_steps = 0;
    c.sampling.rays = 4096;
    c.sampling.growth = 3;
    RunClock clock;
    clock.seconds_at_start = 20;
    CHECK_FALSE(clock.batches(c));  // nothing is known
    clock.drawn = 8192 * 50;
    clock.drawing = 10;  // five batches of the mean size a second, 80 seconds of them
    CHECK(clock.batches(c).value() == doctest::Approx(400));
    clock.added = 100;
    CHECK(clock.batches(c).value() == doctest::Approx(900));
    c.run.paced = false;
    CHECK(std::isinf(clock.batches(c).value()));
    c.run.paced = true;
    c.run.max_steps = 1000;
    CHECK(std::isinf(clock.batches(c).value()));

    const double none = std::numeric_limits<double>::infinity();
    CHECK(batch_share(none) == 1);
    CHECK(batch_share(0) == 0.25);
    CHECK(batch_share(300) == doctest::Approx(0.75));
    CHECK(most_stages(none) >= 100);
    CHECK(most_stages(0) == 2);
    CHECK(most_stages(600) == 4);
  }

  TEST_CASE("what has happened is due no more, however far the progress jumps") {
    Course step_by_step(eventful()), at_once(eventful());
    const Config& config = step_by_step.setting.config;
    for (const double progress : {0.0, 0.11, 0.21, 0.31, 0.41, 0.51, 0.61, 0.71, 0.81}) {
      CAPTURE(progress);
      CHECK_FALSE(step_by_step.plan.due(config, progress).empty());
      step_by_step.reach(progress);
      CHECK(step_by_step.plan.due(config, progress).empty());
      CHECK_FALSE(step_by_step.reach(progress));  // a second time
    }
    at_once.reach(0);
    CHECK(at_once.reach(1));
    for (const Course* course : {&step_by_step, &at_once}) {
      const Lattices& l = course->volume.lattices;
      CHECK(course->plan.due(config, 1).empty());
      CHECK(course->plan.fits(config, l));
      CHECK(l.levels.size() == 2);
      CHECK(l.model.radiance.sh_order == 2);
      CHECK(l.model.motion.points == 2 * (2 * 6 - 3) - 3);
      CHECK(l.model.step == config.sampling.step * l.model.radiance.raw.topology->lattice.spacing);
      CHECK(l.radiance.m.size() == l.model.radiance.raw.values.size());
      CHECK(l.model.motion.levels.size() == 1);
      CHECK(l.model.motion.levels[0].width == l.model.motion.width());
    }
  }

  TEST_CASE(
      "density is steeper on a finer lattice and stays what it was; with presence it is as steep as before") {
    for (const bool presence : {false, true}) {
      CAPTURE(presence);
      Config config = eventful();
      config.motion.presence = presence;
      config.grid.prune_alpha = 0;
      config.radiance.steepen = 0;
      Course plain(config);
      config.radiance.steepen = 1;
      Course steep(config);
      for (Course* course : {&plain, &steep}) {
        course->reach(0);
        Channels& raw = course->volume.lattices.model.radiance.raw;
        for (std::size_t i = kBrickRows; i < raw.topology->rows(); ++i)
          raw.row(i)[0] = float(i * 7919 % 1000) / 1000 * 40 - 10;  // from nothing to opaque
        course->reach(0.31);
      }
      const VoxelModel &a = plain.volume.lattices.model, &b = steep.volume.lattices.model;
      CHECK(a.radiance.activation.scale == doctest::Approx(1 / a.step * 12 / 16));
      CHECK(b.radiance.activation.scale == doctest::Approx(1 / b.step * (presence ? 12 / 16. : 1)));
      REQUIRE(a.radiance.raw.topology->rows() == b.radiance.raw.topology->rows());
      double apart = 0;
      float lowest = 0;
      const auto density = [](const RadianceField& r, std::size_t i) {
        return density_of(r.raw.row(i)[0], r.activation.scale, r.activation.shift).value;
      };
      for (std::size_t i = 0; i < a.radiance.raw.topology->rows(); ++i) {
        apart = std::max(apart, double(std::abs(density(a.radiance, i) - density(b.radiance, i))) * a.step);
        lowest = std::min(lowest, b.radiance.raw.row(i)[0]);
      }
      CHECK(apart < 1e-4);  // of optical depths up to 40 * 12 / 16
      CHECK(lowest == doctest::Approx(-10));
    }
  }

  TEST_CASE("matter is emptied once rays were enough, and what they saw before is not forgotten") {
    Config config = eventless();
    config.grid.radiance = {24};
    config.grid.radiance_start = {0};
    config.grid.empty_start = {0.3f, 0.6f, 0.9f};
    Course course(config);
    course.reach(0);
    Lattices& l = course.volume.lattices;
    const int bricks = l.model.radiance.raw.topology->brick_count();
    REQUIRE(bricks > 2);
    l.visible.rows[1].set(7);
    l.visible.rays = 10;  // of 8 pictures of 24 x 24
    CHECK_FALSE(course.reach(0.3));
    CHECK(l.model.radiance.raw.topology->brick_count() == bricks);
    CHECK(l.visible.rays == 10);
    l.visible.rows[2].set(9);
    l.visible.rays += 100'000;
    CHECK(course.reach(0.6));
    CHECK(l.model.radiance.raw.topology->brick_count() == 2);
    const auto anew = [&] {
      CHECK(l.visible.rays == 0);
      REQUIRE(l.visible.rows.size() == 3);
      for (const RowMask& rows : l.visible.rows) CHECK_FALSE(rows.any());
    };
    anew();
    l.visible.rows[1].set(7);
    l.visible.rays = 100'000;
    course.window.whole = false;  // some pictures have sent no ray yet
    CHECK_FALSE(course.reach(0.9));
    CHECK(l.model.radiance.raw.topology->brick_count() == 2);
    anew();
  }

  TEST_CASE("a plan of another volume or with counts that cannot be does not fit") {
    Course course(eventful());
    course.reach(0);
    course.reach(0.61);
    const Config& config = course.setting.config;
    REQUIRE(course.plan.fits(config, course.volume.lattices));
    Archive saved;
    course.plan.archive(saved);
    std::vector<char> bytes;
    for (const std::string_view piece : saved.pieces()) bytes.insert(bytes.end(), piece.begin(), piece.end());
    REQUIRE(bytes.size() == sizeof(Plan::Counts));
    for (std::size_t at = 0; at < bytes.size(); at += sizeof(int)) {
      CAPTURE(at);
      for (const int count : {-1, 1000}) {
        std::vector<char> spoilt = bytes;
        std::memcpy(spoilt.data() + at, &count, sizeof count);
        Archive in(spoilt);
        Plan plan;
        plan.archive(in);
        CHECK_FALSE(plan.fits(config, course.volume.lattices));
      }
    }
    course.volume.lattices.levels.pop_back();
    CHECK_FALSE(course.plan.fits(config, course.volume.lattices));
  }
}
