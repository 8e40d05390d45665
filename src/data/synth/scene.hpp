// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "data/synth/gas.hpp"
#include "data/synth/geometry.hpp"
#include "splinevox/data/synth.hpp"

namespace splinevox::data {

/// One solid of a scene, its motion and its colour.
struct Body {
  Shape shape;
  std::function<Pose(double time)> pose;              ///< time in [0, 1]
  std::function<Vec3d(const Vec3d& material)> paint;  ///< unshaded colour at a point of the surface
};
using Bodies = std::vector<Body>;

/// Top of the floor of every scene that has one.
inline constexpr double kFloor = -0.74;

Shape make_ball(double radius);
Shape make_cone(double r0, double r1, double height, const Vec3d& flat = {1, 1, 1});
Shape make_box(const Vec3d& half, double round);
Shape make_disc(double radius, double half_height, double round);
/// A room, seen from inside.
Shape make_room(const Vec3d& half);
/// A tube of the given length; `widest` and `slope` bound its radius and how fast that changes.
Shape make_tube(double length, std::function<double(double)> radius, double widest, double slope);
/// The same pose at all times.
std::function<Pose(double)> still(const Place& place);

void add_figure(Bodies& bodies);  ///< jointed dancer
void add_stage(Bodies& bodies);   ///< plinth
void add_plant(Bodies& bodies);   ///< flower pot and what grows in it
void add_bouncing_ball(Bodies& bodies);
void add_sliding_ball(Bodies& bodies);
void add_entering_ball(Bodies& bodies);  ///< from above all pictures
void add_leaving_ball(Bodies& bodies);
void add_snake(Bodies& bodies);
void add_room(Bodies& bodies);  ///< walls, floor, ceiling, two crates and a column
/// Half sides of the room and its middle.
inline constexpr Vec3d kRoomHalf{2.9, 2.9, 1.8}, kRoomMiddle{0, 0, 0.9};

}  // namespace splinevox::data

namespace splinevox {

struct SynthScene::Content {
  data::Bodies bodies;
  std::vector<data::Pose> rest;  ///< poses at time 0
  int subjects = 0;              ///< bodies before those of the room
  const data::Gas* gas = nullptr;
  SynthLook look;
};

}  // namespace splinevox
