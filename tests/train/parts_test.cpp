// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <cmath>
#include <random>
#include <set>
#include <vector>

#include "backend/host/optimiser.hpp"
#include "math/camera.hpp"
#include "math/photometric.hpp"
#include "math/tv.hpp"
#include "splinevox/data/synth.hpp"
#include "splinevox/field/sample.hpp"
#include "support/dual.hpp"
#include "train/batch.hpp"
#include "train/bounds/hull.hpp"
#include "train/learner.hpp"
#include "train/refine.hpp"

using namespace splinevox;
using test::Dual;

namespace {

const Box kBox{{-1, -1, -1}, {1, 1, 1}};

Channels random_channels(TopologyPtr topology, int width, unsigned seed) {
  const std::vector<float> zero(width, 0.0f);
  Channels c = make_channels(std::move(topology), width, zero.data());
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(-1, 1);
  for (std::size_t i = std::size_t(kBrickRows) * width; i < c.values.size(); ++i)
    c.values[i] = uniform(random);
  return c;
}

/// Weights of all columns: the first one's, and 0.
std::vector<float> first_column(const Channels& values, float weight) {
  std::vector<float> out(values.width, 0.0f);
  out[0] = weight;
  return out;
}

/// Row of a vertex, or -1 where it is absent or not visible. @param visible  empty: all are
std::int64_t row_of(const Topology& t, Int3 v, std::span<const RowMask> visible) {
  const Int3 brick{v.x >> 3, v.y >> 3, v.z >> 3};
  for (int a = 0; a < 3; ++a)
    if (brick[a] < 0 || brick[a] > t.dims[a] - 2) return -1;
  const int b = t.brick_at(brick);
  const int i = (v.x & 7) << 6 | (v.y & 7) << 3 | (v.z & 7);
  return b && (visible.empty() || visible[std::size_t(b)].test(i)) ? std::int64_t(b) * kBrickRows + i : -1;
}

/// Derivative of column 0's total variation with respect to one value: every term that reads it, in dual
/// numbers.
double tv_derivative(const Channels& c, Int3 at, std::span<const RowMask> visible = {}) {
  const Topology& t = *c.topology;
  const std::int64_t seeded = row_of(t, at, visible);
  const auto value = [&](std::int64_t row) { return Dual(c.row(row)[0], row == seeded); };
  Dual sum;
  for (const Int3& back : {Int3{0, 0, 0}, Int3{1, 0, 0}, Int3{0, 1, 0}, Int3{0, 0, 1}}) {
    const Int3 v = at - back;
    const std::int64_t self = row_of(t, v, visible);
    if (self < 0) continue;
    const auto neighbour = [&](Int3 step) {
      const std::int64_t row = row_of(t, v + step, visible);
      return value(row < 0 ? self : row);
    };
    sum += tv_term(value(self), neighbour({1, 0, 0}), neighbour({0, 1, 0}), neighbour({0, 0, 1}), 1e-10,
                   [](Dual x) { return sqrt(x); })
               .value;
  }
  return sum.b;
}

/// Every place of the ball that a ray of the pictures meets lies in the hull and in the box.
/// @param every  pixels from one ray to the next  @return how many there are
int check_ball_within(const SceneBounds& bounds, const Split& train, int every) {
  const SynthScene scene = SynthScene::open("ball");
  int hits = 0;
  for (const Frame& frame : train.frames)
    for (int y = every; y < frame.image.height; y += every)
      for (int x = every; x < frame.image.width; x += every)
        if (const auto hit = scene.at(frame.time).trace(camera_ray(frame.camera, x + 0.5, y + 0.5))) {
          ++hits;
          const Vec3 p = cast<float>(hit->position);
          CHECK(bounds.hull.test(bounds.hull.index(bounds.hull.cell_of(p))));
          for (int a = 0; a < 3; ++a) CHECK((p[a] > bounds.box.lo[a] && p[a] < bounds.box.hi[a]));
        }
  return hits;
}

}  // namespace

