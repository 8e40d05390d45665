// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "field/lattice/locate.hpp"
#include "render/active_rows.hpp"
#include "splinevox/data/image_io.hpp"
#include "splinevox/data/synth.hpp"
#include "splinevox/train/trainer.hpp"
#include "support/blob_model.hpp"
#include "support/small_run.hpp"
#include "train/bounds/offset.hpp"

using namespace splinevox;

namespace {

/// A run long enough to tell what moves.
Config resting_run() {
  Config c = test::small_run(600);
  c.motion.presence = false;  // as training without trials leaves it
  c.grid.radiance = {24, 40};
  c.grid.radiance_start = {0, 0.5f};
  c.grid.motion = {4, 8, 16};
  c.grid.motion_start = {0, 0.1f, 0.2f};
  return c;
}

const Dataset& toy() {
  static const Dataset data = make_synth("toy", {.frames = 40, .size = 64});
  return data;
}

struct Made {
  VoxelModel model;
  double moving_share;
};

Made made_by(const Config& config, const Dataset& data, int threads = 2, std::int64_t stop_at = 0) {
  return test::on_threads(threads, [&] {
    auto trainer = std::make_unique<Trainer>(config, *data.find("train"), data.time_map);
    while (!trainer->done()) {
      if (trainer->step().step != stop_at) continue;
      const std::vector<char> state = trainer->save();
      trainer = std::make_unique<Trainer>(config, *data.find("train"), data.time_map);
      trainer->restore(state);
    }
    return Made{trainer->model(), trainer->moving_share()};
  });
}

std::size_t count_moving(const VoxelModel& model) {
  std::size_t n = 0;
  for (const RowMask& rows : nonzero_rows(model.motion.levels.back())) rows.for_each([&](int) { ++n; });
  return n;
}

}  // namespace

