// SPDX-License-Identifier: Apache-2.0
#include "data/synth/geometry.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace splinevox::data {
namespace {

/// Without the care std::hypot takes of overflow, which costs as much as the rest of a distance.
double flat_length(double x, double y) { return std::sqrt(x * x + y * y); }

double ball(const Vec3d& m, double r) { return length(m) - r; }

/// Hull of two balls on the z axis, by the side of the line on which the tangent points lie.
double cone(const Vec3d& m, double r0, double r1, double h) {
  const double q = flat_length(m.x, m.y), b = (r0 - r1) / h, a = std::sqrt(1 - b * b), k = a * m.z - b * q;
  if (k < 0) return flat_length(q, m.z) - r0;
  if (k > a * h) return flat_length(q, m.z - h) - r1;
  return q * a + m.z * b - r0;
}

double box(const Vec3d& m, const Vec3d& half, double round) {
  const Vec3d q{std::abs(m.x) - half.x + round, std::abs(m.y) - half.y + round,
                std::abs(m.z) - half.z + round};
  return length(max(q, Vec3d{})) + std::min(0.0, std::max({q.x, q.y, q.z})) - round;
}

double disc(const Vec3d& m, double r, double half, double round) {
  const double x = flat_length(m.x, m.y) - r + round, z = std::abs(m.z) - half + round;
  return flat_length(std::max(x, 0.0), std::max(z, 0.0)) + std::min(0.0, std::max(x, z)) - round;
}

double solid(const Shape& s, const Vec3d& m) {
  switch (s.kind) {
    case Shape::Kind::cone:
      return cone(m, s.r0, s.r1, s.height);
    case Shape::Kind::box:
      return box(m, s.half, s.round);
    case Shape::Kind::disc:
      return disc(m, s.r0, s.height, s.round);
    case Shape::Kind::room:
      return -box(m, s.half, 0);
    default:
      return ball(m, s.r0);
  }
}

/// The point of a tube's centre line nearest to some point, and that point's material coordinates.
struct Nearest {
  double distance = std::numeric_limits<double>::infinity();  ///< to the centre line
  double here = 0;                                            ///< length along it
  Vec3d material{};
};

double along_arc(const Arc& arc, const Vec3d& p) {
  const Vec3d d = p - arc.start.at;
  const double ahead = dot(d, arc.start.turn.z);
  if (arc.curvature < 1e-9) return ahead;
  const double angle = std::atan2(ahead, 1 / arc.curvature - dot(d, arc.towards));
  const double middle =
      0.5 * arc.length * arc.curvature;  // the far side of the circle belongs to the nearer end
  return (middle + std::remainder(angle - middle, 2 * M_PI)) / arc.curvature;
}

void try_arc(const Arc& arc, const Vec3d& p, Nearest& best) {
  const double l = along_arc(arc, p);
  const Place frame = l <= 0 ? arc.start : l >= arc.length ? arc.end : arc.at(l);
  const double here = arc.from + std::clamp(l, 0.0, arc.length);
  const Vec3d q = frame.inverse(p);
  const double distance = length(q);
  if (distance < best.distance) best = {distance, here, {q.x, q.y, here + q.z}};
}

/// A lower bound of the distance from p to one piece.
double at_least(const Arc& arc, const Vec3d& p) { return length(p - arc.middle) - 0.5 * arc.length; }

/// The piece that is most likely the nearest, and the bound for it, which no other piece undercuts.
std::pair<const Arc*, double> likely(const std::vector<Arc>& arcs, const Vec3d& p) {
  std::pair<const Arc*, double> best{nullptr, std::numeric_limits<double>::infinity()};
  for (const Arc& arc : arcs) {
    const double bound = at_least(arc, p);
    if (bound < best.second) best = {&arc, bound};
  }
  return best;
}

Nearest nearest(const std::vector<Arc>& arcs, const Vec3d& p) {
  Nearest best;
  const Arc* const first = likely(arcs, p).first;
  try_arc(*first, p, best);
  for (const Arc& arc : arcs)
    if (&arc != first && at_least(arc, p) < best.distance) try_arc(arc, p, best);
  return best;
}

/// Near the wall the radius at the nearest point of the centre line counts; its slope (steeper on the inside
/// of a bend) tilts the wall. Farther off that point may jump to a wider part, so only the largest radius is
/// safe.
double tube_distance(const Shape& shape, const std::vector<Arc>& arcs, const Vec3d& p) {
  constexpr double kNear = 0.02;
  const double bound = likely(arcs, p).second - shape.widest;
  if (bound > kNear) return bound;
  const Nearest n = nearest(arcs, p);
  if (n.distance - shape.widest > kNear) return n.distance - shape.widest;
  const double tilt = 1.5 * shape.slope;
  return (n.distance - shape.radius(n.here)) / std::sqrt(1 + tilt * tilt);
}

}  // namespace

Turn turn_x(double a) { return {{1, 0, 0}, {0, std::cos(a), std::sin(a)}, {0, -std::sin(a), std::cos(a)}}; }
Turn turn_y(double a) { return {{std::cos(a), 0, -std::sin(a)}, {0, 1, 0}, {std::sin(a), 0, std::cos(a)}}; }
Turn turn_z(double a) { return {{std::cos(a), std::sin(a), 0}, {-std::sin(a), std::cos(a), 0}, {0, 0, 1}}; }

Place Arc::at(double along) const {
  const Turn& t = start.turn;
  if (curvature < 1e-9) return {t, start.at + along * t.z};
  const double s = std::sin(along * curvature), c = std::cos(along * curvature);
  const Vec3d tilt = (c - 1) * towards - s * t.z;  // how far the direction `towards` has turned
  return {{t.x + dot(t.x, towards) * tilt, t.y + dot(t.y, towards) * tilt, c * t.z + s * towards},
          start.at + (1 / curvature) * (s * t.z + (1 - c) * towards)};
}

