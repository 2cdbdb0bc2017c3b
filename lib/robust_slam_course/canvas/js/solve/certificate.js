/**
 * The chordal problem in the plane and the certificate of global optimality.
 *
 * Rotations are the blocks of R (r × 2n, by rows) side by side; r is 2 for headings, more on the
 * staircase. The chordal cost Σ κ ‖R_j − R_i R̃‖²_F + τ ‖t_j − t_i − R_i t̃‖², without a ½, is
 * tr(R Q Rᵀ) once the positions are eliminated. Let S = Q − Λ with Λ block diagonal,
 * Λ_i = sym(R_iᵀ (R Q)_i). If S Rᵀ = 0 and S ⪰ 0, no rotations cost less. With S + η I ⪰ 0 any
 * rotations cost at least tr Λ − 2 n η, whether R is stationary or not.
 *
 * It is about the cost of the edges that are kept, and says nothing about outliers.
 *
 * Source: as `robust_slam.certificates.sdp`, `chordal` and `optimality`: Rosen et al. 2019,
 * "SE-Sync", Theorem 7 and equations (107) and (112).
 */
import { symmetricEigen } from "./eigen.js";
import { joinsAllPoses } from "./pose_graph.js";
import { skylineFactor, skylinePattern, skylineSolve } from "./skyline.js";

/** The verdict of a certificate, in the words of the library. */
export const VERDICT = {
  certified: "certified",
  notCertified: "not certified",
  notStationary: "not stationary",
};

/** The largest stationarity of rotations that count as stationary. */
const STATIONARY = 1e-9;

/** The first shift of the Cholesky test and the largest that is rounding, relative to Q. */
const FIRST_SHIFT = 1e-12;
const ROUNDING_SHIFT = 2e-11;

/** An optimality gap, relative to the cost, that counts as rounding. */
const ROUNDING_GAP = 1e-9;

/**
 * Return Q (2n, 2n) of the headings alone, with tr(R Q Rᵀ) = Σ κ ‖R_j − R_i R̃‖²_F.
 *
 * `edges` [[i, j], …] (m, 2); `turns` (m,) are the measured angles in rad; `kappa` a number or
 * (m,).
 */