TEST_SUITE("train/optimiser") {
  TEST_CASE(
      "total variation has the gradient of its value, at neighbours that are absent or not visible too") {
    const auto topology =
        make_topology(make_lattice(kBox, 23), {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {2, 2, 2}, {2, 2, 1}});
    const Channels values = random_channels(topology, 8, 3);
    std::vector<RowMask> some(topology->bricks.size());  // none in the last brick
    std::mt19937 random(6);
    for (int b = 1; b < topology->brick_count(); ++b)
      for (int i = 0; i < kBrickRows; ++i)
        if (random() % 3 > 0) some[b].set(i);
    for (const std::span<const RowMask> visible :
         {std::span<const RowMask>(), std::span<const RowMask>(some)}) {
      Gradient gradient(values);
      add_total_variation(values, first_column(values, 0.5f), 1, 1, 11, visible, gradient);
      for (int b = 1; b <= topology->brick_count(); ++b)
        for (int i = 0; i < kBrickRows; ++i) {
          const float* g = gradient.values.row(std::size_t(b) * kBrickRows + i);
          const bool seen = visible.empty() || visible[b].test(i);
          const double expected = seen ? tv_derivative(values, topology->vertex(b, i), visible) : 0;
          REQUIRE(gradient.touched[b].test(i) == seen);
          REQUIRE(std::abs(g[0] - 0.5 * expected) <= (seen ? 2e-6 : 0));
          REQUIRE(g[1] == 0);
        }
    }
  }
  TEST_CASE("a share of the bricks estimates the whole without bias") {
    const Channels values = random_channels(make_dense_topology(make_lattice(kBox, 31)), 8, 4);
    const std::vector<float> tv = first_column(values, 1);
    Gradient whole(values);
    add_total_variation(values, tv, 1.0f, 1.0f, 0, {}, whole);
    std::vector<double> mean(values.values.size());
    const int draws = 400;
    for (int d = 0; d < draws; ++d) {
      Gradient part(values);
      add_total_variation(values, tv, 1.0f, 0.25f, 100 + d, {}, part);
      for (std::size_t i = 0; i < mean.size(); i += 8) mean[i] += part.values.values[i] / draws;
    }
    // The estimate of one entry g is 4 g with probability 1/4: standard error sqrt(3 / draws) |g|.
    double error = 0, size = 0;
    for (std::size_t i = 0; i < mean.size(); i += 8) {
      const double g = whole.values.values[i];
      error += (mean[i] - g) * (mean[i] - g);
      size += g * g;
    }
    CHECK(std::sqrt(error / size) <= 1.5 * std::sqrt(3.0 / draws));
  }
  TEST_CASE("an update moves touched rows by the rate and leaves the others bit for bit") {
    Channels values = random_channels(make_dense_topology(make_lattice(kBox, 7)), 8, 5);
    const Channels before = values;
    Learner learner(values);
    Gradient gradient(values);
    learner.rate[0] = 0.1f;
    const std::size_t row = kBrickRows + 77;
    gradient.values.row(row)[0] = 1e-3f;
    gradient.touched[1].set(77);
    update(learned(values, learner), gradient, moment_factors(0.9, 0.99, 1e-12, 1), 1.0f);
    CHECK(values.row(row)[0] == doctest::Approx(before.row(row)[0] - 0.1f).epsilon(1e-5));
    values.row(row)[0] = before.row(row)[0];
    CHECK(values.values == before.values);
    CHECK_FALSE(gradient.touched[1].any());
    CHECK(gradient.values.row(row)[0] == 0);
  }
  TEST_CASE("curve length has the gradient of a sum of squares, and of the bend at the end") {
    const Channels values = random_channels(make_dense_topology(make_lattice(kBox, 7)), 16, 6);
    Gradient gradient(values);
    MotionField motion;  // a Bezier curve of 5 points, the first pinned
    motion.points = 5;
    motion.first_point = FirstPoint::zero;
    add_curve_prior(values, motion, CurvePrior{.length = 0.5f}, 1.0f, 1, {}, gradient);
    const std::size_t row = kBrickRows + 5;
    const float *p = values.row(row), *g = gradient.values.row(row);
    for (int a = 0; a < 3; ++a) {
      CHECK(g[a] == doctest::Approx(p[a] - (p[3 + a] - p[a])).epsilon(1e-5));
      CHECK(g[9 + a] == doctest::Approx(p[9 + a] - 2 * p[6 + a] + p[3 + a]).epsilon(1e-5));
    }
    CHECK(g[12] == 0);
  }
  TEST_CASE("the static prior pulls by its weight at most, touches the rows it may and no others") {
    const Channels values = random_channels(make_dense_topology(make_lattice(kBox, 7)), 16, 6);
    Gradient gradient(values);
    MotionField motion;
    motion.points = 5;
    std::vector<RowMask> among(values.topology->bricks.size());
    among[1].set(5);
    among[1].set(77);
    add_curve_prior(values, motion, StaticPrior{.weight = 0.5f, .softening = 1e-3f}, 1.0f, 1, among,
                    gradient);
    for (int i = 0; i < kBrickRows; ++i) {
      const float* g = gradient.values.row(kBrickRows + i);
      float squares = 0;
      for (int k = 0; k < values.width; ++k) squares += g[k] * g[k];
      CHECK(gradient.touched[1].test(i) == among[1].test(i));
      if (among[1].test(i))
        CHECK((squares > 0 && std::sqrt(squares) <= 2 * 0.5f));  // |differences transposed| <= 2
      else
        CHECK(squares == 0);
    }
  }
}

