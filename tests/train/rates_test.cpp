// SPDX-License-Identifier: Apache-2.0
#include "train/rates.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "splinevox/train/config_keys.hpp"
#include "train/config/loss_terms.hpp"
#include "train/effects/effect_table.hpp"

using namespace splinevox;

namespace {

/// A configuration in which no two numbers that columns are learned by are the same.
Config distinct() {
  Config c;
  float next = 1;
  for (const ColumnFacts& facts : kColumns) {
    c.optimiser.*learning_of(facts.kind).rate = next++;
    c.loss.*learning_of(facts.kind).tv = next++;
  }
  c.optimiser.shrink = 0.5f;
  return c;
}

MotionField motion(bool displaces, bool rigidity, bool light) {
  MotionField m;
  m.points = 5;
  m.first_point = FirstPoint::free;
  m.displaces = displaces;
  m.rigidity = rigidity;
  m.light = light;
  return m;
}

Channels rows_of(int width) {
  const Box box{{0, 0, 0}, {1, 1, 1}};
  const std::vector<float> zero(std::size_t(width), 0.0f);
  return make_channels(make_dense_topology(make_lattice(box, 7)), width, zero.data());
}

/// Radiance of order 2 and one level of motion, in a box whose longest edge is 2.
Lattices lattices_of(const MotionField& m) {
  Lattices out;
  out.model.box = {{0, 0, 0}, {2, 1, 1}};
  out.model.radiance.sh_order = 2;
  out.model.radiance.raw = rows_of(radiance_width(2));
  out.model.motion = m;
  out.radiance = Learner(out.model.radiance.raw);
  out.levels = {rows_of(m.width())};
  out.level_learners.emplace_back(out.levels[0]);
  return out;
}

}  // namespace

TEST_SUITE("train/rates") {
  TEST_CASE("every column is learned by numbers of its own, and every curve has a prior") {
    std::set<std::string> rates, weights;
    Config config;
    for (const ColumnFacts& facts : kColumns) {
      CAPTURE(facts.name);
      const ColumnLearning& by = learning_of(facts.kind);
      CHECK(by.kind == facts.kind);
      CHECK((by.differences != nullptr) == (facts.repeat == Repeat::point));
      for (const LossTerm& term : kLossTerms) {
        if (term.weight == by.tv) CHECK(term.edges == facts.length);
        if (by.differences && term.weight == by.differences) CHECK(term.edges == 2 * facts.length);
      }
      visit_config(config, [&](const char* key, const auto& member, const char*, double, double) {
        const void* at = &member;
        if (at == &(config.optimiser.*by.rate)) CHECK(rates.insert(key).second);
        if (at == &(config.loss.*by.tv)) CHECK(weights.insert(key).second);
        if (by.differences && at == &(config.loss.*by.differences)) CHECK(weights.insert(key).second);
      });
    }
    CHECK(rates.size() == std::size(kColumns));
    CHECK(weights.size() == std::size(kColumns) + kCurves);
  }

  TEST_CASE("rates and weights reach their columns, lengths in edges of the box, and padding has none") {
    Config config = distinct();
    config.grid.motion = {16};
    for (const MotionField& m : {motion(true, true, true), motion(true, false, false),
                                 motion(true, false, true), motion(false, false, true)}) {
      Lattices lattices = lattices_of(m);
      set_rates(config, lattices);
      const auto check = [&](const Learner& learner, const std::vector<Column>& columns) {
        std::vector<float> rate(learner.rate.size(), 0.0f), tv = rate;
        for (const Column& c : columns)
          for (int a = 0; a < c.width; ++a) {
            const bool length = facts_of(c.kind).length;
            const float edge = length ? 2 : 1, share = length && !m.rigidity ? 2 / 16.0f : 1;
            rate[std::size_t(c.first + a)] = config.optimiser.*learning_of(c.kind).rate * edge * share;
            tv[std::size_t(c.first + a)] = config.loss.*learning_of(c.kind).tv / edge;
          }
        CHECK(learner.rate == rate);
        CHECK(learner.tv == tv);
      };
      check(lattices.radiance, radiance_columns(lattices.model.radiance));
      check(lattices.level_learners[0], motion_columns(m));
    }
  }

  TEST_CASE("each kind of curve shrinks as a group: every column of its points, and nothing else") {
    for (const MotionField& m :
         {motion(true, true, true), motion(true, true, false), motion(false, false, true)}) {
      Config config = distinct();
      Lattices lattices = lattices_of(m);
      const Learner& learner = lattices.level_learners[0];
      set_rates(config, lattices);
      REQUIRE(learner.shrink.size() == std::size_t(m.displaces + m.light));
      std::size_t group = 0;
      for (const ColumnFacts& facts : kColumns) {
        if (facts.repeat != Repeat::point || !(m.*facts.stored)) continue;
        const Shrink& shrink = learner.shrink[group++];
        std::vector<float> member(std::size_t(m.width()), 0.0f);
        for (const Column& c : motion_columns(m))
          for (int a = 0; a < c.width; ++a)
            if (c.kind == facts.kind) member[std::size_t(c.first + a)] = 1;
        CHECK(shrink.member == member);
        const float rate = learner.rate[std::size_t(facts.kind == ColumnKind::light && m.displaces ? 3 : 0)];
        CHECK(shrink.threshold ==
              doctest::Approx(0.5f * rate * std::sqrt(float(facts.width * m.stored_points()))));
      }
      config.optimiser.shrink = 0;
      set_rates(config, lattices);
      CHECK(learner.shrink.empty());
    }
  }

  TEST_CASE("radiance begins with what the configuration and the pictures say, zero beside it") {
    RadianceField radiance;
    radiance.sh_order = 1;
    RadianceConfig config;
    config.initial_sh = 0.7f;
    PictureStats dark;
    dark.mean = {0.01f, 0.02f, 0.005f};
    const std::vector<float> row = first_row(radiance, config, dark);
    const Vec3 color = starting_color(config, dark);
    CHECK(row == std::vector<float>{0, color.x, color.y, color.z, 0.7f, 0, 0, 0});
    radiance.sh_order = -1;
    CHECK(first_row(radiance, config, {}) == std::vector<float>(8, 0.0f));
  }

  TEST_CASE("curves are held together by their own weights, at their place in a point") {
    Config config;
    config.loss.curve_length = 8;
    config.loss.curve_light = 3;
    config.loss.curve_knots = 4;
    const auto curves = [&](const MotionField& m, int halvings) {
      Lattices lattices = lattices_of(m);
      set_priors(config, halvings, lattices);
      return lattices.curves;
    };
    const CurvePrior both = curves(motion(true, false, true), 1);
    CHECK(both.length == 2);
    CHECK(both.knots == 2);
    CHECK(both.spacing == 2);
    CHECK(both.scalar[0] == 3);
    CHECK(both.lane[0] == 3);
    const CurvePrior alone = curves(motion(false, false, true), 0);
    CHECK(alone.length == 0);
    CHECK(alone.knots == 0);
    CHECK(alone.scalar[0] == 3);
    CHECK(alone.lane[0] == 0);
    CHECK(curves(motion(true, true, false), 0).scalar[0] == 0);
  }
}

