// SPDX-License-Identifier: Apache-2.0
#include "train/effects/least_matter.hpp"

#include <doctest/doctest.h>

#include <vector>

#include "support/blob_model.hpp"

using namespace splinevox;

namespace {

/// A blob whose raw density falls by `lost` over time, in a straight line about its mean.
VoxelModel fading(float lost) {
  VoxelModel m = test::blob_model(24);
  MotionField& motion = m.motion;
  motion.points = 2;
  motion.first_point = FirstPoint::free;
  motion.displaces = motion.rigidity = false;
  motion.presence = true;
  const std::vector<float> zero(std::size_t(motion.width()), 0.0f);
  Channels& level = motion.levels[0];
  level = make_channels(level.topology, motion.width(), zero.data());
  for (std::size_t r = kBrickRows; r < level.topology->rows(); ++r) {
    level.row(r)[motion.stride() - 1] = lost / 2;
    level.row(r)[2 * motion.stride() - 1] = -lost / 2;
  }
  return m;
}

}  // namespace

TEST_SUITE("train/least_matter") {
  TEST_CASE("what stands still changes nowhere, and what moves is as much all the time") {
    CHECK(least_matter(test::blob_model(24, {.moves = false})) == 1);
    CHECK(least_matter(test::blob_model(24, {.shift = {-0.3f, 0.1f, 0.2f}})) > 0.8);
  }

  TEST_CASE("what comes or goes is less at some time, in either direction of time") {
    CHECK(least_matter(fading(0)) == 1);
    CHECK(least_matter(fading(16)) < 0.3);
    CHECK(least_matter(fading(-16)) == doctest::Approx(least_matter(fading(16))));
  }

  TEST_CASE("what moves out of the box is matter that goes") {
    CHECK(least_matter(test::blob_model(24, {.shift = {-2.0f, 0, 0}})) < 0.3);
  }
}
