// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <iterator>

#include "math/basis_pieces.hpp"
#include "math/bernstein.hpp"
#include "math/bspline.hpp"

namespace splinevox {
namespace {

constexpr int kDegree = 3;  ///< of every piece
using Kind = Refinement::Kind;

constexpr Basis kBases[] = {
    {.kind = BasisKind::bezier,
     .name = "bezier",
     .trained = true,
     .points = {.most = kMaxBezierPoints, .reason = "a bspline takes more"},
     .full = kMinPoints,
     .pinnable = true,
     .local = false,
     .smooth = 0,
     .per_node = 1,
     .refinement = {Kind::elevation, elevate_bezier<float>, elevate_bezier<double>},
     .pieces = [](int points) { return std::max(1, (points + 1) / kDegree); },
     .points_of = [](int pieces) { return std::min(kDegree * pieces + 1, kMaxBezierPoints); },
     .weights = bernstein_weights<double>,
     .weights_dt = bernstein_weights_dt<double>},
    {.kind = BasisKind::bspline,
     .name = "bspline",
     .trained = true,
     .points = {},
     .full = kDegree + 1,
     .pinnable = false,
     .local = true,
     .smooth = 2,
     .per_node = 1,
     .refinement = {Kind::halving, halve_bspline<float>, halve_bspline<double>},
     .pieces = [](int points) { return std::max(1, points - kDegree); },
     .points_of = [](int pieces) { return pieces + kDegree; },
     .weights = [](int points, double s) { return bspline_weights(points, s); },
     .weights_dt = bspline_weights_dt<double>},
    {.kind = BasisKind::poly_bezier,
     .name = "poly_bezier",
     .trained = false,
     .points = {4, kMaxPoints, 3, "one more than a multiple of 3"},
     .full = 4,
     .pinnable = true,
     .local = true,
     .smooth = 0,
     .per_node = 1,
     .refinement = {},
     .pieces = [](int points) { return (points - 1) / kDegree; },
     .points_of = [](int pieces) { return kDegree * pieces + 1; },
     .weights = poly_bezier_weights<double>,
     .weights_dt = poly_bezier_weights_dt<double>},
    {.kind = BasisKind::hermite,
     .name = "hermite",
     .trained = false,
     .points = {4, kMaxPoints, 2, "a place and a velocity a node"},
     .full = 4,
     .pinnable = true,
     .local = true,
     .smooth = 1,
     .per_node = 2,
     .refinement = {},
     .pieces = [](int points) { return points / 2 - 1; },
     .points_of = [](int pieces) { return 2 * (pieces + 1); },
     .weights = hermite_weights<double>,
     .weights_dt = hermite_weights_dt<double>},
};

constexpr bool in_order() {
  for (std::size_t i = 0; i < std::size(kBases); ++i)
    if (kBases[i].kind != BasisKind(i)) return false;
  return true;
}
static_assert(in_order(), "bases stand in the order of BasisKind");

}  // namespace

std::string PointRule::text() const {
  std::string out = std::to_string(least);
  if (step == 1)
    out += " to " + std::to_string(most) + " points";
  else
    out += ", " + std::to_string(least + step) + ", " + std::to_string(least + 2 * step) + ", ... points";
  return reason ? out + ": " + reason : out;
}

int Basis::most_points(int refinements) const {
  const auto fits = [&](int k) {
    for (int i = 0; i < refinements && k <= points.most && refinement.refined(k) > k; ++i)
      k = refinement.refined(k);
    return k <= points.most;
  };
  int k = points.most;
  while (k >= full && !fits(k)) --k;
  return k;
}

std::span<const Basis> all_bases() { return kBases; }

const Basis& basis_of(BasisKind kind) { return kBases[std::size_t(kind)]; }

const Basis* find_basis(std::string_view name) {
  const auto at =
      std::find_if(std::begin(kBases), std::end(kBases), [&](const Basis& b) { return b.name == name; });
  return at == std::end(kBases) ? nullptr : at;
}

std::vector<std::string> basis_names(bool (*which)(const Basis&)) {
  std::vector<std::string> out;
  for (const Basis& b : kBases)
    if (!which || which(b)) out.emplace_back(b.name);
  return out;
}

const char* trained_basis_names() {
  static const std::string text = [] {
    std::string out;
    for (const std::string& name : basis_names([](const Basis& b) { return b.trained; }))
      out += (out.empty() ? "" : " or ") + name;
    return out;
  }();
  return text.c_str();
}

int points_to_hold(const Basis& old, int points, const Basis& wanted) {
  if (!wanted.local) return std::min(points, wanted.points.most);
  const int exact = wanted.points_of(old.pieces(points));
  // One polynomial of many points is none of so many cubic pieces: where any number will do, it keeps its
  // own.
  return old.local || wanted.points.step > 1 ? exact : std::max(exact, points);
}

}  // namespace splinevox