TEST_SUITE("train/effect_table") {
  TEST_CASE("every effect has all its facts, and every column beyond a still and matte one an effect") {
    std::set<std::string> names;
    std::set<ColumnKind> brought;
    std::set<int> turns;
    for (const Effect e : kAllEffects) {
      const EffectFacts& f = facts_of(e);
      CHECK(f.effect == e);
      REQUIRE(f.name);
      CAPTURE(f.name);
      CHECK(names.insert(f.name).second);
      CHECK(effect_named(f.name) == e);
      CHECK(bool(f.order_in));
      CHECK(bool(f.set));
      CHECK(f.needs.has_value() == (std::string(f.why_needs) != ""));
      CHECK(f.full >= 0);
      CHECK(f.least >= 0);
      if (f.brings) CHECK(brought.insert(*f.brings).second);
      const bool tried = f.trial != Trial::none;
      CHECK(tried == (f.comparisons > 0));
      CHECK(tried == (f.turn > 0));
      if (tried) CHECK(turns.insert(f.turn).second);
    }
    CHECK_FALSE(effect_named("shadow"));
    CHECK(brought.size() == std::size(kColumns) - 2);
    CHECK(brought.count(ColumnKind::density) + brought.count(ColumnKind::color) == 0);
  }

  TEST_CASE(
      "surroundings are tried first, then exposures, how they drift, a background, motion, clocks, light and "
      "presence; what changes over time always counts") {
    const EffectSet all = effects_of(preset("fast"));
    CHECK(in_turn(all) == std::vector<Effect>{Effect::surroundings, Effect::exposure, Effect::drift,
                                              Effect::background, Effect::motion, Effect::clock,
                                              Effect::light, Effect::presence});
    CHECK(most_comparisons(all) == 10);
    CHECK(most_comparisons(learnable_in(all, true, TakenBy::any)) == 7);
    CHECK(most_comparisons(all.without(Effect::motion)) == 9);
    CHECK(most_comparisons(all.without(Effect::background)) == 8);
    CHECK(learnable_in(all, true, TakenBy::rig) == all);
    CHECK(learnable_in(all, false, TakenBy::rig) == all.without(Effect::background));
    const EffectSet film = all.without(Effect::exposure).without(Effect::clock);
    CHECK(learnable_in(all, true, TakenBy::film) == film);
    CHECK(learnable_in(all, true, TakenBy::any) == film.without(Effect::drift));
  }

  TEST_CASE("an effect stores its columns, and models change over time if any that does is on") {
    for (const Effect e : kAllEffects) {
      CAPTURE(to_string(e));
      const EffectSet one = EffectSet{}.with(e);
      const bool moving =
          e == Effect::motion || e == Effect::rigidity || e == Effect::light || e == Effect::presence;
      CHECK(changes(one) == moving);
      MotionField m;
      store(one, m);
      CHECK(m.displaces == (e == Effect::motion));
      CHECK(m.rigidity == (e == Effect::rigidity));
      CHECK(m.light == (e == Effect::light));
      CHECK(m.presence == (e == Effect::presence));
    }
  }

  TEST_CASE("rigidity without the motion it scales is off in a configuration") {
    Config config;
    apply(EffectSet{}.with(Effect::rigidity).with(Effect::light), config);
    CHECK(to_string(effects_of(config)) == "light");
    CHECK_FALSE(config.motion.rigidity);
  }
}
