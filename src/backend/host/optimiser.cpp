// SPDX-License-Identifier: Apache-2.0
#include "backend/host/optimiser.hpp"

#include <cmath>

#include "core/parallel.hpp"
#include "core/simd.hpp"
#include "field/learn_kernels.hpp"
#include "math/shrink.hpp"
#include "math/tv.hpp"

namespace splinevox {
namespace {

using Eight = Simd<float>::Eight;

Eight root(const Eight& v) {
  Eight out;
  for (int i = 0; i < 8; ++i) out[i] = std::sqrt(v[i]);
  return out;
}
Eight flush(const Eight& v, float least) {
  const Eight magnitude = v < 0 ? -v : v;
  return magnitude < least ? Eight{} : v;
}

bool all_zero(const Eight& v) {
  for (int i = 0; i < 8; ++i)
    if (v[i] != 0) return false;
  return true;
}

/// Rows of a brick and of the layers of its neighbours one vertex around it; null where absent or not
/// visible.
struct Padded {
  const float* row[10][10][10];
  Padded(const Channels& c, int brick, std::span<const RowMask> visible) {
    const Topology& t = *c.topology;
    const Int3 at = t.bricks[brick];
    std::int32_t around[3][3][3];
    for (int x = -1; x <= 1; ++x)
      for (int y = -1; y <= 1; ++y)
        for (int z = -1; z <= 1; ++z)
          around[x + 1][y + 1][z + 1] = t.brick_at({at.x + x, at.y + y, at.z + z});
    for (int x = -1; x <= 8; ++x)
      for (int y = -1; y <= 8; ++y)
        for (int z = -1; z <= 8; ++z) {
          const std::int32_t b = around[(x + 8) >> 3][(y + 8) >> 3][(z + 8) >> 3];
          const int i = (x & 7) << 6 | (y & 7) << 3 | (z & 7);
          row[x + 1][y + 1][z + 1] =
              b && (visible.empty() || visible[b].test(i)) ? c.row(std::size_t(b) * kBrickRows + i) : nullptr;
        }
  }
};

void brick_total_variation(const Channels& values, int brick, std::span<const RowMask> visible,
                           const float* weight, float* gradient) {
  const Padded padded(values, brick, visible);
  const auto inside = [](int x, int y, int z) {
    return x >= 0 && y >= 0 && z >= 0 && x < 8 && y < 8 && z < 8;
  };
  const auto target = [&](int x, int y, int z) {
    return gradient + std::size_t(x * 64 + y * 8 + z) * values.width;
  };
  for (int x = -1; x < 8; ++x)
    for (int y = -1; y < 8; ++y)
      for (int z = -1; z < 8; ++z) {
        // A voxel of the layer below acts only through its one neighbour inside.
        if ((x < 0) + (y < 0) + (z < 0) > 1) continue;
        const float* self = padded.row[x + 1][y + 1][z + 1];
        if (!self) continue;
        const auto neighbour = [&](const float* p) { return p ? p : self; };
        const float* nx = neighbour(padded.row[x + 2][y + 1][z + 1]);
        const float* ny = neighbour(padded.row[x + 1][y + 2][z + 1]);
        const float* nz = neighbour(padded.row[x + 1][y + 1][z + 2]);
        for (int k = 0; k < values.width; k += 8) {
          const auto term = tv_term(load<Eight>(self + k), load<Eight>(nx + k), load<Eight>(ny + k),
                                    load<Eight>(nz + k), kTvSoftening, root);
          const Eight w = load<Eight>(weight + k);
          const auto add = [&](int cx, int cy, int cz, const Eight& d) {
            if (!inside(cx, cy, cz)) return;
            float* to = target(cx, cy, cz) + k;
            store(to, load<Eight>(to) + w * d);
          };
          add(x, y, z, term.d_self);
          if (nx != self) add(x + 1, y, z, term.d_x);
          if (ny != self) add(x, y + 1, z, term.d_y);
          if (nz != self) add(x, y, z + 1, term.d_z);
        }
      }
}

void shrink_row(const Shrink& shrink, float scale, int width, float* row) {
  Eight squares{};
  for (int k = 0; k < width; k += 8) {
    const Eight v = load<Eight>(row + k) * load<Eight>(shrink.member.data() + k);
    squares += v * v;
  }
  float sum = 0;
  for (int lane = 0; lane < 8; ++lane) sum += squares[lane];
  const float share = garrote_share(std::sqrt(sum), scale * shrink.threshold);
  for (int k = 0; k < width; k += 8)
    store(row + k, load<Eight>(row + k) * (1.0f - share * load<Eight>(shrink.member.data() + k)));
}

template <class Prior>
void add_prior(const Channels& values, const MotionField& motion, const Prior& prior, float share,
               std::uint64_t draw, std::span<const RowMask> among, Gradient& gradient) {
  if (!prior.any()) return;
  const int stride = motion.stride(), stored = motion.stored_points();
  const bool pinned = stored < motion.points;
  parallel_for(values.topology->brick_count(), [&](int index) {
    const int brick = index + 1;
    if (!chosen_brick(draw, brick, share)) return;
    const RowMask rows = among.empty() ? RowMask::all() : among[brick];
    rows.for_each([&](int i) {
      const std::size_t row = std::size_t(brick) * kBrickRows + i;
      curve_prior_vjp(prior, values.row(row), stride, stored, pinned, share, gradient.values.row(row));
    });
    gradient.touched[brick] |= rows;
  });
}

}  // namespace

void update(const LearnedRows& rows, Gradient& gradient, const MomentFactors& factors, float rate_scale) {
  Channels& values = *rows.values;
  const int width = values.width;
  parallel_for(values.topology->brick_count(), [&](int index) {
    const int brick = index + 1;
    RowMask& touched = gradient.touched[brick];
    if (!touched.any()) return;
    touched.for_each([&](int i) {
      const std::size_t row = (std::size_t(brick) * kBrickRows + i) * width;
      for (int k = 0; k < width; k += 8) {
        float* g = gradient.values.values.data() + row + k;
        if (width > kLongRow && all_zero(load<Eight>(g))) continue;
        float *m = rows.m->data() + row + k, *v = rows.v->data() + row + k,
              *p = values.values.data() + row + k;
        Eight mm = load<Eight>(m), vv = load<Eight>(v), pp = load<Eight>(p);
        const Eight rate = rate_scale * load<Eight>(rows.rate.data() + k);
        adam_step(factors, rate, load<Eight>(g), mm, vv, pp, root, flush);
        store(m, mm);
        store(v, vv);
        store(p, pp);
        store(g, Eight{});
      }
      for (const Shrink& shrink : rows.shrink)
        shrink_row(shrink, rate_scale, width, values.values.data() + row);
    });
    touched = {};
  });
}

void add_total_variation(const Channels& values, std::span<const float> tv, float scale, float share,
                         std::uint64_t draw, std::span<const RowMask> visible, Gradient& gradient) {
  std::vector<float> weight(values.width);
  bool any = false;
  for (int k = 0; k < values.width; ++k) {
    weight[k] = scale * tv[k] / share;
    any |= weight[k] > 0;
  }
  if (!any) return;
  parallel_for(values.topology->brick_count(), [&](int index) {
    const int brick = index + 1;
    if (!chosen_brick(draw, brick, share)) return;
    const RowMask rows = visible.empty() ? RowMask::all() : visible[brick];
    if (!rows.any()) return;
    brick_total_variation(values, brick, visible, weight.data(),
                          gradient.values.row(std::size_t(brick) * kBrickRows));
    gradient.touched[brick] |= rows;
  });
}

void add_curve_prior(const Channels& values, const MotionField& motion, const CurvePrior& prior, float share,
                     std::uint64_t draw, std::span<const RowMask> among, Gradient& gradient) {
  add_prior(values, motion, prior, share, draw, among, gradient);
}

void add_curve_prior(const Channels& values, const MotionField& motion, const StaticPrior& prior, float share,
                     std::uint64_t draw, std::span<const RowMask> among, Gradient& gradient) {
  add_prior(values, motion, prior, share, draw, among, gradient);
}

}  // namespace splinevox
