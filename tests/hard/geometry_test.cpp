// SPDX-License-Identifier: Apache-2.0
// Hard cases H13 to H15, H27 and H28 of docs/numerics.md: rays, boxes, lattices, directions, cameras.
#include <doctest/doctest.h>

#include <bit>
#include <limits>
#include <optional>
#include <random>

#include "core/rng.hpp"
#include "data/camera_check.hpp"
#include "hard/column.hpp"
#include "hard/measured.hpp"
#include "math/sh.hpp"
#include "math/view_factor.hpp"
#include "render/field_view.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/render/render_image.hpp"
#include "support/blob_model.hpp"
#include "support/tiny_dataset.hpp"

using namespace splinevox;
using namespace splinevox::test;

namespace {

/// num / den, den > 0; products fit into 128 bit.
struct Fraction {
  __int128 num, den;
  friend bool operator<(const Fraction& a, const Fraction& b) { return a.num * b.den < b.num * a.den; }
  double value() const { return double((long double)(num) / (long double)(den)); }
};

struct ExactInterval {
  Fraction near{0, 1}, far{1, 0};  // far: infinity
};

/// The slab test in rationals; none for a miss.
std::optional<ExactInterval> exact_intersect(const int (&lo)[3], const int (&hi)[3], const int (&o)[3],
                                             const int (&d)[3]) {
  ExactInterval s;
  for (int a = 0; a < 3; ++a) {
    if (d[a] == 0) {
      if (o[a] < lo[a] || o[a] > hi[a]) return {};
      continue;
    }
    const int sign = d[a] > 0 ? 1 : -1;
    Fraction enter{sign * (lo[a] - o[a]), sign * d[a]}, leave{sign * (hi[a] - o[a]), sign * d[a]};
    if (leave < enter) std::swap(enter, leave);
    if (s.near < enter) s.near = enter;
    if (leave < s.far) s.far = leave;
  }
  if (s.far < s.near) return {};
  return s;
}

/// A model moved to units `scale` times as long, a power of two: every length and its inverse change exactly.
VoxelModel in_units(VoxelModel m, float scale) {
  const auto move = [&](Channels& c) {
    Topology t = *c.topology;
    t.lattice.origin = scale * t.lattice.origin;
    t.lattice.spacing *= scale;
    c.topology = std::make_shared<Topology>(t);
  };
  m.box = {scale * m.box.lo, scale * m.box.hi};
  m.step *= scale;
  m.radiance.activation.scale /= scale;
  move(m.radiance.raw);
  for (Channels& level : m.motion.levels) {
    move(level);
    for (std::size_t r = 0; r < level.topology->rows(); ++r)
      for (int k = 0; k < m.motion.stored_points(); ++k)
        for (int a = 0; a < 3; ++a) level.row(r)[m.motion.stride() * k + a] *= scale;
  }
  return m;
}

Camera camera_at(Vec3d position, int size = 24) {
  const Vec3d back = normalize(position), right = normalize(cross(Vec3d{0, 0, 1}, back));
  return {size,    size, 1.2 * size, 1.2 * size, 0.5 * size, 0.5 * size, {{right, cross(back, right), back}},
          position};
}

}  // namespace

