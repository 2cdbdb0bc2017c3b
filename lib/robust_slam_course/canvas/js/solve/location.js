/**
 * Problems of one dimension for the loop: a location and a line.
 *
 * Source: as `robust_slam.problems`: Gauss 1809, weighted least squares.
 */

/**
 * Return the problem of one number x from readings `z` with standard deviations `sigma`.
 *
 * `sigma` is a number or one for each reading, in the unit of z; `trusted` a mask, none by
 * default. The whitened residual is u = |z − x|/σ, and x is a number.
 */
export function locationProblem(z, sigma = 1, trusted = null) {
  const readings = Float64Array.from(z);
  const count = readings.length;
  const spread = deviationsOf(sigma, count);
  const problem = {
    count,
    trusted: maskOf(trusted, count),
    initial: () => problem.solve(new Float64Array(count).fill(1), 0),
    residualNorms: (x) => readings.map((reading, k) => Math.abs(reading - x) / spread[k]),
    solve(weights) {
      let total = 0;
      let sum = 0;
      for (let k = 0; k < count; k++) {
        const information = weights[k] / (spread[k] * spread[k]);
        total += information;
        sum += information * readings[k];
      }
      return total === 0 ? null : sum / total;
    },
  };
  return problem;
}

/**
 * Return the problem of a line y = x[0] + x[1] p through points (p, y).
 *
 * `sigma` is a number or (m,) in the unit of y; `trusted` a mask (m,), none by default.
 */
export function lineProblem(p, y, sigma = 1, trusted = null) {
  const count = y.length;
  const spread = deviationsOf(sigma, count);
  const problem = {
    count,
    trusted: maskOf(trusted, count),
    initial: () => problem.solve(new Float64Array(count).fill(1)),
    residuals: (x) => spread.map((deviation, k) => (x[0] + x[1] * p[k] - y[k]) / deviation),
    residualNorms: (x) => problem.residuals(x).map(Math.abs),
    solve(weights) {
      // Scaling rows by √w avoids JᵀJ, which would square the condition number of J.
      const scale = spread.map((deviation, k) => Math.sqrt(weights[k]) / deviation);
      const columns = [scale.slice(), scale.map((s, k) => s * p[k])];
      return leastSquaresByReflections(columns, scale.map((s, k) => s * y[k]));
    },
  };
  return problem;
}

/**
 * Return the x that minimises ‖A x − b‖, or null if the columns of A are linearly dependent.
 *
 * `columns` are the columns of A and `right` is b; both are overwritten.
 *
 * Source: Golub and Van Loan, Householder's QR factorisation with column pivoting.
 */
function leastSquaresByReflections(columns, right) {
  const m = right.length;
  const n = columns.length;
  if (n > m) return null;
  const order = [...columns.keys()];
  const diagonal = new Float64Array(n);
  for (let step = 0; step < n; step++) {
    const longest = longestColumn(columns, step);
    [columns[step], columns[longest]] = [columns[longest], columns[step]];
    [order[step], order[longest]] = [order[longest], order[step]];
    const column = columns[step];
    const length = Math.sqrt(tailProduct(column, column, step));
    // The share below which numpy's lstsq calls a singular value 0.
    const least = 2.220446049250313e-16 * m * Math.abs(step > 0 ? diagonal[0] : 0);
    if (!(length > least)) return null;
    diagonal[step] = column[step] > 0 ? -length : length;
    column[step] -= diagonal[step];
    const square = tailProduct(column, column, step);
    for (const other of [...columns.slice(step + 1), right]) {
      const share = (2 * tailProduct(column, other, step)) / square;
      for (let k = step; k < m; k++) other[k] -= share * column[k];
    }
  }
  const x = new Float64Array(n);
  for (let step = n - 1; step >= 0; step--) {
    let value = right[step];
    for (let later = step + 1; later < n; later++) {
      value -= columns[later][step] * x[order[later]];
    }
    x[order[step]] = value / diagonal[step];
  }
  return x;
}

function longestColumn(columns, step) {
  let longest = step;
  let most = -1;
  for (let column = step; column < columns.length; column++) {
    const square = tailProduct(columns[column], columns[column], step);
    if (square > most) [most, longest] = [square, column];
  }
  return longest;
}

function tailProduct(a, b, from) {
  let sum = 0;
  for (let k = from; k < a.length; k++) sum += a[k] * b[k];
  return sum;
}

function deviationsOf(sigma, count) {
  return typeof sigma === "number"
    ? new Float64Array(count).fill(sigma)
    : Float64Array.from(sigma);
}

function maskOf(mask, count) {
  return mask === null ? new Uint8Array(count) : Uint8Array.from(mask, Number);
}