TEST_SUITE("train/refine") {
  TEST_CASE("resampling a linear field onto a finer lattice is exact") {
    Channels coarse = random_channels(make_dense_topology(make_lattice(kBox, 10)), 8, 7);
    for (int b = 1; b <= coarse.topology->brick_count(); ++b)
      for (int i = 0; i < kBrickRows; ++i) {
        const Vec3 x = coarse.topology->position(b, i);
        coarse.row(std::size_t(b) * kBrickRows + i)[0] = 1 + x.x - 2 * x.y + 3 * x.z;
      }
    const Lattice lattice = make_lattice(kBox, 17);
    const Channels fine = resample(coarse, make_dense_topology(lattice));
    for (int v = 0; v < 18; ++v) {
      const Vec3 x = lattice.position({v, 17 - v, v / 2});
      CHECK(fine.row(std::size_t(row_of(*fine.topology, {v, 17 - v, v / 2}, {})))[0] ==
            doctest::Approx(1 + x.x - 2 * x.y + 3 * x.z).epsilon(1e-4));
    }
  }
  TEST_CASE("more control points leave the motion where it is") {
    for (const bool spline : {false, true})
      for (const bool light : {false, true}) {
        CAPTURE(spline);
        CAPTURE(light);
        MotionField motion;
        motion.basis = spline ? BasisKind::bspline : BasisKind::bezier;
        motion.first_point = spline ? FirstPoint::free : FirstPoint::zero;
        motion.points = 4;
        motion.light = light;
        motion.levels = {random_channels(make_dense_topology(make_lattice(kBox, 4)), motion.width(), 8)};
        MotionField raised = motion;
        elevate(raised);
        CHECK(raised.points == 5);
        for (const double t : {0.0, 0.3, 1.0}) {
          const MotionSlice a = make_slice(motion, stored_weights(motion, t)),
                            b = make_slice(raised, stored_weights(raised, t));
          for (std::size_t i = 0; i < a.values.size(); ++i)
            REQUIRE(std::abs(a.values[i] - b.values[i]) <= 1e-6f);
        }
      }
  }
  TEST_CASE("small parts on their own are dropped, thin ones that grow on something stay") {
    BitGrid grid(kBox, 20);
    for (int x = 5; x < 12; ++x)
      for (int y = 5; y < 12; ++y)
        for (int z = 5; z < 12; ++z) grid.set(grid.index({x, y, z}));
    for (int x = 12; x < 17; ++x) grid.set(grid.index({x, 8, 8}));  // a horn
    grid.set(grid.index({1, 1, 19}));                               // a floater
    const BitGrid kept = drop_small_parts(grid, 0.01f);
    CHECK(kept.count() == grid.count() - 1);
    CHECK_FALSE(kept.test(kept.index({1, 1, 19})));
    const Box box = bounding_box(kept, 0);
    CHECK(box.hi.x == doctest::Approx(-1 + 17 * 0.1));
    CHECK(box.hi.z == doctest::Approx(-1 + 12 * 0.1));
  }
}

