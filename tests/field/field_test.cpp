// SPDX-License-Identifier: Apache-2.0
#include <doctest/doctest.h>

#include <cmath>
#include <random>
#include <vector>

#include "field/lattice/lattice_view.hpp"
#include "field/lattice/levels.hpp"
#include "field/lattice/slice.hpp"
#include "splinevox/field/sample.hpp"

using namespace splinevox;

namespace {

const Box kBox{{-1, -0.5f, 0}, {1, 0.5f, 1}};

Channels random_channels(TopologyPtr topology, int width, unsigned seed, float size) {
  const std::vector<float> zero(width, 0.0f);
  Channels c = make_channels(std::move(topology), width, zero.data());
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(-size, size);
  for (std::size_t i = std::size_t(kBrickRows) * width; i < c.values.size(); ++i)
    c.values[i] = uniform(random);
  return c;
}

/// Sets one column of every stored row to f(position of its vertex).
template <class F>
void fill(Channels& c, int column, F&& f) {
  for (int b = 1; b <= c.topology->brick_count(); ++b)
    for (int i = 0; i < kBrickRows; ++i)
      c.row(std::size_t(b) * kBrickRows + i)[column] = f(c.topology->position(b, i));
}

MotionField three_levels(unsigned seed) {
  MotionField m;
  m.basis = BasisKind::bezier;
  m.points = 5;
  m.first_point = FirstPoint::zero;
  for (int l = 0; l < 3; ++l)
    m.levels.push_back(random_channels(make_dense_topology(make_lattice(kBox, 4 << l)), 16, seed + l, 0.1f));
  return m;
}

}  // namespace

TEST_SUITE("field/topology") {
  TEST_CASE("a lattice covers its box and a brick's number depends only on the set of bricks") {
    const Lattice lattice = make_lattice(kBox, 20);
    CHECK(lattice.size == Int3{21, 11, 11});
    CHECK(lattice.spacing == doctest::Approx(0.1));
    const auto a = make_topology(lattice, {{2, 0, 1}, {0, 1, 0}, {0, 0, 0}});
    const auto b = make_topology(lattice, {{0, 0, 0}, {2, 0, 1}, {0, 1, 0}});
    CHECK(a->table == b->table);
    CHECK(a->brick_count() == 3);
    CHECK(a->brick_at({2, 0, 1}) == 3);
    CHECK(a->brick_at({1, 0, 0}) == 0);
    CHECK(a->brick_at({-1, -1, -1}) == 0);
  }
}

TEST_SUITE("field/channels") {
  TEST_CASE(
      "bricks that hold something stay, with those that share a cell with it, and their rows as they were") {
    const float empty[8] = {-10};
    Channels c = make_channels(make_dense_topology(make_lattice(kBox, 38)), 8, empty);  // 5 x 3 x 3 bricks
    const auto row_of = [](const Channels& in, Int3 v) {
      return LatticeView{in.topology->table.data(), in.topology->bricks.data(), in.topology->dims,
                         in.topology->brick_count()}
          .row_of(v);
    };
    for (std::size_t r = kBrickRows; r < c.topology->rows(); ++r) c.row(r)[1] = float(r);
    const Int3 inside{20, 11, 3}, edge{16, 8, 5}, corner{39, 0, 0};
    const auto kept_for = [&](std::vector<Int3> vertices) {
      Channels d = c;
      for (const Int3 v : vertices) d.row(row_of(d, v))[0] = 1;
      std::vector<Int3> at;
      for (const std::int32_t b : bricks_above(d, -10)) at.push_back(d.topology->bricks[b]);
      return at;
    };
    CHECK(kept_for({}).empty());
    CHECK(kept_for({inside}) == std::vector<Int3>{{2, 1, 0}});
    CHECK(kept_for({edge}) == std::vector<Int3>{{1, 0, 0}, {1, 1, 0}, {2, 0, 0}, {2, 1, 0}});
    CHECK(kept_for({corner}) == std::vector<Int3>{{4, 0, 0}});  // beyond the lattice there is nothing to keep
    CHECK(kept_for({edge, corner}).size() == 5);

    Channels d = c;
    d.row(row_of(d, edge))[0] = d.row(row_of(d, corner))[0] = 1;
    const std::vector<std::int32_t> kept = bricks_above(d, -10);
    keep_rows(kept, d.width, d.values);
    d.topology = keep_bricks(*c.topology, kept);
    CHECK(d.values.size() == d.topology->rows() * 8);
    CHECK(d.row(0)[0] == -10);
    CHECK(d.row(row_of(d, edge))[0] == 1);
    for (const Int3 v : {edge, corner, Int3{15, 7, 7}, Int3{23, 15, 0}})
      CHECK(d.row(row_of(d, v))[1] == c.row(row_of(c, v))[1]);
    CHECK(d.topology->brick_at({2, 2, 2}) == 0);
  }
}

