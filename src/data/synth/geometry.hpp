// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "splinevox/core/vec3.hpp"

namespace splinevox::data {

/// A rotation as its three columns: where the axes x, y, z go.
struct Turn {
  Vec3d x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
  Vec3d operator*(const Vec3d& v) const { return v.x * x + v.y * y + v.z * z; }
  Vec3d inverse(const Vec3d& v) const { return {dot(x, v), dot(y, v), dot(z, v)}; }
  Turn operator*(const Turn& b) const { return {*this * b.x, *this * b.y, *this * b.z}; }
};

/// Right-handed turns about an axis, radians.
Turn turn_x(double angle);
Turn turn_y(double angle);
Turn turn_z(double angle);

/// A rigid placement: p = at + turn * m. Joints of a figure are products of these.
struct Place {
  Turn turn{};
  Vec3d at{};
  Vec3d operator*(const Vec3d& m) const { return at + turn * m; }
  Vec3d inverse(const Vec3d& p) const { return turn.inverse(p - at); }
  Place operator*(const Place& b) const { return {turn * b.turn, *this * b.at}; }
};
inline Place shift(double x, double y, double z) { return {{}, {x, y, z}}; }
inline Place rotate(const Turn& turn) { return {turn, {}}; }

/// A piece of a tube's centre line: a circular arc (or a straight piece), with the frame carried along
/// without twist. The frame's z runs along the line, x and y span the cross-section.
struct Arc {
  Place start, end;
  double from = 0, length = 0;  ///< arc length at the start, and of the piece
  double curvature = 0;         ///< >= 0, 1 / radius
  Vec3d towards{};              ///< unit, world: from the start towards the centre of the circle
  Vec3d middle{};               ///< the piece lies within length / 2 of it
  Place at(double along) const;
};

/// A tube's centre line through pieces of equal length. `bends`: curvature of each piece towards the frame's
/// own x and y axes, 1 / scene units. Two pieces always join with one tangent.
std::vector<Arc> arcs_of(const Place& start, double piece_length,
                         const std::vector<std::pair<double, double>>& bends);

/// Where a body is: its material coordinates m become the world point
///   at + squash * (turn * m)      squash: factors along the world axes
/// or, for a tube, the point beside the centre line at length m.z.
struct Pose {
  Place place{};
  Vec3d squash{1, 1, 1};
  std::vector<Arc> arcs;
};

/// A solid in material coordinates.
struct Shape {
  enum class Kind { ball, cone, box, disc, tube, room };  ///< room: what is outside of a box
  Kind kind = Kind::ball;
  double r0 = 0.1, r1 = 0.1;  ///< ball: r0. cone: radius of its round ends at z = 0 and z = height. disc: r0
  double height = 0;          ///< cone: length. disc: half height. tube: length
  Vec3d half{};               ///< box, room: half sides
  double round = 0;           ///< box, disc: radius of the edges, inside the given size
  Vec3d flat{1, 1, 1};        ///< factors along the material axes (not for tubes)
  std::function<double(double)> radius;  ///< tube: at each length
  double widest = 0;                     ///< tube: largest radius
  double slope = 0;                      ///< tube: bound of |d radius / d length|
};

/// Material point of a world point.
Vec3d material_of(const Shape& shape, const Pose& pose, const Vec3d& world);
/// World point of a material point.
Vec3d world_of(const Pose& pose, const Vec3d& material);
/// A lower bound of the distance from a world point to the surface, exact at 0; negative inside.
double distance_to(const Shape& shape, const Pose& pose, const Vec3d& world);

/// A box that holds the posed body: in material coordinates, or in the world's for a tube.
struct Bound {
  Vec3d lo{}, hi{};
  Vec3d centre{};     ///< world; of a ball around the box, the cheaper test
  double radius = 0;  ///< of that ball
  /// Whether the line origin + s * direction meets the ball. @pre direction has unit length
  bool met_by(const Vec3d& origin, const Vec3d& direction) const {
    const Vec3d d = centre - origin;
    const double middle = dot(d, direction);
    return dot(d, d) - middle * middle < radius * radius;
  }
};
Bound bound_of(const Shape& shape, const Pose& pose);
/// The corners of a box along the world's axes that holds it.
std::pair<Vec3d, Vec3d> world_box(const Bound& bound, const Pose& pose);

/// The stretch [first, second] of origin + s * direction, s >= 0, inside the bound; empty if first > second.
std::pair<double, double> inside(const Bound& bound, const Pose& pose, const Vec3d& origin,
                                 const Vec3d& direction);

}  // namespace splinevox::data