TEST_SUITE("train/rest") {
  TEST_CASE(
      "static regions freeze, the ball does not, and pictures are as good; the same bits for any "
      "number of threads and across a stop") {
    const Made everywhere = [] {
      Config c = resting_run();
      c.motion.rest = 0;
      return made_by(c, toy());
    }();
    const Made made = made_by(resting_run(), toy());
    CAPTURE(made.moving_share);
    CHECK(everywhere.moving_share == 1);
    CHECK(made.moving_share < 0.4);
    CHECK(made.moving_share > 0.01);
    CHECK(count_moving(made.model) < count_moving(everywhere.model) / 2);
    const double with = test::test_psnr(made.model, toy()),
                 without = test::test_psnr(everywhere.model, toy());
    CAPTURE(with);
    CAPTURE(without);
    CHECK(with > without - 0.7);
    const Made again = made_by(resting_run(), toy(), 1, 450);
    CHECK(again.moving_share == made.moving_share);
    CHECK(again.model.radiance.raw.values == made.model.radiance.raw.values);
    CHECK(again.model.motion.levels[0].values == made.model.motion.levels[0].values);
  }
  TEST_CASE("where most of a scene moves nothing freezes, to the last bit") {
    Config c = resting_run();
    c.run.max_steps = 300;
    const Dataset snake = make_synth("snake", {.frames = 30, .size = 48});
    const Made made = made_by(c, snake);
    c.motion.rest = 0;
    CHECK(made.moving_share == 1);
    CHECK(made_by(c, snake).model.radiance.raw.values == made.model.radiance.raw.values);
  }
  TEST_CASE("a static scene freezes, its pictures none the worse") {
    const Dataset still = make_synth("static", {.frames = 40, .size = 64});
    Config c = resting_run();
    const Made made = made_by(c, still);
    c.motion.rest = 0;
    const Made everywhere = made_by(c, still);
    CHECK(made.moving_share < 0.1);
    CHECK(count_moving(made.model) < count_moving(everywhere.model) / 2);
    CHECK(test::test_psnr(made.model, still) > test::test_psnr(everywhere.model, still) - 0.2);
  }
  TEST_CASE("three pictures are too few to say what is static") {
    Config c = resting_run();
    c.run.max_steps = 60;
    const Dataset few = make_synth("toy", {.frames = 3, .size = 32});
    const Made made = made_by(c, few);
    CHECK(made.moving_share == 1);
    c.motion.rest = 0;
    CHECK(made_by(c, few).model.radiance.raw.values == made.model.radiance.raw.values);
  }
  TEST_CASE("an offset is what is known where it is, smooth in between, and undone") {
    const Box box{{-1, -1, -1}, {1, 1, 0.5f}};
    BitGrid cells(box, 16);
    std::vector<Vec3> known(cells.cells());
    const auto truth = [](const Vec3& x) { return Vec3{0.05f + 0.02f * x.y, -0.03f * x.x, 0.01f}; };
    for (std::size_t c = 0; c < cells.cells(); ++c) {
      const Int3 at = cells.cell_at(c);
      if ((at.x + at.y + at.z) % 5 == 0) {
        cells.set(c);
        known[c] = truth(cells.center(at));
      }
    }
    const Offset offset(cells, known);
    for (std::size_t c = 0; c < cells.cells(); ++c)
      if (cells.test(c)) CHECK(length(offset.at(cells.center(cells.cell_at(c))) - known[c]) < 1e-6f);
    std::mt19937 random(3);
    std::uniform_real_distribution<float> inside(-0.8f, 0.4f);
    for (int i = 0; i < 100; ++i) {
      const Vec3 z{inside(random), inside(random), inside(random)}, y = offset.undo(z);
      CHECK(length(offset.at(z) - truth(z)) < 4e-3f);
      CHECK(length(y + offset.at(y) - z) < 1e-5f);
    }
  }
  TEST_CASE("no cell: no offset; a grid one cell thick") {
    const Box box{{0, 0, 0}, {1, 1, 0.01f}};
    BitGrid cells(box, 8);
    REQUIRE(cells.size.z == 1);
    CHECK(length(Offset(cells, std::vector<Vec3>(cells.cells())).at({0.5f, 0.5f, 0.005f})) == 0);
  }
  TEST_CASE(
      "the reach of rows: every place from which one of them is read, across bricks and beside absent ones, "
      "and little else") {
    const Lattice lattice{{-1, 0, 2}, 0.25f, {24, 16, 16}};
    const TopologyPtr t = make_topology(lattice, {{0, 0, 0}, {2, 0, 0}, {2, 1, 1}});
    std::vector<RowMask> rows(t->bricks.size());
    rows[1].set(7 << 6 | 7 << 3 | 7);
    rows[2].set(0);  // read from the absent brick to its left as well
    const Box box{lattice.origin, lattice.position(lattice.size - Int3{1, 1, 1})};
    const BitGrid reach = reach_of(*t, rows, BitGrid(box, 64));
    const BrickView<float> view(*t);
    std::mt19937 random(5);
    std::uniform_real_distribution<float> share(0, 1);
    int read = 0, reached = 0;
    constexpr int kPlaces = 200000;
    for (int k = 0; k < kPlaces; ++k) {
      Vec3 x = box.lo;
      for (int a = 0; a < 3; ++a) x[a] += share(random) * box.extent()[a];
      const CellRows at = locate(view, x).rows;
      const bool reads = std::any_of(at.row, at.row + kCorners, [&](std::int32_t row) {
        return row >= kBrickRows && rows[row / kBrickRows].test(row % kBrickRows);
      });
      const bool within = reach.test(reach.index(reach.cell_of(x)));
      if (reads) CHECK(within);
      read += reads;
      reached += within;
    }
    CHECK(read > 100);
    CHECK(reached < 4 * read);  // a cell of the grid is 0.36 of a vertex' spacing
  }
  TEST_CASE("rows that are not zero are all of a noisy model's, and those of what was moved alone") {
    VoxelModel model = test::noisy_model(21, 6, FirstPoint::zero, BasisKind::bezier, 1, true, true);
    Channels& level = model.motion.levels[0];
    const std::vector<RowMask> noisy = nonzero_rows(level);
    CHECK_FALSE(noisy[0].any());
    for (std::size_t b = 1; b < noisy.size(); ++b) CHECK(noisy[b] == RowMask::all());
    std::fill(level.values.begin(), level.values.end(), 0.0f);
    level.row(kBrickRows + 70)[2] = -1e-20f;
    const std::vector<RowMask> rows = nonzero_rows(level);
    RowMask expected;
    expected.set(70);
    CHECK(rows[1] == expected);
    CHECK_FALSE(rows[0].any());
  }
}
