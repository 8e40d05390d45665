// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "splinevox/core/vec3.hpp"

namespace splinevox::data {

// Procedural colours. All take material coordinates, so what they draw moves with the body. Edges are soft
// over about 0.01 scene units: sharper ones would only alias at the sizes these pictures have.

/// Colour from 0xRRGGBB.
Vec3d rgb(std::uint32_t hex);
Vec3d mix(const Vec3d& a, const Vec3d& b, double t);
/// 0 below -width / 2, 1 above width / 2, smooth between.
double edge(double x, double width = 0.01);
/// 1 within bands of the given period that fill `share` of it, else 0.
double bands(double x, double period, double share);
/// Smooth noise in [0, 1] with features of size 1; a fixed function of position.
double noise(const Vec3d& p);
/// Three octaves of noise in [0, 1].
double cloud(const Vec3d& p);
/// 1 in the dark fields of a checkerboard of fields u x v.
double checks(double u, double v);
/// 1 inside discs of radius r around the points of a staggered unit lattice.
double dots(double u, double v, double r);

}  // namespace splinevox::data