TEST_SUITE("train/bounds and batches") {
  TEST_CASE("a picture that shows nothing says nothing of what lies outside it") {
    const Dataset data = make_synth("ball", {.frames = 40, .size = 32, .rig = {.cameras = 6}});
    Split train = *data.find("train");
    for (Frame& f : train.frames)
      if (f.camera_id == 3 && f.time >= 0.5) {  // it was turned round
        f.camera.axes[0] = -f.camera.axes[0];
        f.camera.axes[2] = -f.camera.axes[2];
        f.image = Image16{32, 32, std::vector<std::uint16_t>(std::size_t(4) * 32 * 32, 0)};
      }
    const SceneBounds bounds = find_bounds(train, true, 48, 0.05f);
    CHECK(check_ball_within(bounds, train, 4) > 200);
  }
  TEST_CASE("the hull of a moving ball holds the ball at every time and the rays reach it") {
    const Dataset data = make_synth("ball", {.frames = 40, .size = 64, .seed = 2});
    const Split& train = *data.find("train");
    const SceneBounds bounds = find_bounds(train, true, 48, 0.05f);
    CHECK(check_ball_within(bounds, train, 8) > 50);
    CHECK(bounds.box.extent().x < 4);

    SamplingConfig config;
    config.frames = 4;
    config.rays = 256;
    config.growth = 1;
    const BatchSampler sampler(train, bounds.box, config, 9);
    Batch a, b;
    std::set<int> used;
    for (int step = 0; step < 10; ++step) {
      sampler.draw(step, 1, 0.02f, {}, {}, a);
      CHECK(a.rays.size() == 256);
      used.insert(a.frames.begin(), a.frames.end());
    }
    CHECK(used.size() == 40);  // one round of the deck shows every frame once
    sampler.draw(3, 1, 0.02f, {}, {}, a);
    sampler.draw(3, 1, 0.02f, {}, {}, b);
    CHECK(a.targets == b.targets);
    sampler.draw(4, 1, 0.02f, {}, {}, b);
    CHECK(a.targets != b.targets);

    // What a picture shows as 1 is 1 or more; without `clipped` it is the float before it.
    Split white = train;
    for (Frame& frame : white.frames)
      frame.image = Image16{frame.image.width, frame.image.height,
                            std::vector<std::uint16_t>(4 * frame.image.pixels(), 65535)};
    for (const bool clipped : {true, false}) {
      SamplingConfig as = config;
      as.clipped = clipped;
      as.carve = 0;
      BatchSampler(white, bounds.box, as, 9).draw(0, 1, 0.02f, {}, {}, b);
      for (const Vec3& target : b.targets)
        for (int c = 0; c < 3; ++c)
          CHECK(target[c] == (clipped ? at_least(1.0f) : std::nextafter(1.0f, 0.0f)));
    }

    // Pictures of floats do not end at 1.
    Split bright = train;
    for (const float value : {1.0f, 3.0f}) {
      for (Frame& frame : bright.frames) {
        Image image(frame.image.width, frame.image.height, 4);
        for (std::size_t i = 0; i < image.data.size(); ++i) image.data[i] = i % 4 == 3 ? 1 : value;
        frame.image = Picture(image);
      }
      BatchSampler(bright, bounds.box, config, 9).draw(0, 1, 0.02f, {}, {}, b);
      for (const Vec3& target : b.targets)
        for (int c = 0; c < 3; ++c) CHECK(target[c] == value);
    }

    // A window of time: the middle frames first, all of them in the end.
    config.window = 0.25f;
    config.window_full = 0.5f;
    const BatchSampler growing(train, bounds.box, config, 9);
    const auto drawn_at = [&](double progress) {
      std::set<double> times;
      for (int step = 0; step < 40; ++step) {
        growing.draw(step, progress, 0.02f, {}, {}, a);
        for (const int f : a.frames) times.insert(train.frames[f].time);
      }
      return times;
    };
    CHECK(drawn_at(0).size() == 10);
    CHECK(*drawn_at(0).begin() > 0.3);
    CHECK(*drawn_at(0).rbegin() < 0.7);
    CHECK(drawn_at(0.25).size() == 25);
    CHECK_FALSE(growing.whole(0.49));
    CHECK(growing.whole(0.5));
    CHECK(drawn_at(0.5).size() == 40);
    Split together = train;  // a camera rig: all frames of one moment stay in the deck
    for (Frame& frame : together.frames) frame.time = 0;
    const BatchSampler rig(together, bounds.box, config, 9);
    used.clear();
    for (int step = 0; step < 10; ++step) {
      rig.draw(step, 0, 0.02f, {}, {}, a);
      used.insert(a.frames.begin(), a.frames.end());
    }
    CHECK(used.size() == 40);
    config.window = 1;

    // A step draws a moment once, from several of its cameras, and uses all cameras equally in the end.
    Split eight = train;  // 5 moments of 8 cameras
    for (std::size_t f = 0; f < eight.frames.size(); ++f) eight.frames[f].time = double(f / 8) / 4;
    config.frames = 20;
    const BatchSampler moments(eight, bounds.box, config, 9);
    config.frames = 4;
    std::set<int> first;
    for (int step = 0; step < 8; ++step) {
      moments.draw(step, 1, 0.02f, {}, {}, a);
      CHECK(a.frames.size() == 5);
      CHECK(std::set<double>(a.times.begin(), a.times.end()).size() == 5);
      for (std::size_t slot = 0; slot < a.frames.size(); ++slot)
        CHECK(a.times[slot] == eight.frames[std::size_t(a.frames[slot])].time);
      first.insert(a.frames.begin(), a.frames.end());
    }
    CHECK(first.size() >= 10);

    // Carving: cameras of other times look past their silhouettes, and the scene is nowhere on those rays at
    // the slot's time.
    config.rays = 2048;
    config.carve = 0.9f;
    config.background = BackgroundKind::fixed;
    const SynthScene scene = SynthScene::open("ball");
    const BatchSampler carver(train, bounds.box, config, 9);
    int carved = 0;
    for (int step = 0; step < 4; ++step) {
      carver.draw(step, 1, 0.02f, {}, {}, a);
      for (const RayTask& task : a.tasks) {
        const Frame& own = train.frames[a.frames[task.slot]];
        const SynthMoment moment = scene.at(own.time);
        for (int i = task.first; i < task.last; ++i) {
          const Vec3d origin = cast<double>(a.rays[i].origin), direction = cast<double>(a.rays[i].direction);
          const bool missed = a.rays[i].count == 0;
          if (missed || length(cross(origin - own.camera.position, direction)) < 1e-3)
            continue;  // or of the slot's own camera
          ++carved;
          CHECK(colour_of(a.targets[i]) == Vec3{1, 1, 1});
          CHECK_FALSE(moment.trace({origin, direction}).has_value());
        }
      }
    }
    CHECK(carved > 500);
  }
}
