/**
 * Residuals of a pose graph and its normal equations: (Σ w Jᵀ Ω J) δ = −Σ w Jᵀ Ω r.
 *
 * Source: as `robust_slam.descent.normal_equations`: Grisetti et al. 2010; Solà et al. 2018 for
 * the Jacobians.
 */
import { halfCotangent, logCoefficient, wrapAngle } from "./se2.js";
import { skylineFactor, skylinePattern, skylineSolve } from "./skyline.js";

/**
 * Return the normal equations of a graph: its sparsity pattern, found once, and all the room
 * that a step needs, so that no step allocates more than its poses.
 */
export function normalEquations(graph) {
  const { n, m } = graph;
  const pattern = skylinePattern(firstColumns(graph));
  return {
    graph,
    pattern,
    hessian: new Float64Array(pattern.length),
    gradient: new Float64Array(3 * n),
    relative: new Float64Array(3 * m),
    residuals: new Float64Array(3 * m),
    scaled: new Float64Array(3 * m),
    byHead: new Float64Array(9 * m),
    transfer: new Float64Array(9 * m),
    change: new Float64Array(3 * m),
    room: Array.from({ length: 4 }, () => new Float64Array(9)),
  };
}

/**
 * Fill relative poses, residuals r and w Ω r at `poses`, and return the cost ½ Σ w rᵀ Ω r.
 */
export function evaluateEdges(equations, poses, weights) {
  const { graph, relative, residuals, scaled } = equations;
  fillResiduals(graph, poses, relative, residuals);
  let sum = 0;
  for (let k = 0; k < graph.m; k++) {
    const at = 3 * k;
    applyInformation(graph.information, residuals, k, weights[k], scaled);
    sum +=
      residuals[at] * scaled[at] +
      residuals[at + 1] * scaled[at + 1] +
      residuals[at + 2] * scaled[at + 2];
  }
  return 0.5 * sum;
}

/**
 * Fill the two factors of the Jacobians at the evaluated poses: J_j in `byHead`, and
 * −Ad(x_j⁻¹ ∘ x_i) in `transfer`, whose product J_j · transfer is J_i.
 */
export function lineariseEdges({ graph, relative, residuals, byHead, transfer }) {
  for (let k = 0; k < graph.m; k++) {
    const at = 3 * k;
    const entry = 9 * k;
    const angle = residuals[at + 2];
    const a = halfCotangent(angle);
    const c = logCoefficient(angle);
    byHead[entry] = byHead[entry + 4] = a;
    byHead[entry + 1] = -angle / 2;
    byHead[entry + 3] = angle / 2;
    byHead[entry + 2] = c * residuals[at] + residuals[at + 1] / 2;
    byHead[entry + 5] = c * residuals[at + 1] - residuals[at] / 2;
    byHead[entry + 8] = 1;
    // The inverse of the relative pose (x, y, θ) is (−cx − sy, sx − cy, −θ).
    const cosine = Math.cos(relative[at + 2]);
    const sine = Math.sin(relative[at + 2]);
    transfer[entry] = transfer[entry + 4] = -cosine;
    transfer[entry + 1] = -sine;
    transfer[entry + 3] = sine;
    transfer[entry + 2] = cosine * relative[at + 1] - sine * relative[at];
    transfer[entry + 5] = -cosine * relative[at] - sine * relative[at + 1];
    transfer[entry + 8] = -1;
  }
}

/**
 * Sum Σ Jᵀ A J into `hessian` and Σ Jᵀ p into `gradient`.
 *
 * A is `information` (9m) times `weights` (m,), and p (3m) is `pulls`. Edges of weight 0 add
 * nothing.
 */