TEST_SUITE("field/slice") {
  TEST_CASE("light without motion: a slice holds the light's curve alone, and its adjoint is the transpose") {
    MotionField m;
    m.basis = BasisKind::bspline;
    m.first_point = FirstPoint::free;
    m.points = 9;
    m.displaces = m.rigidity = false;
    m.light = true;
    CHECK(m.stride() == 1);
    CHECK(m.rigidity_column() == 9);
    m.levels = {random_channels(make_dense_topology(make_lattice(kBox, 8)), m.width(), 4, 1.0f)};
    CHECK_FALSE(m.moves());
    for (const double t : {0.0, 0.31, 1.0}) {
      const BasisWeights<float> w = stored_weights(m, t);
      const MotionSlice slice = make_slice(m, w);
      Channels gradient = random_channels(m.levels[0].topology, m.width(), 1, 0.0f);
      AlignedVector<float> back(std::size_t(kBrickRows) * kSliceWidth);
      for (int i = 0; i < kBrickRows; ++i) {
        const float* row = m.levels[0].row(kBrickRows + i);
        const float* out = slice.values.data() + std::size_t(kBrickRows + i) * kSliceWidth;
        double light = 0;
        for (int k = 0; k < 9; ++k) light += double(w[k]) * row[k];
        CHECK(out[4] == doctest::Approx(light).epsilon(1e-5));
        for (const int lane : {0, 1, 2, 3}) CHECK(out[lane] == 0);
        back[std::size_t(i) * kSliceWidth + 4] = float(i);
        back[std::size_t(i) * kSliceWidth] = 7;  // displacement: not stored, not learned
      }
      expand_brick(m, w, RowMask::all(), back.data(), 1, gradient);
      for (int i = 0; i < kBrickRows; ++i)
        for (int k = 0; k < m.width(); ++k)
          CHECK(gradient.row(kBrickRows + i)[k] == (k < 9 ? w[k] * float(i) : 0.0f));
    }
  }
}

