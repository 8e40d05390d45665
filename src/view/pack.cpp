// SPDX-License-Identifier: Apache-2.0
#include "view/pack.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "field/columns.hpp"
#include "field/largest_presence.hpp"
#include "field/lattice/row_mask.hpp"
#include "field/lattice/slice.hpp"
#include "math/composite.hpp"
#include "math/presence.hpp"
#include "render/occupancy.hpp"
#include "run/edit_session.hpp"
#include "view/codec.hpp"
#include "view/reduce.hpp"

namespace splinevox::run {
namespace {

constexpr int kOccupancyCells = 64;
constexpr float kOccupancyAlpha = 1e-3f;  ///< as the renderer
constexpr float kVisibleAlpha =
    2e-4f;                         ///< per step; below it 300 samples together hide 6% of what is behind them
constexpr float kColourLimit = 8;  ///< raw colours beyond it are black or white to 1/3000

/// Per slot of the table: rows within one vertex of a density that is visible at some time. Cells without one
/// at any corner have none: an interpolated density is never above the largest one at the corners.
std::vector<RowMask> visible_rows(const RadianceField& field, const LargestPresence& presence, float step) {
  const Topology& t = *field.raw.topology;
  std::vector<RowMask> visible(t.table.size());
  const Int3 limit = kBrick * t.dims;
  for (int b = 1; b <= t.brick_count(); ++b)
    for (int i = 0; i < kBrickRows; ++i) {
      const float raw = present(field.raw.row(std::size_t(b) * kBrickRows + i)[0],
                                presence.around(t.position(b, i), t.lattice.spacing));
      const float density = density_of(raw, field.activation.scale, field.activation.shift).value;
      if (!(opacity_of(density, step).alpha >= kVisibleAlpha)) continue;
      const Int3 v = t.vertex(b, i) + Int3{kBrick, kBrick, kBrick};
      Int3 n;
      for (n.x = v.x - 1; n.x <= v.x + 1; ++n.x)
        for (n.y = v.y - 1; n.y <= v.y + 1; ++n.y)
          for (n.z = v.z - 1; n.z <= v.z + 1; ++n.z) {
            if (n.x >= limit.x || n.y >= limit.y || n.z >= limit.z) continue;
            const RingVertex at = ring_vertex(n);
            visible[ring_slot(t, at.brick)].set(at.row);
          }
    }
  return visible;
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

/// One column of the visible rows of all packed bricks; a row that is not visible repeats the one before,
/// which costs nothing.
struct StoredColumn {
  const RadianceField& field;
  const std::vector<RowMask>& visible;
  const std::vector<Int3>& bricks;

  template <class Visit>
  void each(int column, Visit&& visit) const {
    const Topology& t = *field.raw.topology;
    for (const Int3& b : bricks) {
      const std::size_t slot = ring_slot(t, b);
      for (int i = 0; i < kBrickRows; ++i)
        visit(visible[slot].test(i), field.raw.row(std::size_t(t.table[slot]) * kBrickRows + i)[column]);
    }
  }
  Quantiser range(int first, int last, float limit, int bits) const {
    Quantiser q{0, 0, bits};
    bool any = false;
    for (int c = first; c < last; ++c)
      each(c, [&](bool used, float v) {
        if (!used || !std::isfinite(v)) return;
        v = std::clamp(v, -limit, limit);
        q.lo = any ? std::min(q.lo, v) : v;
        q.hi = any ? std::max(q.hi, v) : v;
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

/// How a kind of radiance is packed: bits of a number, raw values beyond which it is cut off, and whether
/// what nothing sees repeats the value before, which costs nothing.
struct Packing {
  int ViewQuality::*bits;
  float limit;
  bool repeat;
};
constexpr Packing kPackings[] = {{&ViewQuality::density_bits, 1e30f, false},
                                 {&ViewQuality::colour_bits, kColourLimit, true},
                                 {&ViewQuality::sh_bits, 1e30f, true}};
static_assert(std::size(kPackings) == std::size_t(ColumnKind::control), "one for each kind of radiance");

/// A raw density that no presence of the model makes visible.
float invisible_density(const DensityActivation& activation, const LargestPresence& presence, float step) {
  const std::vector<float>& all = presence.cells().values;
  const float most = std::max(0.0f, *std::max_element(all.begin(), all.end()));
  return raw_of_alpha(kVisibleAlpha, activation.scale, activation.shift, step) - most - 1;
}

Json pack_radiance(Writer& w, const RadianceField& field, const LargestPresence& presence, float step,
                   const ViewQuality& quality) {
  const Topology& t = *field.raw.topology;
  const std::vector<RowMask> visible = visible_rows(field, presence, step);
  std::vector<Int3> bricks;
  Int3 b;
  for (b.x = 0; b.x < t.dims.x; ++b.x)
    for (b.y = 0; b.y < t.dims.y; ++b.y)
      for (b.z = 0; b.z < t.dims.z; ++b.z)
        if (visible[ring_slot(t, b)].any()) bricks.push_back(b);
  Json out = table_of(w, t, bricks);
  out["scale"] = field.activation.scale;
  out["shift"] = field.activation.shift;
  out["sh_order"] = field.sh_order;
  const StoredColumn stored{field, visible, bricks};
  out["columns"] = Json::array();
  const std::vector<Column> columns = radiance_columns(field);
  for (auto first = columns.begin(); first != columns.end();) {  // those of a kind share their range
    const auto next =
        std::find_if(first, columns.end(), [&](const Column& c) { return c.kind != first->kind; });
    const int last = std::prev(next)->first + first->width;
    const Packing& how = kPackings[int(first->kind)];
    Quantiser q = stored.range(first->first, last, how.limit, quality.*how.bits);
    float most = std::numeric_limits<float>::infinity();  // of what is not packed
    if (presence.any() && !how.repeat) {
      // A density that is not visible becomes the lowest: none may be seen by the presence that is added.
      most = invisible_density(field.activation, presence, step);
      q.lo = std::min(q.lo, most);
    }
    for (int c = first->first; c < last; ++c)
      out["columns"].push_back({{"lo", q.lo},
                                {"hi", q.hi},
                                {"background", std::clamp(std::min(field.raw.row(0)[c], most), q.lo, q.hi)},
                                {"plane", w.plane(stored.quantised(c, q, how.repeat), q.bits)}});
    first = next;
  }
  return out;
}

/// Cells of observed space that hold matter at some time, and their neighbours: matter that moves less than a
/// cell between two samples is not missed. Samples are of the curves' parameter: a time curve may go through
/// all of it in a moment.
/// @param canonical  occupancy of the canonical volume
BitGrid ever_occupied(const VoxelModel& model, const MotionField& motion, const BitGrid& canonical) {
  if (!motion.displaces) return canonical;
  const OccupancyPyramid pyramid(model, kOccupancyCells, kOccupancyAlpha, model.step);
  const int samples = std::max(64, 4 * motion.points);
  BitGrid ever = pyramid.levels[0];
  for (int i = 0; i <= samples; ++i) {
    const MotionSlice slice = make_slice(motion, parameter_weights(motion, double(i) / samples));
    ever |= frame_occupancy(model, slice, pyramid);
  }
  return dilate(ever);
}

BitGrid every_cell(BitGrid grid) {
  for (std::size_t i = 0; i < grid.cells(); ++i) grid.set(i);
  return grid;
}

/// The same motion with the mean of presence taken out of its points, whose places have weights that sum to
/// 1: a page contracts all curves alike.
MotionField centred(MotionField motion) {
  if (!motion.presence || motion.levels.empty()) return motion;
  const Contraction by(motion);
  const Basis& basis = basis_of(motion.basis);
  const int stride = by.layout.stride, presence = by.layout.scalar[kPresence];
  Channels& level = motion.levels.back();
  for (std::size_t r = 0; r < level.topology->rows(); ++r) {
    float* row = level.row(r) + presence;
    const float mean = by.mean_at(row);
    for (int k = 0; k < by.count; ++k)
      if (basis.is_place(k)) row[stride * k] -= mean;
  }
  return motion;
}

/// "control_points", "light_points".
std::string points_key(const ColumnFacts& curve) { return std::string(curve.name) + "_points"; }

Json pack_motion(Writer& w, const MotionField& motion, const BitGrid& ever, int bits) {
  const Channels& level = motion.levels.back();
  const Topology& t = *level.topology;
  std::vector<Int3> bricks;
  for (int b = 1; b <= t.brick_count(); ++b) bricks.push_back(t.bricks[b] + Int3{1, 1, 1});
  Json out = table_of(w, t, bricks);
  out["size"] = triple(t.lattice.size);
  out["basis"] = basis_of(motion.basis).name;
  out["time_curve"] = Json::array();
  for (const TimeCurve::Knot& k : motion.time_curve.knots) out["time_curve"].push_back({k.time, k.value});
  out["points"] = motion.points;
  out["stored"] = motion.stored_points();
  out["displaces"] = motion.displaces;
  out["scalars"] = Json::array();
  out["rigidity"] = motion.rigidity;
  out["rigidity_offset"] = motion.rigidity_offset;
  // Rows that no sample in an occupied cell reads.
  std::vector<RowMask> read(t.bricks.size());
  const Vec3 reach = t.lattice.spacing * Vec3{1, 1, 1};
  for (int b = 1; b <= t.brick_count(); ++b)
    for (int i = 0; i < kBrickRows; ++i) {
      const Int3 v = t.vertex(b, i);
      const bool inside = v.x < t.lattice.size.x && v.y < t.lattice.size.y && v.z < t.lattice.size.z;
      if (inside && ever.any(t.position(b, i) - reach, t.position(b, i) + reach)) read[b].set(i);
    }
  /// Signed numbers with one scale: 0 stays 0, so that static matter stays static. A row that is not
  /// read repeats the one before.
  const auto add = [&](int first, int count) {
    float largest = 0;
    const auto each = [&](int column, auto&& visit) {
      float last = 0;
      for (int b = 1; b <= t.brick_count(); ++b)
        for (int i = 0; i < kBrickRows; ++i) {
          const float x = level.row(std::size_t(b) * kBrickRows + i)[column];
          if (read[b].test(i)) last = std::isfinite(x) ? x : 0.0f;
          visit(last);
        }
    };
    for (int c = first; c < first + count; ++c)
      each(c, [&](float v) { largest = std::max(largest, std::abs(v)); });
    const float scale = largest > 0 ? largest / float((1 << (bits - 1)) - 1) : 1.0f;
    Json entry{{"scale", scale}, {"planes", Json::array()}};
    for (int c = first; c < first + count; ++c) {
      std::vector<std::uint16_t> values;
      each(c, [&](float v) { values.push_back(std::uint16_t(std::int16_t(std::lround(v / scale)))); });
      entry["planes"].push_back(w.plane(values, 16));
    }
    return entry;
  };
  for (const ColumnFacts& c : kColumns) {
    if (!c.of_motion() || c.repeat != Repeat::point) continue;
    out[points_key(c)] = Json::array();
    if (is_scalar(c) && motion.*c.stored) out["scalars"].push_back(c.name);
  }
  std::vector<Column> columns = motion_columns(motion);
  std::stable_sort(columns.begin(), columns.end(),
                   [](const Column& a, const Column& b) { return a.first < b.first; });
  for (const Column& c : columns) {
    const ColumnFacts& facts = facts_of(c.kind);
    if (facts.repeat == Repeat::point) {
      out[points_key(facts)].push_back(add(c.first, c.width));
    } else {
      out[c.grid + "_values"] = add(c.first, c.width);
      out[c.grid + "_background"] = level.row(0)[c.first];
    }
  }
  return out;
}

Json bits_of(Writer& w, const BitGrid& grid) {
  std::vector<std::uint16_t> bytes;
  for (std::size_t i = 0; i < grid.cells(); i += 8) {
    unsigned byte = 0;
    for (std::size_t j = i; j < std::min(i + 8, grid.cells()); ++j) byte |= unsigned(grid.test(j)) << (j - i);
    bytes.push_back(std::uint16_t(byte));
  }
  return w.plane(bytes, 8);
}

Json pack_clusters(Writer& w, const VoxelModel& model, const MotionClusters& clusters) {
  std::vector<std::uint16_t> labels;
  for (const std::int16_t label : clusters.label) labels.push_back(std::uint16_t(label + 1));
  const Lattice& cells = clusters.cells;
  Json out{{"origin", triple(cells.origin)},
           {"spacing", cells.spacing},
           {"size", triple(cells.size)},
           {"labels", w.plane(labels, 8)},
           {"colours", Json::array()}};
  for (std::size_t c = 0; c < clusters.clusters.size(); ++c)
    out["colours"].push_back(triple(part_colour(model, c)));
  return out;
}

}  // namespace

const std::vector<ViewQuality>& view_qualities() {
  static const std::vector<ViewQuality> all{{12, 10, 8, 16, 0}, {10, 8, 6, 12, 0}, {10, 8, 0, 12, 0},
                                            {8, 6, 0, 10, 0},   {10, 8, 6, 12, 1}, {8, 7, 0, 10, 1},
                                            {8, 7, 0, 10, 2}};
  return all;
}

PackedScene pack_scene(const VoxelModel& model, const ViewQuality& quality, const MotionClusters* clusters) {
  RadianceField field = quality.sh_bits ? model.radiance : without_view(model.radiance);
  for (int i = 0; i < quality.halvings; ++i) field = halved(field);
  const MotionField motion = centred(collapse(model.motion));
  const LargestPresence presence(model, kOccupancyCells);
  const BitGrid canonical = canonical_occupancy(model, presence, kOccupancyAlpha, model.step);
  Json behind = Json::array();
  for (int j = 0; j < model.background.count(); ++j) behind.push_back(triple(model.background.raw[j]));
  Writer w;
  w.out.header = {{"box", {{"lo", triple(model.box.lo)}, {"hi", triple(model.box.hi)}}},
                  {"background", triple(model.background.color)},
                  {"background_harmonics", std::move(behind)},
                  {"step", model.step},
                  {"time", {{"origin", model.time_map.origin}, {"scale", model.time_map.scale}}}};
  w.out.header["radiance"] = pack_radiance(w, field, presence, model.step, quality);
  w.out.header["occupancy"] = {{"origin", triple(canonical.origin)},
                               {"cell", canonical.cell},
                               {"size", triple(canonical.size)},
                               {"canonical", bits_of(w, canonical)}};
  if (clusters) w.out.header["clusters"] = pack_clusters(w, model, *clusters);
  if (motion.levels.empty()) return std::move(w.out);
  const BitGrid ever = quality.everywhere ? every_cell(canonical) : ever_occupied(model, motion, canonical);
  w.out.header["occupancy"]["ever"] = bits_of(w, ever);
  w.out.header["motion"] = pack_motion(w, motion, ever, quality.motion_bits);
  return std::move(w.out);
}

}  // namespace splinevox::run
