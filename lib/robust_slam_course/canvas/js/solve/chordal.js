/**
 * The chordal problem of a pose graph in the plane: its cost, its certificate and the polish of a
 * map.
 *
 * The chordal cost is Σ κ ‖R_j − R_i R̃‖²_F + τ ‖t_j − t_i − R_i t̃‖², without a ½. Given the
 * rotations, the best positions are a linear problem, and without them the cost is tr(R Q Rᵀ).
 *
 * Source: as `robust_slam.certificates.chordal` and `optimality`: Rosen et al. 2019, "SE-Sync".
 */
import { addBlock, dotProduct, headingsRow, judgement, lessMultipliers } from "./certificate.js";
import { symmetricEigen } from "./eigen.js";
import { joinsAllPoses } from "./pose_graph.js";
import { skylineFactor, skylinePattern, skylineSolve } from "./skyline.js";
import { descend } from "./staircase.js";

/**
 * Return poses (3n) at a minimum of the chordal cost near `poses`, pose 0 fixed; null where edges
 * of positive weight do not join all poses. Certify a map there, not where Gauss–Newton stops.
 */
export function polishGraph(graph, poses, weights = null) {
  const problem = chordalProblem(graph, weights);
  if (problem === null) return null;
  const start = headingsRow(Float64Array.from({ length: graph.n }, (_, i) => poses[3 * i + 2]));
  const { R } = descend(problem.Q, start, 2);
  const positions = problem.place(R, poses);
  const polished = Float64Array.from(poses);
  for (let i = 1; i < graph.n; i++) {
    const angle = Math.atan2(R[2 * graph.n + 2 * i], R[2 * i]);
    polished.set([positions[2 * i], positions[2 * i + 1], angle], 3 * i);
  }
  return polished;
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