TEST_SUITE("field/levels") {
  TEST_CASE("levels summed into one give the same motion everywhere") {
    const MotionField levels = three_levels(5), one = collapse(levels);
    REQUIRE(one.levels.size() == 1);
    VoxelModel model;
    model.box = kBox;
    model.radiance.raw = random_channels(make_dense_topology(make_lattice(kBox, 8)), 8, 1, 1);
    std::mt19937 random(3);
    std::uniform_real_distribution<float> uniform(0.02f, 0.98f);
    for (int trial = 0; trial < 100; ++trial) {
      const float t = uniform(random);
      const Vec3 e = kBox.extent(),
                 x = kBox.lo + Vec3{e.x * uniform(random), e.y * uniform(random), e.z * uniform(random)};
      Vec3 sum{};
      float rho = 0;
      for (const Channels& level : levels.levels) {
        model.motion = levels;
        model.motion.levels = {level};
        model.motion.rigidity = false;
        sum += FrameSampler(model, t).warp(x).displacement;
        model.motion.rigidity = true;
        const float r = FrameSampler(model, t).warp(x).rigidity;
        rho += std::log(r / (1 - r));
      }
      model.motion = one;
      const auto whole = FrameSampler(model, t).warp(x);
      CHECK(whole.rigidity == doctest::Approx(1 / (1 + std::exp(-rho))).epsilon(1e-4));
      for (int a = 0; a < 3; ++a) CHECK(std::abs(whole.displacement[a] - whole.rigidity * sum[a]) <= 2e-6f);
    }
  }
  TEST_CASE("restriction is the adjoint of prolongation, absent bricks included") {
    const Lattice coarse_lattice = make_lattice(kBox, 16), fine_lattice = make_lattice(kBox, 32);
    const auto coarse_topology = make_topology(coarse_lattice, {{0, 0, 0}, {1, 0, 0}, {1, 1, 1}});
    const auto fine_topology = make_topology(fine_lattice, {{0, 0, 0}, {2, 1, 1}, {3, 1, 0}, {1, 0, 0}});
    const Channels x = random_channels(coarse_topology, 8, 7, 1), y = random_channels(fine_topology, 8, 8, 1);
    Channels px = random_channels(fine_topology, 8, 0, 0), ry = random_channels(coarse_topology, 8, 0, 0);
    for (int b = 1; b <= fine_topology->brick_count(); ++b) prolong_brick(x, px, b, RowMask::all());
    RowMask touched;
    const std::vector<RowMask> all(fine_topology->bricks.size(), RowMask::all());
    for (int b = 1; b <= coarse_topology->brick_count(); ++b) restrict_brick(y, all, ry, b, touched);
    double forward = 0, adjoint = 0;
    for (std::size_t i = 0; i < y.values.size(); ++i) forward += double(px.values[i]) * y.values[i];
    for (std::size_t i = 0; i < x.values.size(); ++i) adjoint += double(ry.values[i]) * x.values[i];
    CHECK(forward != 0);
    CHECK(forward == doctest::Approx(adjoint).epsilon(1e-6));
  }
  TEST_CASE("a mask of rows leaves the others alone, and only what something arrives at is marked") {
    const auto coarse_topology = make_dense_topology(make_lattice(kBox, 16)),
               fine_topology = make_dense_topology(make_lattice(kBox, 32));
    const Channels x = random_channels(coarse_topology, 8, 3, 1);
    Channels whole = random_channels(fine_topology, 8, 0, 0), part = whole;
    RowMask some;
    for (int i = 0; i < kBrickRows; i += 3) some.set(i);
    prolong_brick(x, whole, 2, RowMask::all());
    prolong_brick(x, part, 2, some);
    for (int i = 0; i < kBrickRows; ++i)
      CHECK(part.row(2 * kBrickRows + i)[1] == (some.test(i) ? whole.row(2 * kBrickRows + i)[1] : 0));
    // One fine row, odd along two axes: it arrives at four coarse ones.
    std::vector<RowMask> rows(fine_topology->bricks.size());
    rows[1].set(3 * 64 + 5 * 8 + 2);
    Channels y = random_channels(coarse_topology, 8, 0, 0);
    RowMask touched;
    restrict_brick(whole, rows, y, 1, touched);
    int count = 0;
    touched.for_each([&](int i) {
      CHECK((i == 1 * 64 + 2 * 8 + 1 || i == 2 * 64 + 2 * 8 + 1 || i == 1 * 64 + 3 * 8 + 1 ||
             i == 2 * 64 + 3 * 8 + 1));
      ++count;
    });
    CHECK(count == 4);
  }
}

