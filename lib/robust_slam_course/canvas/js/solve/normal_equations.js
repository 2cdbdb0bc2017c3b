/**
 * Residuals of a pose graph and its normal equations: (Σ w Jᵀ Ω J) δ = −Σ w Jᵀ Ω r.
 *
 * Source: as `robust_slam.descent.normal_equations`: Grisetti et al. 2010; Solà et al. 2018 for
 * the Jacobians.
 */
import {
  blockProduct, blockTimes, congruentBlock, quadraticForm, transposedBlock,
} from "./blocks.js";
import {
  halfCotangent, logCoefficient, poseOf, se2Adjoint, se2Between, se2Compose, se2Inverse, se2Log,
} from "./se2.js";
import { skylineFactor, skylinePattern, skylineSolve } from "./skyline.js";

/**
 * Return the pattern of the equations: a row begins at the lowest pose, except pose 0, that an
 * edge joins its own to.
 */
export function equationsPattern(n, edges) {
  const lowest = Array.from({ length: n }, (_, pose) => pose);
  for (const ends of edges) {
    const [low, high] = [Math.min(...ends), Math.max(...ends)];
    if (low > 0) lowest[high] = Math.min(lowest[high], low);
  }
  return skylinePattern(lowest.slice(1).flatMap((pose) => Array(3).fill(3 * (pose - 1))));
}

/**
 * Return each edge at `poses` (3n) as { relative, residual, square }: x_i⁻¹ ∘ x_j, the residual
 * r = Log(z⁻¹ ∘ x_i⁻¹ ∘ x_j) in m and rad, and rᵀ Ω r.
 */
export function edgesAt({ tail, head, inverses, information }, poses) {
  return inverses.map((inverse, k) => {
    const relative = se2Between(poseOf(poses, tail[k]), poseOf(poses, head[k]));
    const residual = se2Log(se2Compose(inverse, relative));
    return { relative, residual, square: quadraticForm(information[k], residual) };
  });
}

/** Return the cost ½ Σ w rᵀ Ω r of what `edgesAt` returns. */
export function costOfEdges(edges, weights) {
  return 0.5 * edges.reduce((sum, { square }, k) => sum + weights[k] * square, 0);
}

/** Return the normal equations { pattern, hessian, gradient } at what `edgesAt` returns. */
export function normalEquations(graph, edges, weights) {
  const { pattern } = graph;
  const hessian = new Float64Array(pattern.length);
  const gradient = new Float64Array(3 * graph.n);
  edges.forEach(({ relative, residual }, k) => {
    if (weights[k] === 0) return;
    const [i, j] = [graph.tail[k], graph.head[k]];
    const weighted = graph.information[k].map((entry) => weights[k] * entry);
    const backHead = transposedBlock(headJacobian(residual));
    // J_i = J_j T with T = −Ad(x_j⁻¹ ∘ x_i), so the blocks of an edge are Tᵀ G T, Tᵀ G and G.
    const backTail = transposedBlock(se2Adjoint(se2Inverse(relative)).map((entry) => -entry));
    const atHead = congruentBlock(backHead, weighted);
    addPoseBlock(pattern, hessian, j, j, atHead);
    addPoseBlock(pattern, hessian, i, j, blockProduct(backTail, atHead));
    addPoseBlock(pattern, hessian, i, i, congruentBlock(backTail, atHead));
    const pull = blockTimes(backHead, blockTimes(weighted, residual));
    const pullBack = blockTimes(backTail, pull);
    for (let row = 0; row < 3; row++) {
      gradient[3 * j + row] += pull[row];
      gradient[3 * i + row] += pullBack[row];
    }
  });
  return { pattern, hessian, gradient };
}

/**
 * Return { step, decrease }: the δ (3n) with (H + S) δ = −g and δ = 0 at pose 0, S being `damping`
 * times the diagonal of H, and the decrease of the linearised cost, ½ δᵀ(S δ − g). It is null
 * where the matrix is singular to working precision.
 */
export function solveEquations({ pattern, hessian, gradient }, damping = 0) {
  const damped = hessian.slice();
  const diagonal = Array.from(pattern.start, (start, r) => hessian[start + r]);
  diagonal.forEach((entry, r) => { damped[pattern.start[r] + r] += damping * entry; });
  if (!skylineFactor(pattern, damped)) return null;
  const step = gradient.map((entry) => -entry).fill(0, 0, 3);
  const free = step.subarray(3);
  skylineSolve(pattern, damped, free);
  if (!free.every(Number.isFinite)) return null;
  const gain = (r) => free[r] * (damping * diagonal[r] * free[r] - gradient[r + 3]);
  return { step, decrease: 0.5 * diagonal.reduce((sum, _, r) => sum + gain(r), 0) };
}

/** Return ∂r/∂x_j, the inverse of the right Jacobian at r. */
function headJacobian(residual) {
  const [x, y, angle] = residual;
  const a = halfCotangent(angle);
  const c = logCoefficient(angle);
  return [
    a, -angle / 2, c * x + y / 2,
    angle / 2, a, c * y - x / 2,
    0, 0, 1,
  ];
}

/** Add a block in the rows of pose i and the columns of pose j to the lower triangle. */
function addPoseBlock({ start }, hessian, i, j, block) {
  if (i === 0 || j === 0) return;
  for (let k = 0; k < 9; k++) {
    const row = 3 * (i - 1) + Math.floor(k / 3);
    const column = 3 * (j - 1) + (k % 3);
    if (i === j && column > row) continue;
    hessian[start[Math.max(row, column)] + Math.min(row, column)] += block[k];
  }
}
