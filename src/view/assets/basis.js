// The weights of the control points at a time: include/splinevox/math/basis.hpp, basis_pieces.hpp and
// time_curve.hpp once more, because a page runs alone. The browser test compares them.

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

/// Where a time lies among equal parts of [0, 1].
function pieceOf(pieces, t) {
  const index = Math.min(pieces - 1, Math.floor(t * pieces));
  return {index, u: t * pieces - index};
}

function polyBezierWeights(points, t) {
  const {index, u} = pieceOf((points - 1) / 3, t);
  const w = new Float64Array(points);
  w.set(bernsteinWeights(4, u), 3 * index);
  return w;
}

function hermiteWeights(points, t) {
  const pieces = points / 2 - 1, {index, u} = pieceOf(pieces, t), b = bernsteinWeights(4, u);
  const w = new Float64Array(points);
  w.set([b[0] + b[1], b[1] / (3 * pieces), b[2] + b[3], -b[2] / (3 * pieces)], 2 * index);
  return w;
}

const kBases = {
  bezier: bernsteinWeights, bspline: bsplineWeights, poly_bezier: polyBezierWeights, hermite: hermiteWeights
};

/// The parameter of the curves that is shown at a time: piecewise linear between knots [time, value], after a
/// jump at one; without knots the time itself.
function curveParameter(knots, t) {
  t = Math.min(1, Math.max(0, t));
  if (!knots || knots.length === 0) return t;
  const near = Math.round(t * 2 ** 40) / 2 ** 40;  // knots are such times
  let found = 0;
  for (let i = 0; i + 1 < knots.length; ++i)
    if (knots[i][0] < knots[i + 1][0] && (knots[i][0] <= near || i === 0)) found = i;
  const [a, b] = [knots[found], knots[found + 1]];
  return near === b[0] ? b[1] : a[1] + (b[1] - a[1]) * ((Math.max(t, a[0]) - a[0]) / (b[0] - a[0]));
}

/// Of the stored points: a first point that is pinned to zero is not among them.
function storedWeights(motion, t) {
  const weights = kBases[motion.basis](motion.points, curveParameter(motion.time_curve, t));
  return weights.subarray(motion.points - motion.stored);
}