TEST_SUITE("field/slice") {
  TEST_CASE("expansion is the adjoint of contraction and clears the rows it has read") {
    for (const int scalars : {0, 1, 2}) {
      MotionField m = three_levels(9);
      m.light = scalars > 0;
      m.presence = scalars > 1;
      if (m.presence) m.first_point = FirstPoint::free;
      m.levels[0] = random_channels(m.levels[0].topology, m.width(), 9, 0.1f);
      const int lanes = 4 + scalars;
      const Channels& level = m.levels[0];
      const BasisWeights<float> w = stored_weights(m, 0.3);
      std::vector<float> slice(level.topology->rows() * kSliceWidth), g(slice.size());
      float* const values = slice.data();
      for (int b = 0; b <= level.topology->brick_count(); ++b)
        contract_brick(m, level, {&w, 1}, b, RowMask::all(), {&values, 1});
      std::mt19937 random(1);
      std::vector<RowMask> rows(level.topology->brick_count() + 1);
      for (std::size_t row = kBrickRows; row < level.topology->rows(); ++row)
        if (random() % 3 == 0) {
          for (int c = 0; c < lanes; ++c) g[row * kSliceWidth + c] = float(random() % 100) / 100 + 0.01f;
          rows[row / kBrickRows].set(int(row % kBrickRows));
        }
      std::vector<float> read = g;
      Channels expanded = random_channels(level.topology, level.width, 0, 0);
      double forward = 0, adjoint = 0;
      for (int b = 1; b <= level.topology->brick_count(); ++b)
        expand_brick(m, w, rows[b], read.data() + std::size_t(b) * kBrickRows * kSliceWidth, b, expanded);
      for (int b = 1; b <= level.topology->brick_count(); ++b) centre_brick(m, rows[b], b, expanded);
      CHECK(std::all_of(read.begin(), read.end(), [](float x) { return x == 0; }));
      for (std::size_t i = 0; i < g.size(); ++i) forward += double(slice[i]) * g[i];
      for (std::size_t i = 0; i < level.values.size(); ++i)
        adjoint += double(level.values[i]) * expanded.values[i];
      CHECK(forward == doctest::Approx(adjoint).epsilon(1e-5));
    }
  }
  TEST_CASE("light is a curve of one number beside the control points, and 1 where there is none") {
    VoxelModel model;
    model.radiance.raw = random_channels(make_dense_topology(make_lattice(kBox, 8)), 8, 1, 1);
    MotionField& m = model.motion;
    m.basis = BasisKind::bspline;
    m.points = 6;
    m.first_point = FirstPoint::free;
    m.rigidity = false;
    m.light = true;
    m.levels = {random_channels(make_dense_topology(make_lattice(kBox, 8)), m.width(), 2, 0.3f)};
    const BasisWeights<float> w = stored_weights(m, 0.4);
    const FrameSampler sampler(model, 0.4);
    const Topology& t = *m.levels[0].topology;
    for (const int i : {5 * 64 + 3 * 8 + 2, 7 * 64 + 4 * 8 + 1}) {
      float sum[4] = {};
      for (int k = 0; k < 6; ++k)
        for (int c = 0; c < 4; ++c) sum[c] += w[k] * m.levels[0].row(kBrickRows + i)[4 * k + c];
      const FrameSampler::Warp warp = sampler.warp(t.position(1, i));
      for (int a = 0; a < 3; ++a) CHECK(warp.displacement[a] == doctest::Approx(sum[a]).epsilon(1e-4));
      CHECK(warp.light == doctest::Approx(2 / (1 + std::exp(-sum[3]))).epsilon(1e-4));
    }
    m.light = false;
    m.levels = {random_channels(m.levels[0].topology, m.width(), 3, 0.3f)};
    CHECK(FrameSampler(model, 0.4).warp(t.position(1, 100)).light == 1.0f);
  }
  TEST_CASE("presence has no mean over time, whatever the basis, and the density is that of the sum") {
    for (const Basis& basis : all_bases()) {
      CAPTURE(basis.name);
      VoxelModel model;
      model.radiance.raw = random_channels(make_dense_topology(make_lattice(kBox, 8)), 8, 1, 1);
      MotionField& m = model.motion;
      m.basis = basis.kind;
      m.points = 10;
      m.first_point = FirstPoint::free;
      m.displaces = m.rigidity = false;
      m.presence = true;
      m.levels = {random_channels(make_dense_topology(make_lattice(kBox, 8)), m.width(), 2, 1.0f)};
      const Vec3 x = m.levels[0].topology->position(1, 5 * 64 + 3 * 8 + 2) + Vec3{0.01f, 0, 0};
      constexpr int kTimes = 4000;
      double sum = 0, least = 0, most = 0;
      for (int i = 0; i < kTimes; ++i) {
        const FrameSampler sampler(model, (i + 0.5) / kTimes);
        const double p = sampler.warp(x).presence;
        sum += p;
        least = std::min(least, p);
        most = std::max(most, p);
        if (i % 500 == 0) {
          const float raw = std::log(std::expm1(sampler.radiance(x).density));
          CHECK(sampler.density(x) == doctest::Approx(std::log1p(std::exp(raw + float(p)))).epsilon(1e-4));
        }
      }
      CHECK(most - least > 0.1);
      CHECK(std::abs(sum / kTimes) < 1e-4 * (most - least));
    }
  }
  TEST_CASE("a pinned Bezier curve does not move anything at t = 0") {
    const MotionField m = collapse(three_levels(11));
    const MotionSlice slice = make_slice(m, stored_weights(m, 0));
    for (std::size_t i = 0; i < slice.values.size(); i += kSliceWidth)
      for (int a = 0; a < 3; ++a) REQUIRE(slice.values[i + a] == 0.0f);
  }
}