export function assembleEquations(equations, information, weights, pulls) {
  const { graph, pattern, hessian, gradient, byHead, transfer, room } = equations;
  const [product, atHead, across, atTail] = room;
  hessian.fill(0);
  gradient.fill(0);
  for (let k = 0; k < graph.m; k++) {
    if (weights[k] === 0) continue;
    const i = graph.tail[k];
    const j = graph.head[k];
    // With J_i = J_j T and G = J_jᵀ A J_j, the blocks of an edge are Tᵀ G T, Tᵀ G and G.
    timesBlock(information, 9 * k, byHead, 9 * k, product, weights[k]);
    transposedTimesBlock(byHead, 9 * k, product, 0, atHead);
    transposedTimesBlock(transfer, 9 * k, atHead, 0, across);
    timesBlock(across, 0, transfer, 9 * k, atTail, 1);
    if (i > 0) addDiagonal(pattern, hessian, i, atTail);
    if (j > 0) addDiagonal(pattern, hessian, j, atHead);
    if (i > 0 && j > 0) addAcross(pattern, hessian, i, j, across);
    addPull(gradient, byHead, transfer, pulls, k, i, j);
  }
}

/**
 * Return the δ (3n) with (H + damping · diag H) δ = −gradient and δ = 0 at pose 0; null where
 * the matrix is singular to working precision. It destroys H.
 */
export function solveEquations({ graph, pattern, hessian, gradient }, damping = 0) {
  if (damping > 0) {
    for (let r = 0; r < pattern.size; r++) hessian[pattern.start[r] + r] *= 1 + damping;
  }
  if (!skylineFactor(pattern, hessian)) return null;
  const step = new Float64Array(3 * graph.n);
  const free = step.subarray(3);
  for (let r = 0; r < free.length; r++) free[r] = -gradient[r + 3];
  skylineSolve(pattern, hessian, free);
  return free.every(Number.isFinite) ? step : null;
}

/** Fill J δ (3m) in `change`: how a step δ (3n) changes the linearised residuals. */
export function linearChange({ graph, byHead, transfer, change, room }, step) {
  const moved = room[0];
  for (let k = 0; k < graph.m; k++) {
    const i = 3 * graph.tail[k];
    const j = 3 * graph.head[k];
    for (let row = 0; row < 3; row++) {
      moved[row] = step[j + row] + blockRowTimes(transfer, 9 * k, row, step, i);
    }
    for (let row = 0; row < 3; row++) {
      change[3 * k + row] = blockRowTimes(byHead, 9 * k, row, moved, 0);
    }
  }
  return change;
}

/** Return the change of the linearised cost, Σ pᵀe + ½ eᵀAe; e is `change` and p `pulls`. */
export function linearCostChange({ graph, change }, information, weights, pulls) {
  let sum = 0;
  for (let k = 0; k < graph.m; k++) {
    const at = 3 * k;
    sum += 0.5 * weights[k] * quadraticForm(information, change, k);
    for (let row = at; row < at + 3; row++) sum += change[row] * pulls[row];
  }
  return sum;
}

export function fillResiduals(graph, poses, relative, residuals) {
  const { tail, head, inverseMeasurement } = graph;
  for (let k = 0; k < graph.m; k++) {
    const at = 3 * k;
    const i = 3 * tail[k];
    const j = 3 * head[k];
    const cosine = Math.cos(poses[i + 2]);
    const sine = Math.sin(poses[i + 2]);
    const dx = poses[j] - poses[i];
    const dy = poses[j + 1] - poses[i + 1];
    const x = (relative[at] = cosine * dx + sine * dy);
    const y = (relative[at + 1] = cosine * dy - sine * dx);
    relative[at + 2] = wrapAngle(poses[j + 2] - poses[i + 2]);
    const turned = inverseMeasurement[at + 2];
    const c = Math.cos(turned);
    const s = Math.sin(turned);
    const errorX = inverseMeasurement[at] + c * x - s * y;
    const errorY = inverseMeasurement[at + 1] + s * x + c * y;
    const angle = wrapAngle(turned + relative[at + 2]);
    const a = halfCotangent(angle);
    residuals[at] = a * errorX + (angle / 2) * errorY;
    residuals[at + 1] = a * errorY - (angle / 2) * errorX;
    residuals[at + 2] = angle;
  }
}

/** Return rᵀ Ω r of edge k, for r in `vectors` (3m). */
export function quadraticForm(information, vectors, k) {
  let sum = 0;
  for (let row = 0; row < 3; row++) {
    sum += vectors[3 * k + row] * blockRowTimes(information, 9 * k, row, vectors, 3 * k);
  }
  return sum;
}

