/**
 * Problems of one dimension for the loop: a location and a line. No measurement is trusted.
 *
 * Source: as `robust_slam.problems`: Gauss 1809, weighted least squares.
 */

/**
 * Return the problem of one number x from readings `z` with the standard deviation `sigma`.
 *
 * `sigma` is in the unit of z. The whitened residual is u = |z − x|/σ, and x is a number.
 */
export function locationProblem(z, sigma = 1) {
  const readings = Float64Array.from(z);
  const problem = {
    count: readings.length,
    trusted: new Uint8Array(readings.length),
    initial: () => problem.solve(readings.map(() => 1)),
    residualNorms: (x) => readings.map((reading) => Math.abs(reading - x) / sigma),
    solve: (weights) => weightedMean(weights, readings),
  };
  return problem;
}

/** Return the problem of a line y = x[0] + x[1] p through points (p, y), `sigma` as above. */
export function lineProblem(p, y, sigma) {
  const problem = {
    count: y.length,
    trusted: new Uint8Array(y.length),
    initial: () => problem.solve(Float64Array.from(p, () => 1)),
    residuals: (x) => Float64Array.from(p, (place, k) => (x[0] + x[1] * place - y[k]) / sigma),
    residualNorms: (x) => problem.residuals(x).map(Math.abs),
    solve(weights) {
      // Places count from their mean, or nearly equal ones would lose their digits.
      const middle = weightedMean(weights, p);
      const places = p.map((place) => place - middle);
      const spread = weights.reduce((sum, w, k) => sum + w * places[k] ** 2, 0);
      const rounding = 1e-28 * weights.reduce((sum, w, k) => sum + w * p[k] ** 2, 0);
      if (!(spread > rounding)) return null;
      const height = weightedMean(weights, y);
      const tilt = weights.reduce((sum, w, k) => sum + w * places[k] * (y[k] - height), 0);
      return [height - (tilt / spread) * middle, tilt / spread];
    },
  };
  return problem;
}

/**
 * Return the leverage of each reading at places `p` (m,) on a line fitted by least squares.
 *
 * It is the share of a reading's movement that the fit at its place follows, between 1/m and 1.
 *
 * Source: Hoaglin and Welsch 1978, the diagonal of the hat matrix.
 */
export function lineLeverages(p) {
  const mean = p.reduce((sum, place) => sum + place, 0) / p.length;
  const spread = p.reduce((sum, place) => sum + (place - mean) ** 2, 0);
  return Float64Array.from(p, (place) => 1 / p.length + (place - mean) ** 2 / spread);
}

/** Return Σ w a / Σ w, null where all weights are 0. */
function weightedMean(weights, values) {
  const total = weights.reduce((sum, w) => sum + w, 0);
  return total === 0 ? null : weights.reduce((sum, w, k) => sum + w * values[k], 0) / total;
}
