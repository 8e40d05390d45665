// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "splinevox/math/basis.hpp"

namespace splinevox {

/// Knots that say the same with fewer: repeated ones and those on a straight line are gone, the identity has
/// none.
/// @pre at least two knots.
inline TimeCurve simplified(std::vector<TimeCurve::Knot> in) {
  std::vector<TimeCurve::Knot> out;
  for (TimeCurve::Knot k : in) {
    k.time = knot_time(k.time);
    if (!out.empty() && out.back() == k) continue;
    // Of several values at one time the first and the last count.
    if (out.size() >= 2 && out.back().time == k.time && out[out.size() - 2].time == k.time) out.pop_back();
    if (out.size() >= 2) {
      const TimeCurve::Knot &a = out[out.size() - 2], &b = out.back();
      if (a.time < b.time && b.time < k.time &&
          (b.value - a.value) * (k.time - b.time) == (k.value - b.value) * (b.time - a.time))
        out.pop_back();
    }
    out.push_back(k);
  }
  if (out.size() == 2 && out[0] == TimeCurve::Knot{0, 0} && out[1] == TimeCurve::Knot{1, 1}) out.clear();
  return {std::move(out)};
}

/// outer(inner(t)): the times of a curve are changed once more. Exact up to the rounding of the values: the
/// parts of both are straight, so the parts of the result are.
inline TimeCurve compose(const TimeCurve& outer, const TimeCurve& inner) {
  if (inner.identity()) return outer;
  if (outer.identity()) return inner;
  // A value that means a knot of `outer` must hit it: just behind a jump is its other side.
  const auto on_a_knot_time = [](TimeCurve::Knot k) { return TimeCurve::Knot{k.time, knot_time(k.value)}; };
  std::vector<TimeCurve::Knot> out;
  for (std::size_t i = 0; i + 1 < inner.knots.size(); ++i) {
    const TimeCurve::Knot a = on_a_knot_time(inner.knots[i]), b = on_a_knot_time(inner.knots[i + 1]);
    if (a.time == b.time) continue;
    const bool rises = a.value < b.value;
    const auto at = [&](double v, bool after) { return after ? outer(v) : outer.before(v); };
    out.push_back({a.time, at(a.value, a.value <= b.value)});
    std::vector<TimeCurve::Knot> between;
    for (const TimeCurve::Knot& k : outer.knots)
      if (k.time > std::min(a.value, b.value) && k.time < std::max(a.value, b.value))
        between.push_back({a.time + (b.time - a.time) * ((k.time - a.value) / (b.value - a.value)), k.value});
    if (!rises) std::reverse(between.begin(), between.end());
    out.insert(out.end(), between.begin(), between.end());
    out.push_back({b.time, a.value == b.value ? out.back().value : at(b.value, !rises)});
  }
  return simplified(std::move(out));
}

/// Backwards: time t shows what 1 - t showed.
inline TimeCurve reversed_time() { return simplified({{0, 1}, {1, 0}}); }
/// `speed` times as fast from the beginning; faster than 1 it holds the end, slower it shows the first part
/// only. @pre speed > 0
inline TimeCurve speed_time(double speed) {
  if (speed <= 1) return simplified({{0, 0}, {1, speed}});
  return simplified({{0, 0}, {1 / speed, 1}, {1, 1}});
}
/// All of it `count` times; there and back instead of jumping if `back`. @pre count >= 1
inline TimeCurve loop_time(int count, bool back) {
  std::vector<TimeCurve::Knot> k;
  for (int i = 0; i < count; ++i) {
    k.push_back({double(i) / count, 0});
    if (back) k.push_back({(i + 0.5) / count, 1});
    k.push_back({double(i + 1) / count, back ? 0.0 : 1.0});
  }
  return simplified(std::move(k));
}
/// One moment for ever. @pre at in [0, 1]
inline TimeCurve frozen_time(double at) { return simplified({{0, at}, {1, at}}); }

}  // namespace splinevox
