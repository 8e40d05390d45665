// The weights of the control points at a time: include/splinevox/math/basis.hpp once more, because a page runs alone. The browser test
// compares the two.

function bernsteinWeights(points, t) {
  const w = new Float64Array(points);
  w[0] = 1;
  for (let degree = 1; degree < points; ++degree) {
    for (let k = degree; k > 0; --k) w[k] = (1 - t) * w[k] + t * w[k - 1];
    w[0] = (1 - t) * w[0];
  }
  return w;
}

function bsplineWeights(points, t) {
  const degree = Math.min(3, points - 1), spans = points - degree;
  const knot = i => (i - degree) / spans;
  let span = degree;
  while (span < points - 1 && !(t < knot(span + 1))) ++span;
  const b = [1, 0, 0, 0];
  for (let d = 1; d <= degree; ++d) {
    let carried = 0;
    for (let j = 0; j < d; ++j) {
      const lo = knot(span + 1 - d + j), hi = knot(span + 1 + j), share = b[j] / (hi - lo);
      b[j] = carried + (hi - t) * share;
      carried = (t - lo) * share;
    }
    b[d] = carried;
  }
  const w = new Float64Array(points);
  for (let j = 0; j <= degree; ++j) w[span - degree + j] = b[j];
  return w;
}

/// Of the stored points: a first point that is pinned to zero is not among them.
function storedWeights(motion, t) {
  const all = (motion.basis === "bezier" ? bernsteinWeights : bsplineWeights)(motion.points, Math.min(1, Math.max(0, t)));
  return all.subarray(motion.points - motion.stored);
}
