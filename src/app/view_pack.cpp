// SPDX-License-Identifier: Apache-2.0
#include "app/view_pack.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>

#include "app/view_codec.hpp"
#include "splinevox/field/row_mask.hpp"
#include "splinevox/field/slice.hpp"
#include "splinevox/math/activation.hpp"
#include "splinevox/render/occupancy.hpp"

namespace splinevox::app {
namespace {

constexpr int kOccupancyCells = 64;
constexpr float kOccupancyAlpha = 1e-3f;  ///< as the renderer
constexpr float kSeenAlpha = 2e-4f;       ///< per step; below it 300 samples together hide 6% of what is behind them
constexpr float kColourLimit = 8;         ///< raw colours beyond it are black or white to 1/3000

Json triple(const auto& v) { return Json::array({v.x, v.y, v.z}); }

/// Vertices are counted from the ring of absent bricks around a lattice, as BrickView does.
struct RingVertex {
  Int3 brick;
  int row;
};
RingVertex ring_vertex(Int3 v) {
  return {{v.x >> 3, v.y >> 3, v.z >> 3}, (v.x & 7) << 6 | (v.y & 7) << 3 | (v.z & 7)};
}
std::size_t ring_slot(const Topology& t, Int3 brick) { return (std::size_t(brick.x) * t.dims.y + brick.y) * t.dims.z + brick.z; }

/// Per slot of the table: rows within one vertex of anything to see. Cells with nothing to see at any corner stay without: an
/// interpolated density is never above the largest one at the corners.
std::vector<RowMask> seen_rows(const RadianceField& field, float step) {
  const Topology& t = *field.raw.topology;
  std::vector<RowMask> seen(t.table.size());
  const Int3 limit = kBrick * t.dims;
  for (int b = 1; b <= t.brick_count(); ++b)
    for (int i = 0; i < kBrickRows; ++i) {
      const float raw = field.raw.row(std::size_t(b) * kBrickRows + i)[0];
      const float depth = field.activation.scale * softplus(raw + field.activation.shift).value * step;
      if (!(one_minus_exp_neg(depth) >= kSeenAlpha)) continue;
      const Int3 v = t.vertex(b, i) + Int3{kBrick, kBrick, kBrick};
      Int3 n;
      for (n.x = v.x - 1; n.x <= v.x + 1; ++n.x)
        for (n.y = v.y - 1; n.y <= v.y + 1; ++n.y)
          for (n.z = v.z - 1; n.z <= v.z + 1; ++n.z) {
            if (n.x >= limit.x || n.y >= limit.y || n.z >= limit.z) continue;
            const RingVertex at = ring_vertex(n);
            seen[ring_slot(t, at.brick)].set(at.row);
          }
    }
  return seen;
}

/// Collects planes of numbers and says where each is.
struct Writer {
  PackedScene out;
  Json plane(const std::vector<std::uint16_t>& values, int bits) {
    Json place{{"offset", out.bytes.size()}, {"count", values.size()}, {"bits", bits}};
    append_plane(out.bytes, values, bits);
    return place;
  }
};

Json table_of(Writer& w, const Topology& t, const std::vector<Int3>& ring_bricks) {
  std::vector<std::uint16_t> at;
  for (int a = 0; a < 3; ++a)
    for (const Int3& b : ring_bricks) at.push_back(std::uint16_t(b[a]));
  return {{"origin", triple(t.lattice.origin - float(kBrick) * t.lattice.spacing * Vec3{1, 1, 1})},
          {"spacing", t.lattice.spacing},
          {"dims", triple(t.dims)},
          {"bricks", ring_bricks.size()},
          {"places", w.plane(at, 16)}};
}

/// One column of the seen rows of all packed bricks; a row that nothing sees repeats the one before, which costs nothing.
struct Column {
  const RadianceField& field;
  const std::vector<RowMask>& seen;
  const std::vector<Int3>& bricks;