std::vector<Arc> arcs_of(const Place& start, double piece_length,
                         const std::vector<std::pair<double, double>>& bends) {
  std::vector<Arc> arcs;
  Place place = start;
  for (const auto& [bx, by] : bends) {
    Arc arc;
    arc.start = place;
    arc.from = piece_length * double(arcs.size());
    arc.length = piece_length;
    arc.curvature = std::hypot(bx, by);
    if (arc.curvature >= 1e-9) arc.towards = (1 / arc.curvature) * (bx * place.turn.x + by * place.turn.y);
    arc.middle = arc.at(0.5 * piece_length).at;
    arc.end = place = arc.at(piece_length);
    arcs.push_back(arc);
  }
  return arcs;
}

Vec3d material_of(const Shape& shape, const Pose& pose, const Vec3d& world) {
  if (shape.kind == Shape::Kind::tube) return nearest(pose.arcs, world).material;
  const Vec3d d = world - pose.place.at;
  return pose.place.turn.inverse({d.x / pose.squash.x, d.y / pose.squash.y, d.z / pose.squash.z});
}

Vec3d world_of(const Pose& pose, const Vec3d& m) {
  if (pose.arcs.empty()) return pose.place.at + mul(pose.squash, pose.place.turn * m);
  const double piece = pose.arcs.front().length;
  const int last = int(pose.arcs.size()) - 1;
  const Arc& arc = pose.arcs[std::size_t(std::clamp(int(std::floor(m.z / piece)), 0, last))];
  const double l = m.z - arc.from, inside = std::clamp(l, 0.0, arc.length);
  return arc.at(inside) * Vec3d{m.x, m.y, l - inside};
}

double distance_to(const Shape& shape, const Pose& pose, const Vec3d& world) {
  if (shape.kind == Shape::Kind::tube) return tube_distance(shape, pose.arcs, world);
  const Vec3d m = material_of(shape, pose, world);
  const Vec3d& f = shape.flat;
  return std::min({f.x, f.y, f.z}) * std::min({pose.squash.x, pose.squash.y, pose.squash.z}) *
         solid(shape, {m.x / f.x, m.y / f.y, m.z / f.z});
}

Bound bound_of(const Shape& shape, const Pose& pose) {
  constexpr double kSlack = 1e-6;
  Bound bound;
  if (shape.kind == Shape::Kind::tube) {
    const double wide = 0.5 * pose.arcs.front().length + shape.widest + kSlack;
    bound.lo = bound.hi = pose.arcs.front().middle;
    for (const Arc& arc : pose.arcs) {
      bound.lo = min(bound.lo, arc.middle);
      bound.hi = max(bound.hi, arc.middle);
    }
    bound.lo -= {wide, wide, wide};
    bound.hi += {wide, wide, wide};
    bound.centre = 0.5 * (bound.lo + bound.hi);
    bound.radius = 0.5 * length(bound.hi - bound.lo);
    return bound;
  }
  const double r = std::max(shape.r0, shape.r1);
  switch (shape.kind) {
    case Shape::Kind::cone:
      bound = {{-r, -r, -shape.r0}, {r, r, shape.height + shape.r1}};
      break;
    case Shape::Kind::box:
    case Shape::Kind::room:
      bound = {-shape.half, shape.half};
      break;
    case Shape::Kind::disc:
      bound = {{-r, -r, -shape.height}, {r, r, shape.height}};
      break;
    default:
      bound = {{-r, -r, -r}, {r, r, r}};
  }
  bound.lo = mul(bound.lo, shape.flat) - Vec3d{kSlack, kSlack, kSlack};
  bound.hi = mul(bound.hi, shape.flat) + Vec3d{kSlack, kSlack, kSlack};
  bound.centre = world_of(pose, 0.5 * (bound.lo + bound.hi));
  bound.radius = 0.5 * length(bound.hi - bound.lo) * std::max({pose.squash.x, pose.squash.y, pose.squash.z});
  return bound;
}

std::pair<Vec3d, Vec3d> world_box(const Bound& bound, const Pose& pose) {
  if (!pose.arcs.empty()) return {bound.lo, bound.hi};
  Vec3d lo = bound.centre, hi = lo;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3d at =
        world_of(pose, {corner & 1 ? bound.hi.x : bound.lo.x, corner & 2 ? bound.hi.y : bound.lo.y,
                        corner & 4 ? bound.hi.z : bound.lo.z});
    lo = min(lo, at);
    hi = max(hi, at);
  }
  return {lo, hi};
}

std::pair<double, double> inside(const Bound& bound, const Pose& pose, const Vec3d& origin,
                                 const Vec3d& direction) {
  Vec3d o = origin, d = direction;
  if (pose.arcs.empty()) {
    const Vec3d shrink{1 / pose.squash.x, 1 / pose.squash.y, 1 / pose.squash.z};
    o = pose.place.turn.inverse(mul(shrink, origin - pose.place.at));
    d = pose.place.turn.inverse(mul(shrink, direction));
  }
  double from = 0, to = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    const double step = std::abs(d[k]) < 1e-300 ? 1e-300 : d[k];
    const double a = (bound.lo[k] - o[k]) / step, b = (bound.hi[k] - o[k]) / step;
    from = std::max(from, std::min(a, b));
    to = std::min(to, std::max(a, b));
  }
  return {from, to};
}

}  // namespace splinevox::data