TEST_SUITE("field/sample") {
  TEST_CASE("a linear field is reproduced exactly, a constant curve translates, outside is empty") {
    VoxelModel model;
    model.box = kBox;
    model.radiance.activation = {10, 0};
    model.radiance.raw = random_channels(make_dense_topology(make_lattice(kBox, 10)), 8, 1, 0);
    fill(model.radiance.raw, 0, [](Vec3 x) { return 1 + x.x - 2 * x.y + 0.5f * x.z; });
    model.motion.points = 3;
    model.motion.first_point = FirstPoint::free;
    model.motion.rigidity = false;
    model.motion.levels = {random_channels(make_dense_topology(make_lattice(kBox, 5)), 16, 1, 0)};
    for (int k = 0; k < 3; ++k) fill(model.motion.levels[0], 3 * k, [](Vec3) { return 0.25f; });
    const FrameSampler sampler(model, 0.6);
    const Vec3 x{0.13f, -0.07f, 0.4f};
    const auto warp = sampler.warp(x);
    CHECK(warp.displacement.x == doctest::Approx(0.25));
    CHECK(warp.displacement.y == 0);
    CHECK(std::abs(warp.velocity_to_canonical.x) <= 1e-6f);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) CHECK(std::abs(warp.gradient[i][j]) <= 1e-5f);
    const Vec3 c = sampler.canonical(x);
    const float raw = 1 + c.x - 2 * c.y + 0.5f * c.z;
    CHECK(sampler.radiance(c).density == doctest::Approx(10 * std::log1p(std::exp(raw))).epsilon(1e-5));
    CHECK(sampler.radiance({5, 0, 0.5f}).density == 0);
    CHECK(sampler.radiance({0, 0, NAN}).density == 0);
  }
  TEST_CASE("the warp's gradient and time derivative are those of its displacement") {
    VoxelModel model;
    model.box = kBox;
    model.radiance.raw = random_channels(make_dense_topology(make_lattice(kBox, 8)), 8, 1, 1);
    model.motion = collapse(three_levels(21));
    const float h = 1e-3f;
    const Vec3 x{0.137f, 0.111f, 0.513f};
    const double t = 0.41;
    const FrameSampler now(model, t), before(model, t - h), after(model, t + h);
    const auto warp = now.warp(x);
    for (int j = 0; j < 3; ++j) {
      Vec3 step{};
      step[j] = h;
      const Vec3 d = (now.warp(x + step).displacement - now.warp(x - step).displacement) * (1 / (2 * h));
      for (int i = 0; i < 3; ++i) CHECK(std::abs(warp.gradient[i][j] - d[i]) <= 2e-3f);
    }
    const Vec3 dt = (after.warp(x).displacement - before.warp(x).displacement) * (1 / (2 * h));
    for (int i = 0; i < 3; ++i) CHECK(std::abs(warp.velocity_to_canonical[i] - dt[i]) <= 2e-3f);
  }
}
