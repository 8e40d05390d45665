// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <string>

#include "core/parallel.hpp"
#include "field/edit/edit_motion.hpp"
#include "field/largest_presence.hpp"
#include "field/lattice/locate.hpp"
#include "field/lattice/slice.hpp"
#include "math/activation.hpp"
#include "math/sh.hpp"
#include "splinevox/core/error.hpp"
#include "splinevox/field/edit.hpp"

namespace splinevox {
namespace {

using Eight = Simd<float>::Eight;

constexpr int kTimes = 24;       ///< parameters at which places with matter are collected
constexpr float kDense = 1e-2f;  ///< opacity over a voxel from which a canonical place counts as taken
constexpr int kFitSamples = 8;   ///< per control point

/// A place of observed space that has matter at a time.
struct Place {
  double parameter;
  Vec3 x, canonical;
  float weight;
  bool member;
};

std::vector<Place> find_places(const VoxelModel& model, const MotionClusters& clusters,
                               const ChosenClusters& chosen) {
  std::vector<Place> all;
  for (int i = 0; i < kTimes; ++i) {
    const double s = double(i) / (kTimes - 1);
    const std::vector<Place> now = matter_at(model, s, [&](const MatterSample& place) {
      const Vec3 canonical = place.x + place.warp.displacement;
      const int label = clusters.at(canonical);
      return Place{s, place.x, canonical, place.weight, label >= 0 && chosen[std::size_t(label)]};
    });
    all.insert(all.end(), now.begin(), now.end());
  }
  return all;
}

Int3 brick_of(const Lattice& l, Vec3 p) {
  Int3 b;
  for (int a = 0; a < 3; ++a) b[a] = int(std::floor((p[a] - l.origin[a]) / l.spacing / kBrick));
  return b;
}

Int3 brick_limit(const Lattice& l) {
  Int3 n;
  for (int a = 0; a < 3; ++a) n[a] = (l.size[a] + kBrick - 1) / kBrick;
  return n;
}

/// Refuses a box whose lattice could not be stored, before anything is counted in whole numbers.
void check_room(const Lattice& lattice, const Box& box) {
  double bricks = 1;
  bool fits = true;
  for (int a = 0; a < 3; ++a) {
    const double end = double(lattice.origin[a]) + double(lattice.size[a]) * lattice.spacing;
    const double vertices =
        (std::max(double(box.hi[a]), end) - std::min(box.lo[a], lattice.origin[a])) / lattice.spacing +
        3 * kBrick;
    fits = fits && vertices <= kMostVertices;
    bricks *= vertices / kBrick + 3;
  }
  if (!fits || bricks > kMostBricks)
    fail({"edit", "the part would lie too far away for one volume to hold both",
          std::to_string(kMostVertices) + " voxels along an axis at most", "more",
          "move it less far, or export it alone and place it in the scene"});
}

/// The channels on a lattice grown by whole bricks until it covers `box`, with the bricks around `places`
/// (reached by a step of interpolation) added: what is stored keeps its values and, up to rounding of the
/// origin, its places.
Channels grown(const Channels& from, const Box& box, const std::vector<Vec3>& places) {
  Lattice lattice = from.topology->lattice;
  const Int3 first = brick_of(lattice, box.lo),
             last = brick_of(lattice, box.hi + Vec3{1, 1, 1} * lattice.spacing), limit = brick_limit(lattice);
  Int3 shift{};
  for (int a = 0; a < 3; ++a) {
    shift[a] = std::max(0, -first[a]);
    const int more = std::max(0, last[a] + 1 - limit[a]);
    lattice.size[a] = more > 0 ? kBrick * (limit[a] + more) : lattice.size[a];
    lattice.size[a] += kBrick * shift[a];
    lattice.origin[a] -= float(kBrick * shift[a]) * lattice.spacing;
  }
  const auto less = [](const Int3& a, const Int3& b) {
    return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z;
  };
  std::set<Int3, decltype(less)> bricks(less);
  for (int b = 1; b <= from.topology->brick_count(); ++b)
    bricks.insert(from.topology->bricks[std::size_t(b)] + shift);
  const Int3 count = brick_limit(lattice);
  for (const Vec3& p : places)
    for (int corner = 0; corner < kCorners; ++corner) {
      const Vec3 q = p + lattice.spacing * Vec3{corner & 4 ? 1.0f : -1.0f, corner & 2 ? 1.0f : -1.0f,
                                                corner & 1 ? 1.0f : -1.0f};
      const Int3 b = brick_of(lattice, q);
      bool inside = true;
      for (int a = 0; a < 3; ++a) inside &= b[a] >= 0 && b[a] < count[a];
      if (inside) bricks.insert(b);
    }
  Channels out =
      make_channels(make_topology(lattice, {bricks.begin(), bricks.end()}), from.width, from.row(0));
  for (int b = 1; b <= from.topology->brick_count(); ++b) {
    const auto to = std::size_t(out.topology->brick_at(from.topology->bricks[std::size_t(b)] + shift));
    std::copy_n(from.row(std::size_t(b) * kBrickRows), std::size_t(kBrickRows) * std::size_t(from.width),
                out.row(to * kBrickRows));
  }
  return out;
}

/// Bits of the motion rows that interpolation at the places reads.
std::vector<char> rows_of(const Channels& level, const std::vector<Vec3>& places) {
  std::vector<char> used(level.topology->rows(), 0);
  const BrickView<float> view(*level.topology);
  for (const Vec3& p : places)
    for (const std::int32_t r : locate(view, p).rows.row) used[std::size_t(r)] = 1;
  std::fill_n(used.begin(), kBrickRows, char(0));
  return used;
}

bool touches(const BrickView<float>& view, const std::vector<char>& rows, Vec3 p) {
  for (const std::int32_t r : locate(view, p).rows.row)
    if (r >= kBrickRows && rows[std::size_t(r)]) return true;
  return false;
}

/// [sh x sh]: coefficients of the turned function from those of the function, from values in many directions.
Matrix turned_harmonics(int order, const RigidMotion& g) {
  constexpr int kDirections = 100;
  const int n = (order + 1) * (order + 1);
  Matrix turned(kDirections, n), still(kDirections, n);
  for (int i = 0; i < kDirections; ++i) {  // a Fibonacci sphere
    const double z = 1 - (2 * i + 1) / double(kDirections), r = std::sqrt(1 - z * z),
                 a = i * std::numbers::pi * (3 - std::sqrt(5.0));
    const Vec3d d{r * std::cos(a), r * std::sin(a), z};
    double y[kMaxShCount];
    sh_basis(order, d, y);
    for (int j = 0; j < n; ++j) still(i, j) = y[j];
    sh_basis(order, g.linear_inverse(d), y);
    for (int j = 0; j < n; ++j) turned(i, j) = y[j];
  }
  return least_squares(still, turned);
}

void interpolate_row(const BrickView<float>& view, const Channels& from, Vec3 p, float* out) {
  const Located at = locate(view, p);
  for (int k = 0; k < from.width; k += 8)
    store(out + k, interpolate<Eight>(at, from.values.data(), from.width, k));
}

/// Moves the canonical matter. Where the part was it leaves nothing.
void carry_matter(VoxelModel& next, const VoxelModel& model, const MotionClusters& clusters,
                  const ChosenClusters& chosen, const RigidMotion& g) {
  hide_clusters(next, clusters, chosen);
  Channels& raw = next.radiance.raw;
  const Channels& old = model.radiance.raw;
  const BrickView<float> view(*old.topology);
  const int sh = next.radiance.sh_count();
  const Matrix harmonics =
      next.radiance.sh_order >= 0 ? turned_harmonics(next.radiance.sh_order, g) : Matrix();
  parallel_for(raw.topology->brick_count(), [&](int index) {
    std::vector<float> values(std::size_t(raw.width));
    for (int i = 0; i < kBrickRows; ++i) {
      const Vec3 source = cast<float>(g.inverse(cast<double>(raw.topology->position(index + 1, i))));
      const int label = clusters.at(source);
      if (label < 0 || !chosen[std::size_t(label)]) continue;
      interpolate_row(view, old, source, values.data());
      float* row = raw.row(std::size_t(index + 1) * kBrickRows + std::size_t(i));
      // Emptier than what is there. Where nothing is, matter that is thin on the mean over time may come.
      if (values[0] <= row[0] && row[0] != raw.row(0)[0]) continue;
      std::copy_n(values.data(), 4, row);
      for (int j = 0; j < sh; ++j) {
        double sum = 0;
        for (int k = 0; k < sh; ++k) sum += harmonics(j, k) * values[std::size_t(4 + k)];
        row[4 + j] = float(sum);
      }
    }
  });
}

/// Moves the control points of the rows in `rows`.
void carry_motion(MotionField& next, const MotionField& motion, const std::vector<char>& rows,
                  const RigidMotion& g) {
  const Channels& old = motion.levels[0];
  Channels& level = next.levels[0];
  const BrickView<float> view(*old.topology);
  const int stride = motion.stride();
  for (std::size_t r = kBrickRows; r < rows.size(); ++r) {
    if (!rows[r]) continue;
    const Vec3 x = level.topology->position(int(r / kBrickRows), int(r % kBrickRows));
    float* row = level.row(r);
    interpolate_row(view, old, cast<float>(g.inverse(cast<double>(x))), row);
    for (int k = 0; motion.displaces && k < motion.stored_points(); ++k) {
      float* p = row + stride * k;
      const Vec3 turned = cast<float>(g.linear({p[0], p[1], p[2]}));
      for (int a = 0; a < 3; ++a) p[a] = turned[a];
    }
  }
}

/// Refuses changed curves of presence whose other mean over time shows. Presence goes without its mean, so
/// the raw density is off by the difference at all times. The canonical volume cannot make up for it: the
/// difference belongs to observed places, several of which show one canonical place.
/// @param until  the parameter up to which the part is shown
/// @param limit  share of its opacity that may be off
void check_means(const MotionField& next, const MotionField& motion, const std::vector<Place>& places,
                 double until, double limit) {
  if (!motion.presence) return;
  const Contraction by(motion);
  const int presence = by.layout.scalar[kPresence];
  const Channels &level = next.levels[0], &old = motion.levels[0];
  std::vector<float> shift(level.topology->rows());  // of raw density, by row
  for (std::size_t row = 0; row < shift.size(); ++row)
    shift[row] = by.mean_at(old.row(row) + presence) - by.mean_at(level.row(row) + presence);
  const BrickView<float> view(*level.topology);
  double part = 0, off = 0;
  for (const Place& p : places) {
    if (!p.member || p.parameter > until) continue;
    const Located at = locate(view, p.x);
    float w[kCorners], there = 0;
    trilinear_weights(at.fraction, w);
    for (int c = 0; c < kCorners; ++c) there += w[c] * shift[std::size_t(at.rows.row[c])];
    // No density grows by a larger factor than that of thin matter.
    const float depth = optical_depth(std::min(p.weight, 0.9999f));
    off += std::abs(one_minus_exp_neg(depth * std::exp(there)) - p.weight);
    part += p.weight;
  }
  if (off > limit * part)
    fail({"edit",
          "matter comes and goes in this part: in a time of its own it would be too dense or too thin",
          "a part whose presence keeps its mean over time",
          std::to_string(std::lround(100 * off / part)) + "% of its opacity off",
          "--freeze-presence T or --scale-presence 0 before --clusters"});
}

/// The error of the parts' warp, and the ghosts: matter that is visible where the parts no longer are.
void measure(const VoxelModel& next, const VoxelModel& model, const std::vector<Place>& places,
             const RigidMotion& g, PartEdit& out) {
  const double voxel = next.radiance.raw.topology->lattice.spacing;
  const auto opacity = [&](const FrameSampler& s, Vec3 x) {
    return one_minus_exp_neg(s.density(x) * float(voxel));
  };
  DistanceSum error;
  double ghosts = 0;
  for (std::size_t first = 0; first < places.size();) {
    const FrameSampler sampler(next, FrameSampler::AtParameter{places[first].parameter}),
        old(model, FrameSampler::AtParameter{places[first].parameter});
    std::size_t i = first;
    for (; i < places.size() && places[i].parameter == places[first].parameter; ++i) {
      if (!places[i].member) continue;
      const Vec3d found = cast<double>(sampler.canonical(cast<float>(g(cast<double>(places[i].x)))));
      const double d = length(found - g(cast<double>(places[i].canonical))) / voxel;
      error.add(d, places[i].weight);
      const float now = opacity(sampler, places[i].x);
      if (now >= kDense && opacity(old, cast<float>(g.inverse(cast<double>(places[i].x)))) < kDense)
        ghosts += now;
    }
    first = i;
  }
  out.error_max = error.result().max;
  out.error_rms = error.result().rms;
  out.ghosts = error.weight > 0 ? ghosts / error.weight : 0;
}

}  // namespace

PartEdit carry_clusters(VoxelModel& model, const MotionClusters& clusters, const ChosenClusters& chosen,
                        const RigidMotion& g, double limit) {
  const std::vector<Place> places = find_places(model, clusters, chosen);
  const Lattice& lattice = model.radiance.raw.topology->lattice;
  const auto carried = [&](Vec3 x) { return cast<float>(g(cast<double>(x))); };
  VoxelModel next = model;
  std::vector<Vec3> observed, canonical, left, rest;
  const Vec3 margin = 2 * lattice.spacing * Vec3{1, 1, 1};
  for (const Place& p : places) {
    (p.member ? left : rest).push_back(p.x);
    if (p.member) {
      observed.push_back(carried(p.x));
      canonical.push_back(carried(p.canonical));
      for (const Vec3& q : {observed.back(), canonical.back()}) {
        next.box.lo = min(next.box.lo, q - margin);
        next.box.hi = max(next.box.hi, q + margin);
      }
    }
  }
  check_room(lattice, next.box);
  if (!model.motion.levels.empty()) check_room(model.motion.levels[0].topology->lattice, next.box);
  next.radiance.raw = grown(model.radiance.raw, next.box, canonical);
  if (!model.motion.levels.empty()) next.motion.levels[0] = grown(model.motion.levels[0], next.box, observed);

  PartEdit out;
  double others = 0, part = 0, disturbed = 0, covered = 0;
  const FrameSampler still(model, FrameSampler::AtParameter{0});
  const LargestPresence presence(model);
  std::vector<char> rows;
  if (!next.motion.levels.empty()) rows = rows_of(next.motion.levels[0], observed);
  const BrickView<float> view =
      next.motion.levels.empty() ? BrickView<float>() : BrickView<float>(*next.motion.levels[0].topology);
  for (const Place& p : places) {
    if (p.member) {
      part += p.weight;
      const Vec3 q = carried(p.canonical);
      const int label = clusters.at(q);
      const bool own = label >= 0 && chosen[std::size_t(label)];
      const float there = still.radiance(q, presence.around(q)).density;
      if (!own && one_minus_exp_neg(there * lattice.spacing) >= kDense) covered += p.weight;
    } else {
      others += p.weight;
      if (!rows.empty() && touches(view, rows, p.x)) disturbed += p.weight;
    }
  }
  out.disturbed = others > 0 ? disturbed / others : 0;
  out.covered = part > 0 ? covered / part : 0;
  if (out.disturbed > limit || out.covered > limit) return out;
  carry_matter(next, model, clusters, chosen, g);
  if (!rows.empty()) {
    carry_motion(next.motion, model.motion, rows, g);
    Channels& level = next.motion.levels[0];
    const std::vector<char> used = rows_of(level, left), shared = rows_of(level, rest);
    for (std::size_t r = kBrickRows; r < rows.size(); ++r)
      if (used[r] && !shared[r] && !rows[r]) std::fill_n(level.row(r), next.motion.rigidity_column(), 0.0f);
  }
  measure(next, model, places, g, out);
  if (out.ghosts <= limit) model = std::move(next);
  return out;
}

PartEdit slow_clusters(VoxelModel& model, const MotionClusters& clusters, const ChosenClusters& chosen,
                       double factor, double limit) {
  PartEdit out;
  if (model.motion.levels.empty()) return out;
  const std::vector<Place> places = find_places(model, clusters, chosen);
  std::vector<Vec3> own, others;
  for (const Place& p : places) (p.member ? own : others).push_back(p.x);
  const Channels& level = model.motion.levels[0];
  std::vector<char> rows = rows_of(level, own), kept = rows_of(level, others);
  const BrickView<float> view(*level.topology);
  double part = 0, disturbed = 0;
  for (const Place& p : places)
    if (p.member) {
      part += p.weight;
      disturbed += touches(view, kept, p.x) ? p.weight : 0;
    }
  out.disturbed = part > 0 ? disturbed / part : 0;
  if (out.disturbed > limit) return out;

  const MotionField& m = model.motion;
  const std::vector<double> at = middles(kFitSamples * m.points);
  std::vector<double> slowed = at;
  for (double& v : slowed) v = std::min(1.0, factor * v);
  const Matrix old = design(m.basis, m.points, slowed);
  VoxelModel next = model;
  next.motion = with_points(m, m.basis, m.points, m.first_point,
                            product(fit_matrix(m.basis, m.points, m.first_point, at), old));
  for (std::size_t r = 0; r < rows.size(); ++r)
    if (!rows[r] || kept[r]) std::copy_n(level.row(r), level.width, next.motion.levels[0].row(r));
  check_means(next.motion, m, places, factor, limit);
  // Against the old motion at the slower time, where the part is then.
  const double voxel = model.radiance.raw.topology->lattice.spacing;
  DistanceSum error;
  for (std::size_t first = 0; first < places.size();) {
    const double s = places[first].parameter;
    std::size_t i = first;
    const bool within = s <= factor;
    const FrameSampler sampler(next, FrameSampler::AtParameter{within ? s / factor : 1});
    for (; i < places.size() && places[i].parameter == s; ++i) {
      if (!within || !places[i].member || touches(view, kept, places[i].x)) continue;
      const double d = length(sampler.canonical(places[i].x) - places[i].canonical) / voxel;
      error.add(d, places[i].weight);
    }
    first = i;
  }
  out.error_max = error.result().max;
  out.error_rms = error.result().rms;
  model = std::move(next);
  return out;
}

}  // namespace splinevox