TEST_SUITE("hard/geometry") {
  TEST_CASE("H13: ray and box agree with exact fractions, on faces, edges and corners too") {
    std::mt19937 random(13);
    Worst error;
    int wrong = 0, hits = 0;
    const auto check = [&](const int(&o)[3], const int(&d)[3]) {
      const int lo[3] = {-3, -2, -5}, hi[3] = {4, 6, 1};
      const auto exact = exact_intersect(lo, hi, o, d);
      const Interval got = intersect({{-3, -2, -5}, {4, 6, 1}}, {double(o[0]), double(o[1]), double(o[2])},
                                     {double(d[0]), double(d[1]), double(d[2])});
      const double scale = 30;
      // A line that only touches an edge has length 0; rounding may take it either way.
      if (exact && !(exact->near < exact->far)) return;
      wrong += exact.has_value() != (got.far >= got.near);
      if (!exact) return;
      ++hits;
      error.see(std::abs(got.near - exact->near.value()) / scale / kUnitDouble);
      error.see(std::abs(got.far - exact->far.value()) / scale / kUnitDouble);
    };
    for (int trial = 0; trial < 1000000; ++trial) {
      int o[3], d[3];
      for (int a = 0; a < 3; ++a) {
        o[a] = int(random() % 31) - 15;
        d[a] = int(random() % 21) - 10;
      }
      if (d[0] == 0 && d[1] == 0 && d[2] == 0) continue;
      check(o, d);
    }
    for (const int x : {-4, -3, 0, 4, 5})
      for (const int y : {-3, -2, 0, 6, 7})
        for (const int z : {-6, -5, 0, 1, 2})
          for (int code = 0; code < 27; ++code)
            if (code != 13) check({x, y, z}, {code % 3 - 1, code / 3 % 3 - 1, code / 9 - 1});
    CHECK(hits > 40000);
    CHECK(wrong == 0);
    measured("H13 entry and exit, of the distances", error.value, 4, "u of double");

    // Directions too small to divide by, from every face: what the origin says, and never NaN.
    const Box box{{-1, -1, -1}, {1, 1, 1}};
    for (const double tiny : {0.0, -0.0, 5e-324, -5e-324, 1e-310, -1e-310, 1e-300})
      for (const double at : {-1.0, 1.0, 0.0, -0.0}) {
        CAPTURE(tiny);
        CAPTURE(at);
        const Interval s = intersect(box, {at, -3, 0}, {tiny, 1, 0});
        CHECK(s.near == 2);
        CHECK(s.far == 4);
        CHECK(intersect(box, {1.5, -3, 0}, {tiny, 1, 0}).far < 0);
      }
  }
  TEST_CASE("H14: sample i is at origin + i step, however many, and from however far the camera looks") {
    // 4000 steps of 0.005: t += dt would be a whole step off after 1000 of them at t = 1000.
    const int cells = 32;
    const TopologyPtr t =
        make_dense_topology({{-1, -1, -1}, 2.0f / cells, {cells + 1, cells + 1, cells + 1}});
    std::vector<float> rows(t->rows() * RayKernel<float, -1>::kWidth, 0.0f);
    for (std::size_t r = 0; r < t->rows(); ++r) rows[r * 8] = -20;
    FieldView<float> field;
    field.radiance = BrickView<float>(*t);
    field.radiance_rows = rows.data();
    field.density_scale = 1;
    field.step = 5e-4f;
    Worst near_error, far_error;
    const Box box{{-1, -1, -1}, {1, 1, 1}};
    for (const double distance : {3.0, 1e3, 1e6, 1e9}) {
      const Vec3d d = normalize(Vec3d{0.9, 0.31, 0.22});
      const Ray ray{Vec3d{0.05, -0.1, 0.07} - distance * d, d};
      const RayInput<float> in = clip_ray(ray, box, field.step, 0.5f, {});
      REQUIRE(in.count > 4000);
      StillKernel<float, -1> kernel;
      kernel.forward(in, field, FrameView<float>{}, 0);
      REQUIRE(kernel.count == in.count);
      const Interval inside = intersect(box, ray.origin, ray.direction);
      for (int i = 0; i < in.count; i += 37) {
        const Vec3d want = ray.origin + (inside.near + (i + 0.5) * double(field.step)) * d;
        // Where the kernel was: its cell and fraction.
        const auto& s = kernel.samples[i];
        const Int3 brick{s.radiance_cell.slot / (t->dims.y * t->dims.z) - 1,
                         s.radiance_cell.slot / t->dims.z % t->dims.y - 1,
                         s.radiance_cell.slot % t->dims.z - 1};
        const Vec3d vertex{double(8 * brick.x + s.radiance_cell.x()),
                           double(8 * brick.y + s.radiance_cell.y()),
                           double(8 * brick.z + s.radiance_cell.z())};
        for (int a = 0; a < 3; ++a) {
          const double got = -1 + (vertex[a] + double(s.radiance_fraction[a])) * 2 / cells;
          (distance < 1e6 ? near_error : far_error)
              .see((std::abs(got - want[a]) - distance * 4 * kUnitDouble) / kUnit);
        }
      }
    }
    measured("H14 position of 4000 samples, camera up to 1e3 away, of 1", near_error.value, 1);
    measured("H14 camera up to 1e9 away, beyond the double's own rounding", far_error.value, 1);

    // The same picture in units from 1e-6 to 1e6, bit for bit where the unit is a power of two.
    const VoxelModel model = blob_model(32, {});
    const Rendered here = render_image(model, camera_at({2.5, 1.5, 1}), 0.6);
    for (const int power : {-20, -10, 10, 20}) {
      const float scale = std::ldexp(1.0f, power);
      const Rendered there =
          render_image(in_units(model, scale), camera_at(double(scale) * Vec3d{2.5, 1.5, 1}), 0.6);
      CHECK(there.rgb.data == here.rgb.data);
      CHECK(there.alpha.data == here.alpha.data);
    }
  }
  TEST_CASE(
      "H15: any position, NaN and infinity included, finds rows that exist; values are continuous across "
      "faces") {
    const TopologyPtr t =
        make_topology({{-1, -1, -1}, 0.25f, {20, 12, 9}}, {{0, 0, 0}, {2, 1, 0}, {1, 1, 1}});
    const BrickView<float> view(*t);
    const Rng rng(15, 0);
    const auto base = [&](float x, int axis) { return int(view.coordinate(x, axis)); };
    bool inside = true;
    for (std::uint64_t i = 0; i < 4000000; ++i) {
      const std::uint64_t bits = rng.bits(i), more = rng.bits(i + (std::uint64_t(1) << 40));
      const float x[3] = {std::bit_cast<float>(std::uint32_t(bits)),
                          std::bit_cast<float>(std::uint32_t(bits >> 32)),
                          std::bit_cast<float>(std::uint32_t(more))};
      const Cell cell = view.cell(base(x[0], 0), base(x[1], 1), base(x[2], 2));
      inside &= cell.slot >= 0 && std::size_t(cell.slot) < t->table.size();
      for (const std::int32_t row : view.rows(cell).row) inside &= row >= 0 && std::size_t(row) < t->rows();
    }
    const float odd[] = {std::nanf(""),
                         -std::nanf(""),
                         INFINITY,
                         -INFINITY,
                         -0.0f,
                         0.0f,
                         3e38f,
                         -3e38f,
                         1e-45f,
                         -1,
                         std::nextafter(-1.0f, -2.0f),
                         3.75f,
                         4};
    for (const float x : odd)
      for (const float y : odd)
        for (const float z : odd) {
          const Cell cell = view.cell(base(x, 0), base(y, 1), base(z, 2));
          inside &= cell.slot >= 0 && std::size_t(cell.slot) < t->table.size();
          for (const std::int32_t row : view.rows(cell).row)
            inside &= row >= 0 && std::size_t(row) < t->rows();
        }
    CHECK(inside);

    Worst jump, sum;
    std::mt19937 random(15);
    std::uniform_real_distribution<float> uniform(0, 1);
    for (int trial = 0; trial < 100000; ++trial) {
      // Two cells beside each other share the face at fraction 1 and 0.
      float corner[12];
      for (float& c : corner) c = 2 * uniform(random) - 1;
      const float y = uniform(random), z = uniform(random);
      float w[8], left = 0, right = 0, total = 0;
      trilinear_weights(Vec3{std::nextafter(1.0f, 0.0f), y, z}, w);
      for (int c = 0; c < 8; ++c) {
        left += w[c] * corner[c];
        total += w[c];
      }
      sum.see(std::abs(double(total) - 1) / kUnit);
      trilinear_weights(Vec3{0, y, z}, w);
      for (int c = 0; c < 8; ++c) right += w[c] * corner[4 + c];
      jump.see(std::abs(double(left) - right) / kUnit);
    }
    measured("H15 jump of a value across a face, of the corners", jump.value, 8);
    measured("H15 sum of the eight weights", sum.value, 4);
  }
  TEST_CASE(
      "H27: rays have unit length, harmonics are orthonormal and turn into each other, the view factor is "
      "bounded") {
    Worst unit, gram, energy;
    const Camera camera = camera_at({2.5, 1.5, 1e6}, 32);
    for (int y = 0; y < 32; ++y)
      for (int x = 0; x < 32; ++x)
        unit.see(std::abs(length(camera_ray(camera, x + 0.5, y + 0.5).direction) - 1) / kUnitDouble);
    // Gauss-Legendre of 8 points in z and 16 angles: exact for products of order 3.
    const double node[] = {0.1834346424956498, 0.5255324099163290, 0.7966664774136267, 0.9602898564975363};
    const double weight[] = {0.3626837833783620, 0.3137066458778873, 0.2223810344533745, 0.1012285362903763};
    double g[16][16] = {};
    for (int k = 0; k < 8; ++k)
      for (int j = 0; j < 16; ++j) {
        const double z = k < 4 ? node[k] : -node[k - 4], r = std::sqrt(1 - z * z), a = 2 * M_PI * j / 16;
        double v[16];
        sh_basis(3, Vec3d{r * std::cos(a), r * std::sin(a), z}, v);
        for (int p = 0; p < 16; ++p)
          for (int q = 0; q < 16; ++q) g[p][q] += v[p] * v[q] * weight[k % 4] * 2 * M_PI / 16;
        // Bands turn into themselves: the sum of squares of each is the same in every direction.
        for (int band = 0; band <= 3; ++band) {
          double squares = 0;
          for (int m = band * band; m < (band + 1) * (band + 1); ++m) squares += v[m] * v[m];
          energy.see(std::abs(squares * 4 * M_PI / (2 * band + 1) - 1) / kUnitDouble);
        }
      }
    for (int p = 0; p < 16; ++p)
      for (int q = 0; q < 16; ++q) gram.see(std::abs(g[p][q] - (p == q)));
    for (const float q : {-1e30f, 1e30f, -88.0f, 88.0f, 0.0f}) {
      CHECK(view_factor(q).value >= 0.5f);
      CHECK(view_factor(q).value <= 1.0f);
    }
    measured("H27 length of a ray's direction", unit.value, 4, "u of double");
    measured("H27 Gram matrix of 16 harmonics", gram.value, 1e-13, "");
    measured("H27 energy of a band over directions", energy.value, 40, "u of double");
  }
  TEST_CASE("H28: thirty cameras: the rigid ones come through, every other is refused by name") {
    using Matrix = std::array<double, 16>;
    const double nan = std::nan(""), inf = std::numeric_limits<double>::infinity();
    const auto with = [](std::size_t i, double v) {
      Matrix m = orbit_matrix(0.3);
      m[i] = v;
      return m;
    };
    const auto scaled = [](double x, double y, double z) {
      Matrix m = orbit_matrix(0.3);
      for (std::size_t row = 0; row < 3; ++row) {
        m[4 * row] *= x;
        m[4 * row + 1] *= y;
        m[4 * row + 2] *= z;
      }
      return m;
    };
    const Matrix good[] = {orbit_matrix(0),
                           orbit_matrix(1),
                           orbit_matrix(3),
                           orbit_matrix(6),
                           with(3, 0),
                           with(3, 1e6),
                           with(7, -1e12),
                           scaled(1 + 5e-4, 1 + 5e-4, 1 + 5e-4),
                           scaled(1 - 5e-4, 1 - 5e-4, 1 - 5e-4),
                           scaled(1.0002, 0.9999, 1)};
    const Matrix bad[] = {with(0, nan),          with(5, nan),
                          with(3, nan),          with(3, inf),
                          with(11, -inf),        with(7, 1e13),
                          with(12, 1),           with(15, 0),
                          with(15, 2),           scaled(0, 0, 0),
                          scaled(1, 1, 0),       scaled(1, 1, 1e-9),
                          scaled(1, 1, -1),      scaled(-1, -1, -1),
                          scaled(1, 1, 1.01),    scaled(0.5, 0.5, 0.5),
                          scaled(1e6, 1e6, 1e6), scaled(1e-6, 1e-6, 1e-6),
                          with(1, 0.9),          Matrix{}};
    Worst orthonormal;
    for (const Matrix& m : good) {
      const data::RigidPose pose = data::rigid_pose(m, "a camera");
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
          orthonormal.see(std::abs(dot(pose.axes[i], pose.axes[j]) - (i == j)) / kUnitDouble);
    }
    for (const Matrix& m : bad) CHECK_THROWS_AS(data::rigid_pose(m, "a camera"), Error);
    measured("H28 axes of a camera off by up to 5e-4, made rigid", orthonormal.value, 16, "u of double");

    // A camera inside the object looks out through it: finite, and dark of nothing but the object.
    const VoxelModel model = blob_model(32, {.moves = false});
    const Rendered seen = render_image(model, camera_at({0.1, -0.05, 1e-9}), 0);
    for (const float v : seen.rgb.data) REQUIRE(std::isfinite(v));
    for (const float a : seen.alpha.data) CHECK(a > 0.9f);
  }
}
