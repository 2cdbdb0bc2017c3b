/**
 * All eigenvalues and eigenvectors of a dense symmetric matrix of a few dozen rows.
 *
 * The spectrum of a certificate is shown as a whole, and its smallest eigenvalues are often
 * several of one size, which iterations for a single one mix or miss.
 *
 * Source: Golub and Van Loan, section 8.5, Jacobi's method by cyclic sweeps.
 */

const MOST_SWEEPS = 30;

/**
 * Return { values, vectors } of a symmetric matrix (size, size) by rows: the eigenvalues
 * ascending, and row k of `vectors` the unit eigenvector of value k.
 */
export function symmetricEigen(matrix, size) {
  const rows = Array.from({ length: size }, (_, r) => matrix.slice(r * size, (r + 1) * size));
  const turned = rows.map((_, r) => new Float64Array(size).fill(1, r, r + 1));
  const negligible = Number.EPSILON * Math.hypot(...matrix);
  for (let sweep = 0, turns = 1; turns > 0 && sweep < MOST_SWEEPS; sweep++) {
    turns = 0;
    for (let p = 0; p < size; p++) {
      for (let q = p + 1; q < size; q++) {
        if (Math.abs(rows[p][q]) <= negligible) continue;
        turnPlane(rows, turned, p, q);
        turns++;
      }
    }
  }
  const order = [...rows.keys()].sort((a, b) => rows[a][a] - rows[b][b]);
  const vectors = Float64Array.from(order.flatMap((k) => [...turned[k]]));
  return { values: Float64Array.from(order, (k) => rows[k][k]), vectors };
}

/** Turn the axes p and q so that entry (p, q) becomes 0. */
function turnPlane(rows, turned, p, q) {
  const ratio = (rows[q][q] - rows[p][p]) / (2 * rows[p][q]);
  const tangent = (ratio < 0 ? -1 : 1) / (Math.abs(ratio) + Math.hypot(ratio, 1));
  const cosine = 1 / Math.hypot(tangent, 1);
  const sine = tangent * cosine;
  for (const row of rows) {
    [row[p], row[q]] = [cosine * row[p] - sine * row[q], sine * row[p] + cosine * row[q]];
  }
  for (const [one, other] of [[rows[p], rows[q]], [turned[p], turned[q]]]) {
    for (let c = 0; c < one.length; c++) {
      [one[c], other[c]] = [cosine * one[c] - sine * other[c], sine * one[c] + cosine * other[c]];
    }
  }
}
