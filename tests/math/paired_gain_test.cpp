// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <cmath>
#include <random>
#include <vector>

#include "splinevox/math/metrics.hpp"

using namespace splinevox;

TEST_SUITE("math/paired_gain") {
  TEST_CASE("Student's own data: extra hours of sleep, ten patients, two drugs") {
    // Student 1908: mean difference 1.58 h, t = 4.06 with 9 degrees of freedom, two-sided p = 0.00283.
    const std::vector<double> extra{1.2, 2.4, 1.3, 1.3, 0.0, 1.0, 1.8, 0.8, 4.6, 1.4};
    const PairedGain g = paired_gain(extra, 0.025);
    CHECK(g.count == 10);
    CHECK(g.mean == doctest::Approx(1.58));
    CHECK(g.p == doctest::Approx(0.00283 / 2).epsilon(0.002));
    CHECK(g.lo == doctest::Approx(0.7001).epsilon(1e-3));
    CHECK(g.hi == doctest::Approx(2.4599).epsilon(1e-3));
  }
  TEST_CASE("without a gain the lower bound is above zero as seldom as the level says") {
    std::mt19937 random(5);
    std::normal_distribution<double> normal;
    int wrong = 0;
    const int trials = 4000;
    for (int i = 0; i < trials; ++i) {
      std::vector<double> d(12);
      for (double& v : d) v = normal(random);
      wrong += paired_gain(d, 0.05).lo > 0;
    }
    CHECK(double(wrong) / trials == doctest::Approx(0.05).epsilon(0.2));  // 3 sigma of a count of 200: 14%
  }
  TEST_CASE("one difference says nothing, and equal ones say all") {
    const PairedGain one = paired_gain(std::vector{3.0}, 0.05),
                     same = paired_gain(std::vector{0.5, 0.5, 0.5}, 0.05),
                     none = paired_gain(std::vector{0.0, 0.0}, 0.05);
    CHECK(one.lo == -INFINITY);
    CHECK(one.hi == INFINITY);
    CHECK(one.p == 1);
    CHECK(same.lo == 0.5);
    CHECK(same.p == 0);
    CHECK(none.p == 1);
    CHECK(paired_gain({}, 0.05).count == 0);
  }
}
