/**
 * A pose graph in the plane as arrays: residuals, cost, Gauss–Newton and Levenberg–Marquardt.
 *
 * Edge k = (i, j) measures z, pose j in the frame of pose i. Its residual is Log(z⁻¹ ∘ x_i⁻¹ ∘ x_j)
 * with the information Ω in the order (ρx, ρy, θ). The cost is ½ Σ w ‖whitened residual‖². Poses
 * are a flat array (3n), pose 0 is fixed, and poses are perturbed on the right.
 *
 * Source: as `robust_slam.graphs.pose_graph`, `robust_slam.graphs.odometry` and
 * `robust_slam.descent`: Grisetti et al. 2010; Dennis and Schnabel 1983, section 10.2;
 * Marquardt 1963; Nielsen 1999.
 */
import { halfCotangent, logCoefficient, se2Compose, se2Inverse, sineRatio, wrapAngle } from "./se2.js";
import { skylineFactor, skylinePattern, skylineSolve } from "./skyline.js";

/** The norm that a whitened Gaussian residual of 3 dimensions does not exceed with 99 %. */
export const CHI_99_SE2 = 3.368214175218727;

/** The same of 1 dimension. */
export const CHI_99_LINE = 2.575829303548901;

/** A relative increase of the cost that counts as rounding, and a cost that counts as 0. */
const COST_ROUNDING = 1e-12;
const NEGLIGIBLE_COST = 1e-18;
const STEP_HALVINGS = 30;
const STEP_LIMIT = 500;
const FIRST_DAMPING = 1e-4;

/**
 * Return a graph for the functions of this module.
 *
 * `poses` is the number of poses n; `edges` [[i, j], …] (m, 2); `measurements` (m, 3) in m, m and
 * rad; `information` (m, 3, 3), or one matrix for all edges; `trusted` a mask (m,) of the
 * odometry. Arrays may be nested or flat.
 */
export function makeGraph({ poses, edges, measurements, information, trusted }) {
  const m = edges.length;
  const measurement = flatNumbers(measurements);
  const inverseMeasurement = new Float64Array(3 * m);
  for (let k = 0; k < m; k++) {
    inverseMeasurement.set(se2Inverse(measurement.subarray(3 * k, 3 * k + 3)), 3 * k);
  }
  const given = flatNumbers(information);
  const full = new Float64Array(9 * m);
  for (let k = 0; k < full.length; k++) full[k] = given[k % given.length];
  return {
    n: poses,
    m,
    tail: Int32Array.from(edges, (edge) => edge[0]),
    head: Int32Array.from(edges, (edge) => edge[1]),
    measurement,
    inverseMeasurement,
    information: full,
    isOdometry: Uint8Array.from(trusted, Number),
  };
}

/** Return the residuals Log(z⁻¹ ∘ x_i⁻¹ ∘ x_j) of all edges (3m) in m and rad, not whitened. */
export function graphResiduals(graph, poses) {
  const relative = new Float64Array(3 * graph.m);
  const residuals = new Float64Array(3 * graph.m);
  fillResiduals(graph, poses, relative, residuals);
  return residuals;
}

/** Return the whitened residual norm of each edge (m,): the u of a kernel. */
export function graphResidualNorms(graph, poses) {
  const residuals = graphResiduals(graph, poses);
  const norms = new Float64Array(graph.m);
  for (let k = 0; k < graph.m; k++) {
    norms[k] = Math.sqrt(Math.max(0, quadraticForm(graph.information, residuals, k)));
  }
  return norms;
}

/** Return ½ Σ w ‖whitened residual‖²; `weights` (m,) are 1 if null. */
export function graphCost(graph, poses, weights = null) {
  const norms = graphResidualNorms(graph, poses);
  return 0.5 * norms.reduce((sum, u, k) => sum + (weights === null ? 1 : weights[k]) * u * u, 0);
}

/** Return the poses from the odometry alone, pose 0 the identity; null where it has gaps. */
export function deadReckoning(graph) {
  const { reached, poses } = posesAlongTree(graph, (k) => (graph.isOdometry[k] ? 1 : Infinity));
  return reached ? poses : null;
}

/**
 * Return the poses along a spanning tree, pose 0 the identity.
 *
 * Of all paths it takes one with the fewest closures, of these one with the fewest edges: a
 * complete odometry gives dead reckoning.
 */
export function spanningTree(graph) {
  return posesAlongTree(graph, (k) => (graph.isOdometry[k] ? 1 : graph.n)).poses;
}

