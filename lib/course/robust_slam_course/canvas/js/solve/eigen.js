/**
 * All eigenvalues of a dense symmetric matrix of a few dozen rows.
 *
 * The spectrum of a certificate is shown as a whole, and its smallest eigenvalues are often
 * several of one size, which iterations for a single one mix or miss.
 *
 * Source: Golub and Van Loan, section 8.5, Jacobi's method by cyclic sweeps.
 */

const MOST_SWEEPS = 30;

/**
 * Return the eigenvalues (size,) of a symmetric matrix (size, size) by rows, ascending.
 */
export function symmetricEigen(matrix, size) {
  const rows = Array.from({ length: size }, (_, r) => matrix.slice(r * size, (r + 1) * size));
  const negligible = Number.EPSILON * Math.hypot(...matrix);
  for (let sweep = 0, turns = 1; turns > 0 && sweep < MOST_SWEEPS; sweep++) {
    turns = 0;
    for (let p = 0; p < size; p++) {
      for (let q = p + 1; q < size; q++) {
        if (Math.abs(rows[p][q]) <= negligible) continue;
        turnPlane(rows, p, q);
        turns++;
      }
    }
  }
  return Float64Array.from(rows, (row, k) => row[k]).sort();
}

/** Turn the axes p and q so that entry (p, q) becomes 0. */
function turnPlane(rows, p, q) {
  const ratio = (rows[q][q] - rows[p][p]) / (2 * rows[p][q]);
  const tangent = (ratio < 0 ? -1 : 1) / (Math.abs(ratio) + Math.hypot(ratio, 1));
  const cosine = 1 / Math.hypot(tangent, 1);
  const sine = tangent * cosine;
  for (const row of rows) {
    [row[p], row[q]] = [cosine * row[p] - sine * row[q], sine * row[p] + cosine * row[q]];
  }
  const [one, other] = [rows[p], rows[q]];
  for (let c = 0; c < one.length; c++) {
    [one[c], other[c]] = [cosine * one[c] - sine * other[c], sine * one[c] + cosine * other[c]];
  }
}
