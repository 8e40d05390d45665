// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "splinevox/core/camera.hpp"
#include "splinevox/run/cameras.hpp"

/// Ways of a camera. Those through, or near, given cameras are smooth and have no lens distortion. Pictures
/// have the size of the first camera; focal lengths and centres are followed as shares of a picture's width.
namespace splinevox::run {

/// Round the middle of a box once, z upwards, far enough that all of the box is visible in square pictures of
/// 36 degrees.
/// @param elevation  degrees @param size  pixels
std::vector<Camera> orbit(const Box& box, double elevation, int size, int count);

/// The way of a film without its shake. A camera at time t is a straight line fitted to the film near t,
/// evaluated at t: to positions, quaternions and lenses alike. The weight of a picture is (1 - |u|^3)^3,
/// where u runs from -1 to 1 over the window (local linear regression, Cleveland 1979). A line, not a mean:
/// the ends do not lag behind.
/// @param film  in the order of time, two or more. Pictures of one moment are taken as evenly spaced
/// @param window  share of the film's time, above 0; at least 5 pictures are always used
/// @param at  where on the film, 0..1
std::vector<Camera> stabilised(const std::vector<Shot>& film, double window, const std::vector<double>& at);

/// A smooth way through all cameras, with a share of it for every distance: cubic Hermite pieces with
/// tangents of neighbouring cameras (Catmull and Rom 1974). Directions from the middle and distances to it
/// are interpolated, so that the way keeps to the arc between two cameras.
/// @param cameras  two or more, in order @param closed  from the last back to the first
/// @param at  where on the way, 0..1
std::vector<Camera> interpolated(const std::vector<Camera>& cameras, const Vec3d& middle, bool closed,
                                 const std::vector<double>& at);

/// The cameras in the order of a short round trip (nearest neighbour, then 2-opt). Of more than `most` those
/// that are furthest from each other.
std::vector<Camera> round_trip(std::vector<Camera> cameras, std::size_t most);

/// Opens a round trip before its longest leg, if that spans over 60 degrees as seen from the middle and
/// is 1.5 times as wide as any other: places and axes on so wide a leg would part, and the camera look past
/// the scene. Such a trip is to be gone there and back. A ring of few cameras stays closed.
/// @return whether it was opened
bool open_at_wide_leg(std::vector<Camera>& trip, const Vec3d& middle);

/// Two turns of an ellipse in the plane of the mean camera, with a slower swing along its axis, looking at
/// the point of its axis that is as far away as the middle (Mildenhall et al. 2019, LLFF). Half axes are what
/// the positions deviate from their mean, root of mean squares.
/// @param at  where on the way, 0..1
std::vector<Camera> spiral(const std::vector<Camera>& cameras, const Vec3d& middle,
                           const std::vector<double>& at);

}  // namespace splinevox::run