/** Return the first column of each row: the lowest pose, except pose 0, that an edge joins to. */
function firstColumns({ n, m, tail, head }) {
  const lowest = Int32Array.from({ length: n }, (_, pose) => pose);
  for (let k = 0; k < m; k++) {
    const low = Math.min(tail[k], head[k]);
    const high = Math.max(tail[k], head[k]);
    if (low > 0) lowest[high] = Math.min(lowest[high], low);
  }
  const firstOf = (_, r) => 3 * (lowest[1 + Math.floor(r / 3)] - 1);
  return Int32Array.from({ length: 3 * (n - 1) }, firstOf);
}

/** Fill w Ω r of edge k in `out`. */
function applyInformation(information, r, k, weight, out) {
  for (let row = 0; row < 3; row++) {
    out[3 * k + row] = weight * blockRowTimes(information, 9 * k, row, r, 3 * k);
  }
}

export function blockRowTimes(matrix, entry, row, vector, at) {
  const begin = entry + 3 * row;
  return (
    matrix[begin] * vector[at] +
    matrix[begin + 1] * vector[at + 1] +
    matrix[begin + 2] * vector[at + 2]
  );
}

/** out = scale · A B for 3 × 3 matrices, A at `a` of `left` and B at `b` of `right`. */
export function timesBlock(left, a, right, b, out, scale) {
  for (let row = 0; row < 3; row++) {
    const x = scale * left[a + 3 * row];
    const y = scale * left[a + 3 * row + 1];
    const z = scale * left[a + 3 * row + 2];
    for (let column = 0; column < 3; column++) {
      const at = b + column;
      out[3 * row + column] = x * right[at] + y * right[at + 3] + z * right[at + 6];
    }
  }
}

/** out = Aᵀ B for 3 × 3 matrices, A at `a` of `left` and B at `b` of `right`. */
function transposedTimesBlock(left, a, right, b, out) {
  for (let row = 0; row < 3; row++) {
    const x = left[a + row];
    const y = left[a + 3 + row];
    const z = left[a + 6 + row];
    for (let column = 0; column < 3; column++) {
      const at = b + column;
      out[3 * row + column] = x * right[at] + y * right[at + 3] + z * right[at + 6];
    }
  }
}

/** Add a block to the diagonal of pose p, its lower triangle. */
function addDiagonal(pattern, hessian, p, block) {
  const begin = 3 * (p - 1);
  for (let row = 0; row < 3; row++) {
    const at = pattern.start[begin + row] + begin;
    for (let column = 0; column <= row; column++) hessian[at + column] += block[3 * row + column];
  }
}

/** Add the block in the rows of i and the columns of j, or its transpose if i is above j. */
function addAcross(pattern, hessian, i, j, block) {
  const low = 3 * (Math.min(i, j) - 1);
  const high = 3 * (Math.max(i, j) - 1);
  for (let row = 0; row < 3; row++) {
    const at = pattern.start[high + row] + low;
    for (let column = 0; column < 3; column++) {
      hessian[at + column] += i > j ? block[3 * row + column] : block[3 * column + row];
    }
  }
}

/** Add Jᵀ p of edge k to the gradient of its ends. */
function addPull(gradient, byHead, transfer, pulls, k, i, j) {
  const entry = 9 * k;
  const x = blockColumnTimes(byHead, entry, 0, pulls, 3 * k);
  const y = blockColumnTimes(byHead, entry, 1, pulls, 3 * k);
  const z = blockColumnTimes(byHead, entry, 2, pulls, 3 * k);
  gradient[3 * j] += x;
  gradient[3 * j + 1] += y;
  gradient[3 * j + 2] += z;
  for (let column = 0; column < 3; column++) {
    gradient[3 * i + column] +=
      transfer[entry + column] * x +
      transfer[entry + 3 + column] * y +
      transfer[entry + 6 + column] * z;
  }
}

function blockColumnTimes(matrix, entry, column, vector, at) {
  return (
    matrix[entry + column] * vector[at] +
    matrix[entry + 3 + column] * vector[at + 1] +
    matrix[entry + 6 + column] * vector[at + 2]
  );
}
