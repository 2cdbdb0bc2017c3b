/**
 * Cholesky factorisation of a symmetric matrix whose rows begin late: the skyline.
 *
 * Row r is stored from its first entry that is not 0, column first[r], up to the diagonal. The
 * factor fills no entry outside the skyline, so it replaces the matrix. The poses of a drive give
 * short rows, and each loop closure lengthens the rows of one pose.
 *
 * Source: George and Liu 1981, "Computer Solution of Large Sparse Positive Definite Systems",
 * chapter 4, the envelope method.
 */

/**
 * Return the pattern of a matrix whose row r begins at column `first[r]`, at most r.
 *
 * Entry (r, c) is at start[r] + c of an array of `length` numbers.
 */
export function skylinePattern(first) {
  const size = first.length;
  const start = new Int32Array(size);
  let length = 0;
  for (let r = 0; r < size; r++) {
    start[r] = length - first[r];
    length += r - first[r] + 1;
  }
  return { size, first: Int32Array.from(first), start, length };
}

/**
 * Replace the lower triangle A in `values` by L with A = L Lᵀ; false if A is not positive
 * definite. `values` is then no longer A.
 */
export function skylineFactor({ size, first, start }, values) {
  for (let r = 0; r < size; r++) {
    const row = start[r];
    const begin = first[r];
    let pivot = values[row + r];
    for (let c = begin; c < r; c++) {
      const other = start[c];
      let entry = values[row + c];
      for (let k = Math.max(begin, first[c]); k < c; k++) {
        entry -= values[row + k] * values[other + k];
      }
      entry /= values[other + c];
      values[row + c] = entry;
      pivot -= entry * entry;
    }
    if (!(pivot > 0)) return false;
    values[row + r] = Math.sqrt(pivot);
  }
  return true;
}

/** Replace `right` (size,) by the solution of L Lᵀ x = right, with L from `skylineFactor`. */
export function skylineSolve({ size, first, start }, values, right) {
  for (let r = 0; r < size; r++) {
    const row = start[r];
    let entry = right[r];
    for (let c = first[r]; c < r; c++) entry -= values[row + c] * right[c];
    right[r] = entry / values[row + r];
  }
  for (let r = size - 1; r >= 0; r--) {
    const row = start[r];
    const entry = right[r] / values[row + r];
    right[r] = entry;
    for (let c = first[r]; c < r; c++) right[c] -= values[row + c] * entry;
  }
}

/**
 * Return the factor { pattern, values } of a full symmetric A (size, size) by rows; null if A is
 * not positive definite.
 */
export function denseFactor(A, size) {
  const pattern = skylinePattern(new Int32Array(size));
  const values = new Float64Array(pattern.length);
  for (let r = 0; r < size; r++) {
    for (let c = 0; c <= r; c++) values[pattern.start[r] + c] = A[r * size + c];
  }
  return skylineFactor(pattern, values) ? { pattern, values } : null;
}
