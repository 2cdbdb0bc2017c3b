/**
 * The certificate of global optimality for rotations in the plane.
 *
 * Rotations are the blocks of R (2 × 2n, by rows) side by side. The cost Σ ‖R_j − R_i R̃‖²_F,
 * without a ½, is tr(R Q Rᵀ). Let S = Q − Λ with Λ block diagonal, Λ_i = sym(R_iᵀ (R Q)_i). If S Rᵀ = 0 and S ⪰ 0, no rotations cost less. With
 * S + η I ⪰ 0 any rotations cost at least tr Λ − 2 n η, whether R is stationary or not.
 *
 * It is about the cost of the edges that are kept, and says nothing about outliers.
 *
 * Source: as `robust_slam.certificates.sdp`, `chordal` and `optimality`: Rosen et al. 2019,
 * "SE-Sync", Theorem 7 and equations (107) and (112).
 */
import { symmetricEigen } from "./eigen.js";
import { denseFactor } from "./skyline.js";

/** The largest stationarity of rotations that count as stationary. */
const STATIONARY = 1e-9;

/** The first shift of the Cholesky test and the largest that is rounding, relative to Q. */
const FIRST_SHIFT = 1e-12;
const ROUNDING_SHIFT = 2e-11;

/** An optimality gap, relative to the cost, that counts as rounding. */
const ROUNDING_GAP = 1e-9;

/**
 * Return Q (2n, 2n) of the headings alone, with tr(R Q Rᵀ) = Σ ‖R_j − R_i R̃‖²_F.
 *
 * `edges` [[i, j], …] (m, 2); `turns` (m,) are the measured angles in rad.
 */
export function connectionMatrix(n, edges, turns) {
  const Q = new Float64Array(4 * n * n);
  edges.forEach(([i, j], k) => {
    const [cosine, sine] = [Math.cos(turns[k]), Math.sin(turns[k])];
    addBlock(Q, n, i, i, [1, 0, 0, 1]);
    addBlock(Q, n, j, j, [1, 0, 0, 1]);
    addBlock(Q, n, i, j, [-cosine, sine, -sine, -cosine]);
    addBlock(Q, n, j, i, [-cosine, -sine, sine, -cosine]);
  });
  return Q;
}

/** Return R (2, 2n) of headings (n,) in rad. */
export function headingsRow(angles) {
  const width = 2 * angles.length;
  const R = new Float64Array(2 * width);
  angles.forEach((angle, i) => {
    R[2 * i] = R[width + 2 * i + 1] = Math.cos(angle);
    R[width + 2 * i] = Math.sin(angle);
    R[2 * i + 1] = -Math.sin(angle);
  });
  return R;
}

/** Return tr(R Q Rᵀ) of R (2, 2n), which is a sum of squares and so at least 0. */
export function quadraticCost(Q, R) {
  return Math.max(0, dotProduct(rowsTimes(R, Q), R));
}

/** Return the λ_i (n,) of Λ_i = λ_i I: of rotations in the plane sym(R_iᵀ (R Q)_i) is such a block. */
function multipliersOf(Q, R) {
  const products = rowsTimes(R, Q).map((value, k) => value * R[k]);
  const width = R.length / 2;
  return Float64Array.from({ length: width / 2 }, (_, i) => 0.5 * (
    products[2 * i] + products[2 * i + 1] + products[width + 2 * i] + products[width + 2 * i + 1]));
}

/** Return R A (2, width) for R (2, width) and a symmetric A (width, width). */
function rowsTimes(R, A) {
  const width = R.length / 2;
  return R.map((_, k) => {
    const own = R.subarray(k < width ? 0 : width, k < width ? width : 2 * width);
    return dotProduct(own, A.subarray((k % width) * width, ((k % width) + 1) * width));
  });
}

/** Return Σ a b. */
function dotProduct(a, b) {
  let sum = 0;
  for (let k = 0; k < a.length; k++) sum += a[k] * b[k];
  return sum;
}

/**
 * Return the relative size of R S, without a unit, 0 where the gradient is 0: the root of
 * Σ_c ‖(R S)_c‖²/Q_cc over Σ_c Q_cc, as `robust_slam.certificates.tangent` has it.
 */
function headingsStationarity(Q, R) {
  const gradient = rowsTimes(R, lessMultipliers(Q, multipliersOf(Q, R)));
  const diagonal = diagonalEntries(Q);
  const share = (entry, k) => entry ** 2 / diagonal[k % diagonal.length];
  return Math.sqrt(gradient.map(share).reduce((sum, one) => sum + one, 0) / traceOf(Q));
}

/**
 * Return the certificate of R (2, 2n) for the headings alone, with Q from `connectionMatrix`.
 *
 * The result is { verdict, stationarity, lambdaMin, cost, lowerBound, bound, S, eigenvalues }. `lambdaMin` is 0 where it is 0 up to rounding; no rotations cost less than
 * `lowerBound`, and `bound` bounds the optimality gap. As in
 * `robust_slam.certificates.optimality.judge` the verdict follows from the bound that the Cholesky
 * test proves, not from the test.
 */
export function certify(Q, R) {
  const width = R.length / 2;
  const S = lessMultipliers(Q, multipliersOf(Q, R));
  const cost = quadraticCost(Q, R);
  const stationarity = headingsStationarity(Q, R);
  const eigenvalues = symmetricEigen(S, width);
  const total = traceOf(Q);
  const share = Math.max(FIRST_SHIFT, Math.min(stationarity, ROUNDING_SHIFT / 2));
  const shifted = S.slice();
  diagonalEntries(Q).forEach((entry, c) => { shifted[c * width + c] += share * entry; });
  const passed = denseFactor(shifted, width) !== null;
  const lambdaMin = passed ? 0 : eigenvalues[0];
  const eta = Math.max((share * total) / width, -lambdaMin * (1 + 1e-10));
  const lowerBound = cost - width * eta;
  const negligible = ROUNDING_GAP * cost + (passed ? ROUNDING_SHIFT * total : 0);
  const proved = cost - lowerBound <= negligible ? "certified" : "not certified";
  return {
    verdict: stationarity <= STATIONARY ? proved : "not stationary",
    stationarity, lambdaMin, cost, lowerBound, S, eigenvalues,
    bound: Math.max(0, cost - Math.max(0, lowerBound)),
  };
}

/** Return Q − Λ (2n, 2n) for the λ_i (n,). */
function lessMultipliers(Q, multipliers) {
  const [S, width] = [Q.slice(), 2 * multipliers.length];
  for (let c = 0; c < width; c++) S[c * (width + 1)] -= multipliers[c >> 1];
  return S;
}

function diagonalEntries(Q) {
  const size = Math.round(Math.sqrt(Q.length));
  return Float64Array.from({ length: size }, (_, c) => Q[c * size + c]);
}

function traceOf(Q) {
  return diagonalEntries(Q).reduce((sum, entry) => sum + entry, 0);
}

/** Add a block (2, 2) to block (i, j) of a matrix (2n, 2n) by rows. */
function addBlock(matrix, n, i, j, block) {
  const at = 4 * n * i + 2 * j;
  matrix[at] += block[0];
  matrix[at + 1] += block[1];
  matrix[at + 2 * n] += block[2];
  matrix[at + 2 * n + 1] += block[3];
}
