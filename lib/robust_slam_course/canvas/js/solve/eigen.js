/**
 * All eigenvalues and eigenvectors of a dense symmetric matrix.
 *
 * The spectrum of a certificate is shown as a whole, and its smallest eigenvalues are often
 * several of one size, which iterations for a single one mix or miss. So the matrix is reduced to
 * tridiagonal form, and the QL method gives all of them at once: about 30 ms for 200 rows.
 *
 * Source: Martin, Reinsch and Wilkinson 1968 for the reduction, Bowdler et al. 1968 for the QL
 * method; Golub and Van Loan, chapter 8.
 */

/**
 * Return { values, vectors } of a symmetric matrix (size, size) by rows: the eigenvalues
 * ascending, and row k of `vectors` the unit eigenvector of value k.
 */
export function symmetricEigen(matrix, size) {
  const rows = Array.from({ length: size }, (_, r) => matrix.slice(r * size, (r + 1) * size));
  const { diagonal, beside } = tridiagonalised(rows, size);
  diagonalised(rows, diagonal, beside);
  const order = [...diagonal.keys()].sort((a, b) => diagonal[a] - diagonal[b]);
  const vectors = new Float64Array(size * size);
  order.forEach((from, to) => vectors.set(rows[from], to * size));
  return { values: Float64Array.from(order, (k) => diagonal[k]), vectors };
}

/**
 * Reduce A, in `rows`, to tridiagonal form T = H A Hᵀ and replace the rows by those of H.
 *
 * Returns the diagonal of T and the entries beside it, the first of them unused.
 */
function tridiagonalised(rows, size) {
  const diagonal = new Float64Array(size);
  const beside = new Float64Array(size);
  const reflectors = [];
  for (let k = size - 1; k > 0; k--) {
    // A reflection of the first k coordinates leaves one entry of row k beside the diagonal.
    const reflector = Float64Array.from(rows[k].subarray(0, k));
    const length = Math.hypot(...reflector);
    beside[k] = reflector[k - 1] > 0 ? -length : length;
    reflector[k - 1] -= beside[k];
    const square = reflector.reduce((sum, entry) => sum + entry * entry, 0);
    reflectors.push({ reflector, square });
    if (square > 0) reflectBothSides(rows, reflector, square);
    diagonal[k] = rows[k][k];
  }
  if (size > 0) diagonal[0] = rows[0][0];
  accumulate(rows, reflectors);
  return { diagonal, beside };
}

/** Replace the leading block A by P A P with the reflection P = I − 2 v vᵀ / ‖v‖². */
function reflectBothSides(rows, v, square) {
  const k = v.length;
  const image = new Float64Array(k);
  let along = 0;
  for (let r = 0; r < k; r++) {
    let sum = 0;
    for (let c = 0; c < k; c++) sum += rows[r][c] * v[c];
    image[r] = (2 * sum) / square;
    along += image[r] * v[r];
  }
  const half = along / square;
  for (let r = 0; r < k; r++) image[r] -= half * v[r];
  for (let r = 0; r < k; r++) {
    const row = rows[r];
    for (let c = 0; c < k; c++) row[c] -= v[r] * image[c] + image[r] * v[c];
  }
}

/** Replace the rows by those of the product H of the reflections, the last applied first. */
function accumulate(rows, reflectors) {
  rows.forEach((row, r) => row.fill(0).fill(1, r, r + 1));
  for (const { reflector, square } of reflectors.reverse()) {
    if (square === 0) continue;
    const k = reflector.length;
    for (const row of rows.slice(0, k)) {
      let sum = 0;
      for (let c = 0; c < k; c++) sum += row[c] * reflector[c];
      const share = (2 * sum) / square;
      for (let c = 0; c < k; c++) row[c] -= share * reflector[c];
    }
  }
}

/** Turn the tridiagonal matrix to its eigenvalues, in `diagonal`, and the rows with it. */
function diagonalised(rows, diagonal, beside) {
  const size = diagonal.length;
  for (let k = 1; k < size; k++) beside[k - 1] = beside[k];
  if (size > 0) beside[size - 1] = 0;
  for (let first = 0; first < size; first++) {
    for (;;) {
      const last = endOfBlock(diagonal, beside, first);
      if (last === first) break;
      sweep(rows, diagonal, beside, first, last);
    }
  }
}

/** Return the last row of the block that begins at `first` and has no 0 beside the diagonal. */
function endOfBlock(diagonal, beside, first) {
  for (let k = first; k < diagonal.length - 1; k++) {
    const size = Math.abs(diagonal[k]) + Math.abs(diagonal[k + 1]);
    if (Math.abs(beside[k]) <= Number.EPSILON * size) return k;
  }
  return diagonal.length - 1;
}

/** One QL sweep with Wilkinson's shift, from row `last` up to row `first`. */
function sweep(rows, diagonal, beside, first, last) {
  const ratio = (diagonal[first + 1] - diagonal[first]) / (2 * beside[first]);
  const root = Math.hypot(ratio, 1);
  const away = ratio + (ratio < 0 ? -root : root);
  let g = diagonal[last] - diagonal[first] + beside[first] / away;
  let [sine, cosine, shift] = [1, 1, 0];
  for (let k = last - 1; k >= first; k--) {
    const f = sine * beside[k];
    const b = cosine * beside[k];
    const r = Math.hypot(f, g);
    beside[k + 1] = r;
    if (r === 0) {
      diagonal[k + 1] -= shift;
      beside[last] = 0;
      return;
    }
    sine = f / r;
    cosine = g / r;
    g = diagonal[k + 1] - shift;
    const turned = (diagonal[k] - g) * sine + 2 * cosine * b;
    shift = sine * turned;
    diagonal[k + 1] = g + shift;
    g = cosine * turned - b;
    turnRows(rows[k], rows[k + 1], cosine, sine);
  }
  diagonal[first] -= shift;
  beside[first] = g;
  beside[last] = 0;
}

function turnRows(low, high, cosine, sine) {
  for (let c = 0; c < low.length; c++) {
    const f = high[c];
    high[c] = sine * low[c] + cosine * f;
    low[c] = cosine * low[c] - sine * f;
  }
}