  template <class Visit>
  void each(int column, Visit&& visit) const {
    const Topology& t = *field.raw.topology;
    for (const Int3& b : bricks) {
      const std::size_t slot = ring_slot(t, b);
      for (int i = 0; i < kBrickRows; ++i)
        visit(seen[slot].test(i), field.raw.row(std::size_t(t.table[slot]) * kBrickRows + i)[column]);
    }
  }
  Quantiser range(int first, int last, float limit, int bits) const {
    Quantiser q{0, 0, bits};
    bool any = false;
    for (int c = first; c < last; ++c)
      each(c, [&](bool used, float v) {
        if (!used || !std::isfinite(v)) return;
        v = std::clamp(v, -limit, limit);
        q.lo = any ? std::min(q.lo, v) : v, q.hi = any ? std::max(q.hi, v) : v;
        any = true;
      });
    return q;
  }
  std::vector<std::uint16_t> quantised(int column, const Quantiser& q, bool repeat) const {
    std::vector<std::uint16_t> values;
    values.reserve(bricks.size() * kBrickRows);
    std::uint16_t last = 0;
    each(column, [&](bool used, float v) {
      if (used) last = q(v);
      values.push_back(used || repeat ? last : std::uint16_t(0));
    });
    return values;
  }
};

Json pack_radiance(Writer& w, const RadianceField& field, float step, const ViewQuality& quality) {
  const Topology& t = *field.raw.topology;
  const std::vector<RowMask> seen = seen_rows(field, step);
  std::vector<Int3> bricks;
  Int3 b;
  for (b.x = 0; b.x < t.dims.x; ++b.x)
    for (b.y = 0; b.y < t.dims.y; ++b.y)
      for (b.z = 0; b.z < t.dims.z; ++b.z)
        if (seen[ring_slot(t, b)].any()) bricks.push_back(b);
  Json out = table_of(w, t, bricks);
  out["scale"] = field.activation.scale, out["shift"] = field.activation.shift;
  out["sh_order"] = quality.sh_bits ? field.sh_order : -1;
  const Column columns{field, seen, bricks};
  const auto add = [&](int column, const Quantiser& q, bool repeat) {
    const float background = field.raw.row(0)[column];
    out["columns"].push_back({{"lo", q.lo}, {"hi", q.hi}, {"background", std::clamp(background, q.lo, q.hi)}, {"plane", w.plane(columns.quantised(column, q, repeat), q.bits)}});
  };
  out["columns"] = Json::array();
  add(0, columns.range(0, 1, 1e30f, quality.density_bits), false);
  const Quantiser colour = columns.range(1, 4, kColourLimit, quality.colour_bits);
  for (int c = 1; c < 4; ++c) add(c, colour, true);
  if (!quality.sh_bits) return out;
  const Quantiser sh = columns.range(4, 4 + field.sh_count(), 1e30f, quality.sh_bits);
  for (int c = 0; c < field.sh_count(); ++c) add(4 + c, sh, true);
  return out;
}

Json pack_motion(Writer& w, const MotionField& all_levels, int bits) {
  const MotionField motion = collapse(all_levels);
  const Channels& level = motion.levels.back();
  const Topology& t = *level.topology;
  std::vector<Int3> bricks;
  for (int b = 1; b <= t.brick_count(); ++b) bricks.push_back(t.bricks[b] + Int3{1, 1, 1});
  Json out = table_of(w, t, bricks);
  out["size"] = triple(t.lattice.size);
  out["basis"] = motion.basis == BasisKind::bezier ? "bezier" : "bspline";
  out["points"] = motion.points, out["stored"] = motion.stored_points();
  out["displaces"] = motion.displaces, out["light"] = motion.light, out["rigidity"] = motion.rigidity && motion.displaces;
  out["rigidity_offset"] = motion.rigidity_offset;
  /// Signed numbers with one scale: 0 stays 0, so that what does not move stands still.
  const auto add = [&](int first, int count) {
    float largest = 0;
    const auto each = [&](int column, auto&& visit) {
      for (int b = 1; b <= t.brick_count(); ++b)
        for (int i = 0; i < kBrickRows; ++i) {
          const Int3 v = t.vertex(b, i);
          const bool inside = v.x < t.lattice.size.x && v.y < t.lattice.size.y && v.z < t.lattice.size.z;
          const float x = level.row(std::size_t(b) * kBrickRows + i)[column];
          visit(inside && std::isfinite(x) ? x : 0.0f);
        }
    };
    for (int c = first; c < first + count; ++c) each(c, [&](float v) { largest = std::max(largest, std::abs(v)); });
    const float scale = largest > 0 ? largest / float((1 << (bits - 1)) - 1) : 1.0f;
    Json entry{{"scale", scale}, {"planes", Json::array()}};
    for (int c = first; c < first + count; ++c) {
      std::vector<std::uint16_t> values;
      each(c, [&](float v) { values.push_back(std::uint16_t(std::int16_t(std::lround(v / scale)))); });
      entry["planes"].push_back(w.plane(values, 16));
    }
    return entry;
  };
  for (const char* key : {"control_points", "light_points"}) out[key] = Json::array();
  for (int k = 0; k < motion.stored_points(); ++k) {
    if (motion.displaces) out["control_points"].push_back(add(motion.stride() * k, 3));
    if (motion.light) out["light_points"].push_back(add(motion.stride() * k + motion.light_lane(), 1));
  }
  if (out["rigidity"]) {
    out["rigidity_values"] = add(motion.rigidity_column(), 1);
    out["rigidity_background"] = level.row(0)[motion.rigidity_column()];
  }
  return out;
}

Json pack_occupancy(Writer& w, const VoxelModel& model) {
  const BitGrid grid = canonical_occupancy(model, kOccupancyCells, kOccupancyAlpha, model.step);
  std::vector<std::uint16_t> bytes;
  for (std::size_t i = 0; i < grid.cells(); i += 8) {
    unsigned byte = 0;
    for (std::size_t j = i; j < std::min(i + 8, grid.cells()); ++j) byte |= unsigned(grid.test(j)) << (j - i);
    bytes.push_back(std::uint16_t(byte));
  }
  return {{"origin", triple(grid.origin)}, {"cell", grid.cell}, {"size", triple(grid.size)}, {"bits", w.plane(bytes, 8)}};
}

}  // namespace

const std::vector<ViewQuality>& view_qualities() {
  static const std::vector<ViewQuality> all{{12, 10, 8, 16, 0}, {10, 8, 6, 12, 0}, {10, 8, 0, 12, 0}, {8, 6, 0, 10, 0}, {10, 8, 6, 12, 1}, {8, 7, 0, 10, 1}, {8, 7, 0, 10, 2}};
  return all;
}

RadianceField halved(const RadianceField& field) {
  const Topology& fine = *field.raw.topology;
  Lattice lattice{fine.lattice.origin, 2 * fine.lattice.spacing, {}};
  for (int a = 0; a < 3; ++a) lattice.size[a] = std::max(2, fine.lattice.size[a] / 2 + 1);
  const auto lower = [](const Int3& a, const Int3& b) { return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z); };
  std::set<Int3, decltype(lower)> bricks(lower);
  for (int b = 1; b <= fine.brick_count(); ++b) {
    // A fine brick reaches the coarse vertices from half its first vertex, rounded down, to half of what follows its last.
    const Int3 first = kBrick * fine.bricks[b];
    Int3 c;
    for (c.x = first.x / 2 / kBrick; c.x <= std::min(first.x / 2 + 4, lattice.size.x - 1) / kBrick; ++c.x)
      for (c.y = first.y / 2 / kBrick; c.y <= std::min(first.y / 2 + 4, lattice.size.y - 1) / kBrick; ++c.y)
        for (c.z = first.z / 2 / kBrick; c.z <= std::min(first.z / 2 + 4, lattice.size.z - 1) / kBrick; ++c.z) bricks.insert(c);
  }
  RadianceField out = field;
  out.raw = make_channels(make_topology(lattice, {bricks.begin(), bricks.end()}), field.raw.width, field.raw.row(0));
  const Topology& coarse = *out.raw.topology;
  const Int3 limit = kBrick * fine.dims, ring{kBrick, kBrick, kBrick};
  for (int b = 1; b <= coarse.brick_count(); ++b)
    for (int i = 0; i < kBrickRows; ++i) {
      float* row = out.raw.row(std::size_t(b) * kBrickRows + i);
      const Int3 centre = 2 * coarse.vertex(b, i) + ring;
      std::fill_n(row, out.raw.width, 0.0f);
      for (int n = 0; n < 27; ++n) {
        const Int3 d{n / 9 - 1, n / 3 % 3 - 1, n % 3 - 1}, v = centre + d;
        const bool inside = v.x < limit.x && v.y < limit.y && v.z < limit.z;
        const RingVertex at = ring_vertex(inside ? v : Int3{});
        const float* from = field.raw.row(std::size_t(fine.table[ring_slot(fine, at.brick)]) * kBrickRows + at.row);
        const float weight = (d.x ? 0.25f : 0.5f) * (d.y ? 0.25f : 0.5f) * (d.z ? 0.25f : 0.5f);
        for (int c = 0; c < out.raw.width; ++c) row[c] += weight * from[c];
      }
    }
  return out;
}

PackedScene pack_scene(const VoxelModel& model, const ViewQuality& quality) {
  RadianceField field = model.radiance;
  for (int i = 0; i < quality.halvings; ++i) field = halved(field);
  Writer w;
  w.out.header = {{"box", {{"lo", triple(model.box.lo)}, {"hi", triple(model.box.hi)}}},
                  {"background", triple(model.background)},
                  {"step", model.step},
                  {"time", {{"origin", model.time_map.origin}, {"scale", model.time_map.scale}}}};
  w.out.header["radiance"] = pack_radiance(w, field, model.step, quality);
  w.out.header["occupancy"] = pack_occupancy(w, model);
  if (!model.motion.levels.empty()) w.out.header["motion"] = pack_motion(w, model.motion, quality.motion_bits);
  return std::move(w.out);
}

}  // namespace splinevox::app
