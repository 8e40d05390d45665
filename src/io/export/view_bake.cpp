// SPDX-License-Identifier: Apache-2.0
#include "io/export/view_bake.hpp"

#include <charconv>
#include <cmath>

#include "math/sh.hpp"
#include "math/sphere_rule.hpp"
#include "math/view_factor.hpp"
#include "splinevox/core/error.hpp"

namespace splinevox {
namespace {

Vec3d parse_direction(const std::string& spec) {
  Vec3d d{};
  const char *at = spec.data() + 4, *end = spec.data() + spec.size();
  bool ok = spec.starts_with("dir=");
  for (int a = 0; ok && a < 3; ++a) {
    const auto [stop, error] = std::from_chars(at, end, d[a]);
    ok = error == std::errc() && std::isfinite(d[a]) && (a == 2 ? stop == end : stop != end && *stop == ',');
    at = stop + 1;
  }
  if (!ok || length(d) < 1e-12)
    fail({.where = "--bake-view",
          .what = "cannot be understood",
          .expected = "mean, none or dir=x,y,z (not zero)",
          .got = "'" + spec.substr(0, 80) + "'",
          .hint = ""});
  return normalize(d);
}

}  // namespace

ViewBake::ViewBake(const std::string& spec, int sh_order) : count_((sh_order + 1) * (sh_order + 1)) {
  if (spec == "none") return;
  std::vector<Vec3d> directions;
  if (spec == "mean") {
    for (const SpherePoint& point : sphere_rule()) {
      directions.push_back(point.direction);
      weights_.push_back(float(point.weight));
    }
  } else {
    directions.push_back(parse_direction(spec));
    weights_.push_back(1);
  }
  if (count_ == 0) weights_.clear();
  for (const Vec3d& d : directions) {
    double y[kMaxShCount];
    if (sh_order >= 0) sh_basis(sh_order, d, y);
    for (int j = 0; j < count_; ++j) basis_.push_back(float(y[j]));
  }
}

float ViewBake::factor(const float* sh) const {
  if (weights_.empty()) return 1;
  float sum = 0;
  const float* y = basis_.data();
  for (const float weight : weights_) {
    float q = 0;
    for (int j = 0; j < count_; ++j) q += sh[j] * y[j];
    sum += weight * view_factor(q).value;
    y += count_;
  }
  return sum;
}

}  // namespace splinevox