/**
 * Return the problem of a pose graph for the loop; its x are poses (3n).
 *
 * The unweighted solve starts at `guess`, by default the poses of `spanningTree`. `trusted` (m,)
 * are the edges whose weight stays 1, by default the odometry. Each solve takes at most `steps`
 * Gauss–Newton steps. For a live picture steps = 1 and tol = 1e-6, as the library takes them for
 * a graph.
 */
export function poseGraphProblem(graph, guess = null, trusted = null, options = {}) {
  const { tol = 1e-9, steps = 100 } = options;
  const equations = normalEquations(graph);
  const problem = {
    graph,
    equations,
    tol,
    count: graph.m,
    trusted: trusted === null ? graph.isOdometry : Uint8Array.from(trusted, Number),
    guess: guess === null ? spanningTree(graph) : Float64Array.from(guess),
    initial() {
      const descent = leastSquares(problem);
      if (descent === null) return null;
      if (!descent.converged) throw new Error("the unweighted solve did not converge");
      return descent.poses;
    },
    residualNorms: (poses) => graphResidualNorms(graph, poses),
    solve(weights, poses) {
      if (!joinsAllPoses(graph, weights)) return null;
      const descent = undampedDescent(equations, poses, weights, tol, steps);
      return descent === null ? null : descent.poses;
    },
  };
  return problem;
}

/**
 * Return the least-squares poses from `problem.guess` as { poses, cost, step, converged }.
 *
 * Gross errors can make Gauss–Newton very slow, so this is Levenberg–Marquardt.
 */
export function leastSquares(problem) {
  return levenbergMarquardt(problem, problem.guess, null, { tol: problem.tol });
}

/**
 * Return a minimum of ½ Σ w ‖whitened residual‖² near `poses` by Gauss–Newton with backtracking.
 *
 * The result is { poses, cost, step, converged }, or null where edges of positive weight do not
 * determine the poses. It converges when a step moves positions by at most tol times 1 m + the
 * longest side of the map, and headings by at most tol rad.
 */
export function gaussNewton(problem, poses, weights = null, options = {}) {
  const { tol = 1e-9, maxIterations = STEP_LIMIT } = options;
  const full = weights ?? new Float64Array(problem.count).fill(1);
  if (!joinsAllPoses(problem.graph, full)) return null;
  return undampedDescent(problem.equations, poses, full, tol, maxIterations);
}

