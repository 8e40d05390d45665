// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "splinevox/core/camera.hpp"
#include "splinevox/core/vec3.hpp"
#include "splinevox/field/lattice.hpp"
#include "splinevox/math/basis.hpp"

namespace splinevox {

/// Grids of fields that a configuration may lead to: one for each column of a model.
inline constexpr int kMostGrids = 256;

/// sigma = scale * softplus(raw + shift), in 1 / scene unit; see math/activation.hpp.
struct DensityActivation {
  float scale = 1;  ///< 1 / scene unit, > 0
  float shift = 0;
  friend bool operator==(const DensityActivation&, const DensityActivation&) = default;
};

/// How the first control point of a curve that begins in it (Basis::pinnable) is treated (the paper, section
/// Architecture).
enum class FirstPoint {
  zero,  ///< pinned to zero: t = 0 is exactly canonical, the point is not stored
  free   ///< stored and learned like the others
};

/// Canonical appearance: raw values on one lattice, activated after interpolation.
/// Row: [0] density, [1..3] rgb, [4..] spherical-harmonic coefficients of the view rescale, then padding
/// (field/columns.hpp).
struct RadianceField {
  DensityActivation activation;
  int sh_order = 1;  ///< 0..3, or -1 for no view dependence: colour is sigmoid(rgb)
  Channels raw;

  int sh_count() const { return (sh_order + 1) * (sh_order + 1); }
};

/// Motion: where in the canonical volume to look at time t, x' = x + r * sum_k w_k(s) p_k (Eq. 2 to 4),
/// s = time_curve(t), which is t unless the run was edited.
/// A sum of levels, coarse to fine, each a lattice that halves the one before, so that the sum is again a
/// trilinear function on the finest lattice. Row: [stride * k + axis] stored control point k, behind its
/// place point k of the curves of light and presence where it has them, then raw rigidity (r = sigmoid, 1
/// moves, 0 is static: the paper's name is inverted), then padding. Where nothing moves, the row is those
/// curves alone.
struct MotionField {
  BasisKind basis = BasisKind::bezier;
  int points = 5;                             ///< control points K, 2..256
  FirstPoint first_point = FirstPoint::zero;  ///< always free where the basis is not pinnable
  bool displaces = true;                      ///< false: nothing moves; needs light or presence
  bool rigidity = true;                       ///< false: r = 1 and nothing is stored for it; needs displaces
  bool light = false;            ///< places change their brightness over time, see math/light.hpp
  bool presence = false;         ///< matter comes and goes, see math/presence.hpp; needs free first points
  float rigidity_offset = 0;     ///< added to the interpolated raw rigidity before the sigmoid
  TimeCurve time_curve;          ///< parameter of the curves at each model time; training leaves the identity
  std::vector<Channels> levels;  ///< empty: nothing changes over time

  int stored_points() const { return first_point == FirstPoint::zero ? points - 1 : points; }
  bool moves() const { return displaces && !levels.empty(); }
  // See MotionLayout in field/columns.hpp.
  int stride() const;           ///< floats per control point: x, y, z and one for each curve of one number
  int rigidity_column() const;  ///< the first after the control points
  int width() const;            ///< floats per row, a whole number of registers
};

/// What is behind everything: one colour, or where pictures are opaque a learned one for every direction. It
/// has no place, so it neither comes nearer nor moves: what is far away.
struct Background {
  Vec3 color{1, 1,
             1};  ///< display values in [0, 1]; of a learned one its band 0, for who can show only one colour
  int order = -1;  ///< of the harmonics, at most kMaxShOrder; -1: `color` everywhere
  Vec3 raw[kMaxShCount] = {};

  bool learned() const { return order >= 0; }
  int count() const { return (order + 1) * (order + 1); }
  /// @param direction  unit length
  Vec3 towards(const Vec3& direction) const;
  friend bool operator==(const Background&, const Background&) = default;
};

/// What stands around the box of opaque pictures, out to infinity: static and matte matter on one coarse
/// lattice of contracted space (math/contract.hpp). It is what real cameras see behind a scene.
struct Surroundings {
  Box box;          ///< that they surround, scene units; model.box lies in it
  float shift = 0;  ///< optical depth of one of a ray's samples: softplus(raw + shift)
  Channels
      raw;  ///< over [-2, 2]^3, outside of [-1, 1]^3: raw density, raw colour; no topology: there are none

  bool any() const { return raw.topology != nullptr; }
};

/// The colour behind the box along a ray: the surroundings, and the background behind them.
Vec3 behind_box(const Background& background, const Surroundings& surroundings, const Ray& ray);

/// The lattice of surroundings, and its bricks. @param cells  along an edge of [-2, 2]^3
/// @{
Lattice outer_lattice(int cells);
TopologyPtr outer_topology(int cells);
/// @}

/// A reconstructed scene: everything rendering needs and nothing it does not.
struct VoxelModel {
  Box box;                    ///< scene units; around it are only the surroundings
  Background background;      ///< behind everything
  float step = 0;             ///< march step, scene units
  TimeMap time_map;           ///< from the data's own time to [0, 1]
  Surroundings surroundings;  ///< behind the box
  RadianceField radiance;
  MotionField motion;

  /// The colour behind the box along a ray.
  Vec3 behind(const Ray& ray) const;
};

}  // namespace splinevox