export function connectionMatrix(n, edges, turns, kappa = 1) {
  const Q = new Float64Array(4 * n * n);
  edges.forEach(([i, j], k) => {
    const precision = typeof kappa === "number" ? kappa : kappa[k];
    const cosine = precision * Math.cos(turns[k]);
    const sine = precision * Math.sin(turns[k]);
    addBlock(Q, n, i, i, [precision, 0, 0, precision]);
    addBlock(Q, n, j, j, [precision, 0, 0, precision]);
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

/** Return tr(R Q Rᵀ) of R (r, 2n), which is a sum of squares and so at least 0. */
export function quadraticCost(Q, R, r) {
  return Math.max(0, dotProduct(rowsTimes(R, r, Q), R));
}

/** Return S = Q − Λ (2n, 2n) at R (r, 2n). */
export function certificateMatrix(Q, R, r) {
  return lessMultipliers(Q, multipliersOf(Q, R, r));
}

/** Return the blocks Λ_i = sym(R_iᵀ (R Q)_i) (n, 2, 2) by rows. */
export function multipliersOf(Q, R, r) {
  return symmetricProducts(R, rowsTimes(R, r, Q), r);
}

/** Return the blocks sym(R_iᵀ V_i) (n, 2, 2) of R and V (r, 2n). */
export function symmetricProducts(R, V, r) {
  const width = R.length / r;
  const blocks = new Float64Array(2 * width);
  for (let i = 0; i < width / 2; i++) {
    for (let row = 0; row < r; row++) {
      const at = row * width + 2 * i;
      blocks[4 * i] += R[at] * V[at];
      blocks[4 * i + 1] += 0.5 * (R[at] * V[at + 1] + R[at + 1] * V[at]);
      blocks[4 * i + 3] += R[at + 1] * V[at + 1];
    }
    blocks[4 * i + 2] = blocks[4 * i + 1];
  }
  return blocks;
}

/** Return R A (r, width) for R (r, width) and a symmetric A (width, width). */
export function rowsTimes(R, r, A) {
  const width = R.length / r;
  const product = new Float64Array(R.length);
  for (let row = 0; row < r; row++) {
    const own = product.subarray(row * width, (row + 1) * width);
    for (let c = 0; c < width; c++) {
      const share = R[row * width + c];
      if (share === 0) continue;
      const begin = c * width;
      for (let k = 0; k < width; k++) own[k] += share * A[begin + k];
    }
  }
  return product;
}

/** Return Σ a b. */
export function dotProduct(a, b) {
  let sum = 0;
  for (let k = 0; k < a.length; k++) sum += a[k] * b[k];
  return sum;
}

/**
 * Return the relative size of R S, without a unit, 0 where the gradient is 0: the root of
 * Σ_c ‖(R S)_c‖²/Q_cc over Σ_c Q_cc, as `robust_slam.certificates.tangent` has it.
 */
export function headingsStationarity(Q, R, r) {
  const width = R.length / r;
  const gradient = rowsTimes(R, r, certificateMatrix(Q, R, r));
  let squares = 0;
  let scale = 0;
  for (let c = 0; c < width; c++) {
    const own = Q[c * width + c];
    scale += own;
    for (let row = 0; row < r; row++) squares += gradient[row * width + c] ** 2 / own;
  }
  return Math.sqrt(squares / scale);
}

/**
 * Return the certificate of R (r, 2n) for the headings alone, with Q from `connectionMatrix`.
 *
 * The result is { verdict, stationarity, lambdaMin, eta, cost, lowerBound, bound, direction, S,
 * eigenvalues }. `lambdaMin` is 0 where it is 0 up to rounding; no rotations cost less than
 * `lowerBound`, and `bound` bounds the optimality gap. `direction` (2n,) is the unit eigenvector
 * of a negative `lambdaMin`, a descent direction at the next rank, null where there is none.
 */
export function certify(Q, R, r = 2) {
  const width = R.length / r;
  const S = certificateMatrix(Q, R, r);
  const cost = quadraticCost(Q, R, r);
  const spectrum = symmetricEigen(S, width);
  const proof = judgement({
    S,
    diagonal: Float64Array.from({ length: width }, (_, c) => Q[c * width + c]),
    stationarity: headingsStationarity(Q, R, r),
    cost,
    multiplierTrace: cost,
    spectrum: () => spectrum,
  });
  return { ...proof, S, eigenvalues: spectrum.values };
}

/**
 * Return the certificate of poses (3n) of a graph, without polishing them, as `certify` does.
 *
 * S is that of the rotations, with the positions eliminated. `weights` (m,) multiply κ and τ and
 * are 1 if null. The result is null where edges of positive weight do not join all poses.
 */
export function certifyGraph(graph, poses, weights = null) {
  const problem = chordalProblem(graph, weights);
  if (problem === null) return null;
  const { blocks, gradient, multipliers } = chordalDerivatives(problem, poses);
  const S = lessMultipliers(problem.Q, multipliers);
  const cost = chordalCost(graph, poses, weights);
  let squares = 0;
  for (let i = 0; i < graph.n; i++) {
    for (let column = 0; column < 3; column++) {
      const entries = [0, 3].map((row) => gradient[6 * i + row + column]);
      squares += (entries[0] ** 2 + entries[1] ** 2) / problem.diagonal[3 * i + column];
    }
  }
  const own = problem.diagonal.filter((_, k) => k % 3 < 2);
  const scale = own.reduce((sum, entry) => sum + entry, 0);
  const proof = judgement({
    S,
    diagonal: own,
    stationarity: Math.sqrt(squares / scale),
    cost,
    multiplierTrace: cost - positionPull(graph.n, blocks, gradient),
    spectrum: () => symmetricEigen(S, 2 * graph.n),
  });
  return { ...proof, S };
}

/** Return Σ w (κ ‖R_j − R_i R̃‖²_F + τ ‖t_j − t_i − R_i t̃‖²) of poses (3n), without a ½. */
export function chordalCost(graph, poses, weights = null) {
  const blocks = poseBlocks(poses);
  const { kappa, tau } = chordalPrecisions(graph);
  let sum = 0;
  for (let k = 0; k < graph.m; k++) {
    const weight = weights === null ? 1 : weights[k];
    const error = chordalError(graph, blocks, k);
    for (let at = 0; at < 6; at++) {
      sum += weight * (at % 3 === 2 ? tau[k] : kappa[k]) * error[at] ** 2;
    }
  }
  return sum;
}

/**
 * Return Q (2n, 2n) of a graph with its positions eliminated: the cost of rotations with the
 * best positions is tr(R Q Rᵀ).
 */
export function marginalisedMatrix(graph, weights = null) {
  const problem = chordalProblem(graph, weights);
  return problem === null ? null : problem.Q;
}

/**
 * Return what the chordal problem of a graph needs, null where edges of positive weight do not
 * join all poses: precisions, Q, the `diagonal` (3n) of the data matrix, and `place(R, first)`,
 * which returns the best positions (2n) for R (2, 2n) with the first at `first`.
 */
export function chordalProblem(graph, weights = null) {
  const { n, m, tail, head, measurement } = graph;
  const full = weights ?? new Float64Array(m).fill(1);
  if (!joinsAllPoses(graph, full)) return null;
  const { kappa, tau } = chordalPrecisions(graph);
  const width = 2 * n;
  const Q = new Float64Array(width * width);
  const diagonal = new Float64Array(3 * n);
  // Row t − 1 of `across` is the part of the data matrix between position t and the rotations.
  const across = Array.from({ length: n - 1 }, () => new Float64Array(width));
  const laplacian = positionLaplacian(graph);
  for (let k = 0; k < m; k++) {
    const [kk, tt] = [full[k] * kappa[k], full[k] * tau[k]];
    if (full[k] === 0) continue;
    const [i, j] = [tail[k], head[k]];
    const [x, y, turn] = measurement.subarray(3 * k, 3 * k + 3);
    const cosine = kk * Math.cos(turn);
    const sine = kk * Math.sin(turn);
    addBlock(Q, n, i, i, [kk + tt * x * x, tt * x * y, tt * x * y, kk + tt * y * y]);
    addBlock(Q, n, j, j, [kk, 0, 0, kk]);
    addBlock(Q, n, i, j, [-cosine, sine, -sine, -cosine]);
    addBlock(Q, n, j, i, [-cosine, -sine, sine, -cosine]);
    for (const [end, sign] of [[i, 1], [j, -1]]) {
      if (end === 0) continue;
      across[end - 1][2 * i] += sign * tt * x;
      across[end - 1][2 * i + 1] += sign * tt * y;
    }
    laplacian.add(i, j, tt);
    diagonal[3 * i + 2] += tt;
    diagonal[3 * j + 2] += tt;
  }
  for (let c = 0; c < width; c++) diagonal[c + Math.floor(c / 2)] = Q[c * width + c];
  if (!laplacian.factor()) return null;
  eliminatePositions(Q, across, laplacian);
  const place = (R, first) => bestPositions(R, across, laplacian, first);
  return { graph, full, kappa, tau, Q, diagonal, place };
}

/** Subtract Bᵀ L⁻¹ B from Q, for B (n − 1, 2n) in rows and the Laplacian L of the positions. */
function eliminatePositions(Q, across, laplacian) {
  const width = Math.round(Math.sqrt(Q.length));
  const column = new Float64Array(across.length);
  for (let c = 0; c < width; c++) {
    across.forEach((row, t) => {
      column[t] = row[c];
    });
    laplacian.solve(column);
    across.forEach((row, t) => {
      if (column[t] === 0) return;
      for (let k = 0; k < width; k++) Q[k * width + c] -= row[k] * column[t];
    });
  }
}

function bestPositions(R, across, laplacian, first) {
  const width = R.length / 2;
  const positions = new Float64Array(width);
  for (let axis = 0; axis < 2; axis++) {
    const row = R.subarray(axis * width, (axis + 1) * width);
    const pull = Float64Array.from(across, (own) => -dotProduct(own, row));
    laplacian.solve(pull);
    positions[axis] = first[axis];
    pull.forEach((shift, t) => {
      positions[2 * (t + 1) + axis] = first[axis] + shift;
    });
  }
  return positions;
}

/** Return Σ τ over the edges as a matrix over the positions but the first, to add to and solve. */
function positionLaplacian({ n, m, tail, head }) {
  const first = Int32Array.from({ length: n - 1 }, (_, t) => t);
  for (let k = 0; k < m; k++) {
    const [low, high] = [Math.min(tail[k], head[k]) - 1, Math.max(tail[k], head[k]) - 1];
    if (low >= 0) first[high] = Math.min(first[high], low);
  }
  const pattern = skylinePattern(first);
  const values = new Float64Array(pattern.length);
  return {
    add(i, j, precision) {
      for (const t of [i - 1, j - 1]) if (t >= 0) values[pattern.start[t] + t] += precision;
      const [low, high] = [Math.min(i, j) - 1, Math.max(i, j) - 1];
      if (low >= 0) values[pattern.start[high] + low] -= precision;
    },
    factor: () => skylineFactor(pattern, values),
    solve: (right) => skylineSolve(pattern, values, right),
  };
}

/** Return κ = Ω_θθ and τ = 2/tr(Ω_tt⁻¹) (m,) of each edge. */
function chordalPrecisions({ m, information }) {
  const kappa = new Float64Array(m);
  const tau = new Float64Array(m);
  for (let k = 0; k < m; k++) {
    const [a, b, , c, d, , , , turn] = information.subarray(9 * k, 9 * k + 9);
    kappa[k] = turn;
    tau[k] = (2 * (a * d - b * c)) / (a + d);
  }
  return { kappa, tau };
}

/**
 * Return the blocks [R_i | t_i] (n, 2, 3) of poses, half the Riemannian gradient (n, 2, 3) and
 * the multipliers Λ (n, 2, 2).
 */
function chordalDerivatives({ graph, full, kappa, tau }, poses) {
  const blocks = poseBlocks(poses);
  const gradient = new Float64Array(blocks.length);
  for (let k = 0; k < graph.m; k++) {
    const error = chordalError(graph, blocks, k);
    const [x, y, turn] = graph.measurement.subarray(3 * k, 3 * k + 3);
    const [cosine, sine] = [Math.cos(turn), Math.sin(turn)];
    const [i, j] = [6 * graph.tail[k], 6 * graph.head[k]];
    for (let row = 0; row < 6; row += 3) {
      // The rows of E = (X_j − X_i T̃) W; the gradient is E at j and −E T̃ᵀ at i.
      const a = full[k] * kappa[k] * error[row];
      const b = full[k] * kappa[k] * error[row + 1];
      const t = full[k] * tau[k] * error[row + 2];
      gradient[j + row] += a;
      gradient[j + row + 1] += b;
      gradient[j + row + 2] += t;
      gradient[i + row] -= a * cosine - b * sine + t * x;
      gradient[i + row + 1] -= a * sine + b * cosine + t * y;
      gradient[i + row + 2] -= t;
    }
  }
  return { blocks, multipliers: projectGradient(blocks, gradient), gradient };
}

/** Take R_i Λ_i off the gradient of each rotation, and return the multipliers Λ (n, 2, 2). */
function projectGradient(blocks, gradient) {
  const n = blocks.length / 6;
  const multipliers = new Float64Array(4 * n);
  for (let i = 0; i < n; i++) {
    const at = (row, column) => 6 * i + 3 * row + column;
    const product = (a, b) =>
      blocks[at(0, a)] * gradient[at(0, b)] + blocks[at(1, a)] * gradient[at(1, b)];
    const mixed = 0.5 * (product(0, 1) + product(1, 0));
    multipliers.set([product(0, 0), mixed, mixed, product(1, 1)], 4 * i);
  }
  for (let i = 0; i < n; i++) {
    for (let row = 6 * i; row < 6 * i + 6; row += 3) {
      const [a, b] = [blocks[row], blocks[row + 1]];
      gradient[row] -= a * multipliers[4 * i] + b * multipliers[4 * i + 2];
      gradient[row + 1] -= a * multipliers[4 * i + 1] + b * multipliers[4 * i + 3];
    }
  }
  return multipliers;
}

/** Return ⟨t, (X M)_t⟩, with the mean position as origin: the gradients sum to 0. */
function positionPull(n, blocks, gradient) {
  let sum = 0;
  for (let row = 2; row < 6; row += 3) {
    let mean = 0;
    for (let i = 0; i < n; i++) mean += blocks[6 * i + row] / n;
    for (let i = 0; i < n; i++) sum += (blocks[6 * i + row] - mean) * gradient[6 * i + row];
  }
  return sum;
}

/** Return X_j − X_i T̃ of edge k, (2, 3) by rows. */
function chordalError(graph, blocks, k) {
  const [x, y, turn] = graph.measurement.subarray(3 * k, 3 * k + 3);
  const [cosine, sine] = [Math.cos(turn), Math.sin(turn)];
  const [i, j] = [6 * graph.tail[k], 6 * graph.head[k]];
  const error = new Float64Array(6);
  for (let row = 0; row < 6; row += 3) {
    const [a, b] = [blocks[i + row], blocks[i + row + 1]];
    error[row] = blocks[j + row] - (a * cosine + b * sine);
    error[row + 1] = blocks[j + row + 1] - (b * cosine - a * sine);
    error[row + 2] = blocks[j + row + 2] - blocks[i + row + 2] - (a * x + b * y);
  }
  return error;
}

/** Return poses (3n) as blocks [R | t] (n, 2, 3) by rows. */
function poseBlocks(poses) {
  const blocks = new Float64Array(2 * poses.length);
  for (let at = 0; at < poses.length; at += 3) {
    const [cosine, sine] = [Math.cos(poses[at + 2]), Math.sin(poses[at + 2])];
    blocks.set([cosine, -sine, poses[at], sine, cosine, poses[at + 1]], 2 * at);
  }
  return blocks;
}

/**
 * Return the verdict and its numbers, as `robust_slam.certificates.optimality.judge` does: the
 * verdict follows from the bound that the Cholesky test proves, not from the test.
 */
function judgement({ S, diagonal, stationarity, cost, multiplierTrace, spectrum }) {
  const width = diagonal.length;
  const total = diagonal.reduce((sum, entry) => sum + entry, 0);
  const share = Math.max(FIRST_SHIFT, Math.min(stationarity, ROUNDING_SHIFT / 2));
  const passed = isDefinite(S, diagonal.map((entry) => share * entry));
  let eta = (share * total) / width;
  let [lambdaMin, direction] = [0, null];
  if (!passed) {
    const { values, vectors } = spectrum();
    lambdaMin = values[0];
    direction = vectors.slice(0, width);
    eta = Math.max(eta, -lambdaMin) * (1 + 1e-10);
  }
  const lowerBound = multiplierTrace - width * eta;
  const negligible = ROUNDING_GAP * cost + (passed ? ROUNDING_SHIFT * total : 0);
  let verdict = VERDICT.notStationary;
  if (stationarity <= STATIONARY) {
    verdict = cost - lowerBound <= negligible ? VERDICT.certified : VERDICT.notCertified;
  }
  const bound = Math.max(0, cost - Math.max(0, lowerBound));
  return { verdict, stationarity, lambdaMin, eta, cost, lowerBound, bound, direction };
}

/** Tell whether A + diag(shift) is positive definite, for a symmetric A by rows. */
function isDefinite(A, shift) {
  const size = shift.length;
  const pattern = skylinePattern(new Int32Array(size));
  const values = new Float64Array(pattern.length);
  for (let r = 0; r < size; r++) {
    for (let c = 0; c <= r; c++) values[pattern.start[r] + c] = A[r * size + c];
    values[pattern.start[r] + r] += shift[r];
  }
  return skylineFactor(pattern, values);
}

function lessMultipliers(Q, multipliers) {
  const n = multipliers.length / 4;
  const S = Q.slice();
  for (let i = 0; i < n; i++) {
    addBlock(S, n, i, i, multipliers.subarray(4 * i, 4 * i + 4).map((entry) => -entry));
  }
  return S;
}

/** Add a block (2, 2) to block (i, j) of a matrix (2n, 2n) by rows. */
function addBlock(matrix, n, i, j, block) {
  const at = 4 * n * i + 2 * j;
  matrix[at] += block[0];
  matrix[at + 1] += block[1];
  matrix[at + 2 * n] += block[2];
  matrix[at + 2 * n + 1] += block[3];
}