/** Return the same minimum as `gaussNewton` by Levenberg–Marquardt, safer from far away. */
export function levenbergMarquardt(problem, poses, weights = null, options = {}) {
  const { tol = 1e-9, maxIterations = STEP_LIMIT } = options;
  const full = weights ?? new Float64Array(problem.count).fill(1);
  if (!joinsAllPoses(problem.graph, full)) return null;
  return dampedDescent(problem.equations, poses, full, tol, maxIterations);
}

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
    multiply(information, 9 * k, byHead, 9 * k, product, weights[k]);
    multiplyTransposed(byHead, 9 * k, product, 0, atHead);
    multiplyTransposed(transfer, 9 * k, atHead, 0, across);
    multiply(across, 0, transfer, 9 * k, atTail, 1);
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
export function linearChange({ graph, byHead, transfer, change }, step) {
  for (let k = 0; k < graph.m; k++) {
    const i = 3 * graph.tail[k];
    const j = 3 * graph.head[k];
    const moved = [0, 1, 2].map((row) => step[j + row] + rowTimes(transfer, 9 * k, row, step, i));
    for (let row = 0; row < 3; row++) {
      change[3 * k + row] = rowTimes(byHead, 9 * k, row, moved, 0);
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

/** Return each pose ∘ Exp(scale · δ), with δ its three numbers of `step` (3n). */
export function retractPoses(poses, step, scale = 1) {
  const moved = new Float64Array(poses.length);
  for (let at = 0; at < poses.length; at += 3) {
    const angle = scale * step[at + 2];
    const x = scale * step[at];
    const y = scale * step[at + 1];
    const a = sineRatio(angle);
    const b = Math.sin(angle / 2) * sineRatio(angle / 2);
    const cosine = Math.cos(poses[at + 2]);
    const sine = Math.sin(poses[at + 2]);
    const forward = a * x - b * y;
    const left = b * x + a * y;
    moved[at] = poses[at] + cosine * forward - sine * left;
    moved[at + 1] = poses[at + 1] + sine * forward + cosine * left;
    moved[at + 2] = wrapAngle(poses[at + 2] + wrapAngle(angle));
  }
  return moved;
}

/** Tell whether `cost` is higher than the one `before` by more than rounding. */
export function costIncreases(cost, before) {
  return cost > before * (1 + COST_ROUNDING) + NEGLIGIBLE_COST;
}

/**
 * Tell whether a step moves positions by at most tol · (1 m + extent) and headings by tol; the
 * extent is the map's longest side. The rounding of coordinates is allowed on top.
 */
export function stepIsSmall(step, poses, tol) {
  let moved = 0;
  let turned = 0;
  let farthest = 0;
  const low = [Infinity, Infinity];
  const high = [-Infinity, -Infinity];
  for (let at = 0; at < poses.length; at += 3) {
    for (let axis = 0; axis < 2; axis++) {
      const place = poses[at + axis];
      moved = Math.max(moved, Math.abs(step[at + axis]));
      farthest = Math.max(farthest, Math.abs(place));
      low[axis] = Math.min(low[axis], place);
      high[axis] = Math.max(high[axis], place);
    }
    turned = Math.max(turned, Math.abs(step[at + 2]));
  }
  const rounding = 4 * Number.EPSILON * farthest;
  const extent = Math.max(high[0] - low[0], high[1] - low[1]);
  return moved <= tol * (1 + extent) + rounding && turned <= tol + rounding;
}

/** Return the factor on the damping after an accepted step, from 1/3 to 2 (Nielsen 1999). */
export function dampingFactor(gainRatio) {
  const gain = Math.min(Math.max(gainRatio, 0), 1);
  return Math.max(1 / 3, 1 - (2 * gain - 1) ** 3);
}

/** Tell whether the edges of positive weight connect every pose to pose 0. */
export function joinsAllPoses(graph, weights) {
  const parent = Int32Array.from({ length: graph.n }, (_, pose) => pose);
  const root = (pose) => {
    while (parent[pose] !== pose) pose = parent[pose] = parent[parent[pose]];
    return pose;
  };
  let parts = graph.n;
  for (let k = 0; k < graph.m; k++) {
    if (!(weights[k] > 0)) continue;
    const a = root(graph.tail[k]);
    const b = root(graph.head[k]);
    if (a === b) continue;
    parent[a] = b;
    parts--;
  }
  return parts === 1;
}

function undampedDescent(equations, start, weights, tol, maxIterations) {
  const { graph, scaled } = equations;
  let poses = start;
  let cost = evaluateEdges(equations, poses, weights);
  let size = Infinity;
  for (let iteration = 0; iteration < maxIterations; iteration++) {
    lineariseEdges(equations);
    assembleEquations(equations, graph.information, weights, scaled);
    const step = solveEquations(equations);
    if (step === null) return null;
    size = largestEntry(step);
    if (stepIsSmall(step, poses, tol)) {
      poses = retractPoses(poses, step);
      return { poses, cost: evaluateEdges(equations, poses, weights), step: size, converged: true };
    }
    [poses, cost] = backtracked(equations, poses, cost, weights, step);
  }
  return { poses, cost, step: size, converged: false };
}

/** Take the longest of step, step/2, step/4, … that does not increase the cost. */
function backtracked(equations, poses, cost, weights, step) {
  for (let halvings = 0; halvings < STEP_HALVINGS; halvings++) {
    const trial = retractPoses(poses, step, 0.5 ** halvings);
    const trialCost = evaluateEdges(equations, trial, weights);
    if (!costIncreases(trialCost, cost)) return [trial, trialCost];
  }
  return [poses, evaluateEdges(equations, poses, weights)];
}

function dampedDescent(equations, start, weights, tol, maxIterations) {
  const { graph, scaled } = equations;
  let poses = start;
  let cost = evaluateEdges(equations, poses, weights);
  let damping = FIRST_DAMPING;
  let growth = 2;
  let size = Infinity;
  for (let iteration = 0; iteration < maxIterations; iteration++) {
    lineariseEdges(equations);
    assembleEquations(equations, graph.information, weights, scaled);
    const step = solveEquations(equations, damping);
    if (step === null) return null;
    linearChange(equations, step);
    const predicted = -linearCostChange(equations, graph.information, weights, scaled);
    size = largestEntry(step);
    const trial = retractPoses(poses, step);
    const trialCost = evaluateEdges(equations, trial, weights);
    if (costIncreases(trialCost, cost)) {
      damping *= growth;
      growth *= 2;
      evaluateEdges(equations, poses, weights);
      continue;
    }
    const converged = stepIsSmall(step, poses, tol);
    damping *= dampingFactor((cost - trialCost) / Math.max(predicted, Number.MIN_VALUE));
    growth = 2;
    [poses, cost] = [trial, trialCost];
    if (converged) return { poses, cost, step: size, converged: true };
  }
  return { poses, cost, step: size, converged: false };
}

/** Return the first column of each row: the lowest pose, except pose 0, that an edge joins to. */
function firstColumns({ n, m, tail, head }) {
  const lowest = Int32Array.from({ length: n }, (_, pose) => pose);
  for (let k = 0; k < m; k++) {
    const low = Math.min(tail[k], head[k]);
    const high = Math.max(tail[k], head[k]);
    if (low > 0) lowest[high] = Math.min(lowest[high], low);
  }
  return Int32Array.from({ length: 3 * (n - 1) }, (_, r) => 3 * (lowest[1 + Math.floor(r / 3)] - 1));
}

function fillResiduals(graph, poses, relative, residuals) {
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
function quadraticForm(information, vectors, k) {
  let sum = 0;
  for (let row = 0; row < 3; row++) {
    sum += vectors[3 * k + row] * rowTimes(information, 9 * k, row, vectors, 3 * k);
  }
  return sum;
}

/** Fill w Ω r of edge k in `out`. */
function applyInformation(information, r, k, weight, out) {
  for (let row = 0; row < 3; row++) {
    out[3 * k + row] = weight * rowTimes(information, 9 * k, row, r, 3 * k);
  }
}

function rowTimes(matrix, entry, row, vector, at) {
  const begin = entry + 3 * row;
  return (
    matrix[begin] * vector[at] +
    matrix[begin + 1] * vector[at + 1] +
    matrix[begin + 2] * vector[at + 2]
  );
}

/** out = scale · A B for 3 × 3 matrices, A at `a` of `left` and B at `b` of `right`. */
function multiply(left, a, right, b, out, scale) {
  for (let row = 0; row < 3; row++) {
    const x = scale * left[a + 3 * row];
    const y = scale * left[a + 3 * row + 1];
    const z = scale * left[a + 3 * row + 2];
    for (let column = 0; column < 3; column++) {
      out[3 * row + column] = x * right[b + column] + y * right[b + 3 + column] + z * right[b + 6 + column];
    }
  }
}

/** out = Aᵀ B for 3 × 3 matrices, A at `a` of `left` and B at `b` of `right`. */
function multiplyTransposed(left, a, right, b, out) {
  for (let row = 0; row < 3; row++) {
    const x = left[a + row];
    const y = left[a + 3 + row];
    const z = left[a + 6 + row];
    for (let column = 0; column < 3; column++) {
      out[3 * row + column] = x * right[b + column] + y * right[b + 3 + column] + z * right[b + 6 + column];
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
  const [x, y, z] = [0, 1, 2].map((column) => columnTimes(byHead, entry, column, pulls, 3 * k));
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

function columnTimes(matrix, entry, column, vector, at) {
  return (
    matrix[entry + column] * vector[at] +
    matrix[entry + 3 + column] * vector[at + 1] +
    matrix[entry + 6 + column] * vector[at + 2]
  );
}

function largestEntry(values) {
  return values.reduce((most, value) => Math.max(most, Math.abs(value)), 0);
}

/**
 * Return the poses along the shortest paths from pose 0, for edges of the given lengths, and
 * whether every pose is reached. Ties are broken by the lowest edge.
 *
 * Source: Dijkstra 1959.
 */
function posesAlongTree(graph, lengthOf) {
  const { n, m, tail, head } = graph;
  const distance = new Float64Array(n).fill(Infinity);
  distance[0] = 0;
  for (let changed = true; changed; ) {
    changed = false;
    for (let k = 0; k < m; k++) {
      for (const [from, to] of [[tail[k], head[k]], [head[k], tail[k]]]) {
        if (!(distance[from] + lengthOf(k) < distance[to])) continue;
        distance[to] = distance[from] + lengthOf(k);
        changed = true;
      }
    }
  }
  const edgeTo = new Int32Array(n).fill(-1);
  for (let k = m - 1; k >= 0; k--) {
    if (lengthOf(k) === Infinity) continue;
    if (distance[tail[k]] + lengthOf(k) === distance[head[k]]) edgeTo[head[k]] = k;
    if (distance[head[k]] + lengthOf(k) === distance[tail[k]]) edgeTo[tail[k]] = k;
  }
  const poses = new Float64Array(3 * n);
  const order = [...distance.keys()].filter((pose) => pose > 0 && distance[pose] < Infinity);
  order.sort((a, b) => distance[a] - distance[b]);
  for (const pose of order) {
    const k = edgeTo[pose];
    const forward = head[k] === pose;
    const parent = forward ? tail[k] : head[k];
    const relative = forward ? graph.measurement : graph.inverseMeasurement;
    const from = poses.subarray(3 * parent, 3 * parent + 3);
    poses.set(se2Compose(from, relative.subarray(3 * k, 3 * k + 3)), 3 * pose);
  }
  return { reached: order.length === n - 1, poses };
}

function flatNumbers(values) {
  return Float64Array.from(Array.isArray(values) ? values.flat(2) : values);
}
