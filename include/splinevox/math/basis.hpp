// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace splinevox {

inline constexpr int kMinPoints = 2, kMaxPoints = 256;  ///< control points of a curve of any basis

/// Spherical harmonics have orders 0 to kMaxShOrder (math/sh.hpp).
inline constexpr int kMaxShOrder = 3;
inline constexpr int kMaxShCount = (kMaxShOrder + 1) * (kMaxShOrder + 1);

/// Weights of up to kMaxPoints control points; entries past the basis' own count are 0.
template <class T>
using BasisWeights = std::array<T, kMaxPoints>;

/// What a curve sum_k w_k(s) p_k over s in [0, 1] is made of. What each is: basis_of.
enum class BasisKind { bezier, bspline, poly_bezier, hermite };

/// The numbers of control points that a basis allows: least, least + step, ... to most.
struct PointRule {
  int least = kMinPoints, most = kMaxPoints, step = 1;
  const char* reason = nullptr;  ///< for whoever reads an error message; null: none

  constexpr bool allows(int points) const {
    return points >= least && points <= most && (points - least) % step == 0;
  }
  /// "2 to 256 points", or "4, 7, 10, ... points", and the reason.
  std::string text() const;
};

/// How curves get more control points and stay as they are, to rounding.
struct Refinement {
  enum class Kind {
    none,
    elevation,  ///< one degree more, K -> K + 1
    halving     ///< every span of a uniform cubic spline in two, K -> 2K - 3
  };
  Kind kind = Kind::none;
  /// One component of a curve, [K] -> [refined(K)]. `out` may not alias `in`. Null if kind is none.
  void (*in_float)(int points, const float* in, float* out) = nullptr;
  void (*in_double)(int points, const double* in, double* out) = nullptr;

  constexpr int refined(int points) const {
    return kind == Kind::none ? points : kind == Kind::elevation ? points + 1 : 2 * points - 3;
  }
  void operator()(int points, const float* in, float* out) const { in_float(points, in, out); }
  void operator()(int points, const double* in, double* out) const { in_double(points, in, out); }
};

/// Everything there is to know about a basis; whoever handles curves asks here. A new one is an entry of
/// src/math/bases.cpp, and a twin in src/view/assets/basis.js.
struct Basis {
  BasisKind kind;
  const char* name;  ///< in files, configurations, on the command line and in the viewer
  bool trained;      ///< false: only `edit` makes it
  PointRule points;
  int full;       ///< points from which on it has its full degree; training asks for as many
  bool pinnable;  ///< curves begin in their first point, which may be pinned to zero (FirstPoint)
  bool local;     ///< made of pieces, each point felt by a few; false: one polynomial
  int smooth;     ///< derivatives that are continuous where pieces meet, whatever the points; 0 if not local
  int per_node;   ///< points in a row that belong to one place: the place, then its velocity if it is 2
  Refinement refinement;
  int (*pieces)(int points);     ///< cubic pieces; of one polynomial those that have about as many points
  int (*points_of)(int pieces);  ///< the inverse
  /// w_k(s) and d w_k / d s of `points` control points. @param s  in [0, 1]; the caller clamps.
  BasisWeights<double> (*weights)(int points, double s);
  BasisWeights<double> (*weights_dt)(int points, double s);

  constexpr bool elevates() const { return refinement.kind == Refinement::Kind::elevation; }
  constexpr bool halves() const { return refinement.kind == Refinement::Kind::halving; }
  /// Whether point k is a place; a velocity otherwise. The weights of the places sum to 1.
  constexpr bool is_place(int k) const { return k % per_node == 0; }
  /// The numbers of points that can be trained.
  constexpr PointRule trained_points() const { return {full, points.most, points.step, points.reason}; }
  /// Most points of a curve that will be refined so many times; fewer than `full` where that is too often for
  /// any.
  int most_points(int refinements) const;
};

/// Every basis, in the order of BasisKind.
std::span<const Basis> all_bases();
const Basis& basis_of(BasisKind kind);
/// Null: there is none of that name.
const Basis* find_basis(std::string_view name);
/// Names of all of them, or of those that a test lets through.
std::vector<std::string> basis_names(bool (*which)(const Basis&) = nullptr);
/// "bezier or bspline": those that can be trained.
const char* trained_basis_names();

/// Points with which a basis holds curves of another one exactly, where it can; else about as many as there
/// were. May be more than it allows.
int points_to_hold(const Basis& old, int points, const Basis& wanted);

/// The nearest time that a knot of a TimeCurve may have.
inline double knot_time(double t) { return std::round(t * 0x1p40) * 0x1p-40; }

/// Which parameter of the motion's curves is shown at which model time: piecewise linear, jumps allowed. What
/// `edit` does to time is done here, so it costs no rounding of the control points and can be taken back.
///
/// Times are kept as whole multiples of 2^-40 (below any frame): 1 - t is then exact, and a curve that is
/// reversed twice has its own bits again. A third is none of them, so a time meets the knot that is nearest
/// to it.
struct TimeCurve {
  struct Knot {
    double time = 0;   ///< model time in [0, 1]; the first is 0, the last 1, none below the one before. Equal
                       ///< times are a jump.
    double value = 0;  ///< parameter of the motion's curves, in [0, 1]
    friend bool operator==(const Knot&, const Knot&) = default;
  };
  std::vector<Knot> knots;  ///< empty: the identity; at most kMost in a model's file
  static constexpr std::size_t kMost = 1 << 16;

  bool identity() const { return knots.empty(); }
  friend bool operator==(const TimeCurve&, const TimeCurve&) = default;

  /// Parameter at a time, clamped to [0, 1]. At a jump: the value after it; at one at 1, which nothing
  /// follows, before it.
  double operator()(double t) const {
    t = std::clamp(t, 0.0, 1.0);
    if (identity()) return t;
    const std::size_t i = segment(t);
    const Knot &a = knots[i], &b = knots[i + 1];
    if (knot_time(t) == b.time) return b.value;
    return a.value + (b.value - a.value) * ((std::max(t, a.time) - a.time) / (b.time - a.time));
  }
  /// d parameter / d time, of the part after a kink; at the end of the part before it.
  double slope(double t) const {
    if (identity()) return 1;
    const std::size_t i = segment(std::clamp(t, 0.0, 1.0));
    return (knots[i + 1].value - knots[i].value) / (knots[i + 1].time - knots[i].time);
  }
  /// The value just before a jump; elsewhere as operator().
  double before(double t) const {
    if (identity()) return t;
    for (std::size_t i = 1; i < knots.size(); ++i)
      if (knots[i].time == knot_time(t)) return knots[i].value;
    return (*this)(t);
  }

 private:
  /// The last part of more than no length that begins at t or earlier.
  std::size_t segment(double t) const {
    t = knot_time(t);
    std::size_t found = 0;
    for (std::size_t i = 0; i + 1 < knots.size(); ++i)
      if (knots[i].time < knots[i + 1].time && (knots[i].time <= t || i == 0)) found = i;
    return found;
  }
};

}  // namespace splinevox
