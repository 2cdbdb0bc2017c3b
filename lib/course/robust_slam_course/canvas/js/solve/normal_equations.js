/**
 * Residuals of a pose graph and its normal equations: (Σ w Jᵀ Ω J) δ = −Σ w Jᵀ Ω r.
 *
 * Source: as `robust_slam.descent.normal_equations`: Grisetti et al. 2010; Solà et al. 2018 for
 * the Jacobians.
 */
import { quadraticForm } from "./blocks.js";
import {
  halfCotangent, logCoefficient, poseOf, se2Between, se2Compose, se2Log,
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
 * Return the edges at `poses` (3n) as { relative, residuals, squares }: x_i⁻¹ ∘ x_j and the
 * residual r = Log(z⁻¹ ∘ x_i⁻¹ ∘ x_j) in m and rad (3m each), and rᵀ Ω r (m,).
 */
export function edgesAt({ m, tail, head, inverses, information }, poses) {
  const [relative, residuals] = [new Float64Array(3 * m), new Float64Array(3 * m)];
  const squares = new Float64Array(m);
  for (let k = 0; k < m; k++) {
    const between = se2Between(poseOf(poses, tail[k]), poseOf(poses, head[k]));
    const residual = se2Log(se2Compose(inverses[k], between));
    for (let row = 0; row < 3; row++) {
      relative[3 * k + row] = between[row];
      residuals[3 * k + row] = residual[row];
    }
    squares[k] = quadraticForm(information[k], residual);
  }
  return { relative, residuals, squares };
}

/** Return the cost ½ Σ w rᵀ Ω r of what `edgesAt` returns. */
export function costOfEdges({ squares }, weights) {
  return 0.5 * squares.reduce((sum, square, k) => sum + weights[k] * square, 0);
}

/** Return the normal equations { pattern, hessian, gradient } at what `edgesAt` returns. */
export function normalEquations(graph, { relative, residuals }, weights) {
  const { pattern: { start } } = graph;
  const hessian = new Float64Array(graph.pattern.length);
  const gradient = new Float64Array(3 * graph.n);
  const [J, weighted] = [new Float64Array(18), new Float64Array(18)];
  const place = new Int32Array(6);
  for (let k = 0; k < graph.m; k++) {
    if (weights[k] === 0) continue;
    setJacobian(J, relative, residuals, 3 * k);
    const information = graph.information[k];
    for (let c = 0; c < 6; c++) {
      place[c] = 3 * (c < 3 ? graph.tail[k] : graph.head[k]) + (c % 3);
      for (let r = 0; r < 3; r++) {
        weighted[6 * r + c] = weights[k] * (information[3 * r] * J[c]
          + information[3 * r + 1] * J[6 + c] + information[3 * r + 2] * J[12 + c]);
      }
    }
    for (let a = 0; a < 6; a++) {
      const [first, second, third] = [weighted[a], weighted[6 + a], weighted[12 + a]];
      gradient[place[a]] += first * residuals[3 * k] + second * residuals[3 * k + 1]
        + third * residuals[3 * k + 2];
      for (let b = 0; b <= a; b++) {
        const [low, high] = [Math.min(place[a], place[b]) - 3, Math.max(place[a], place[b]) - 3];
        if (low < 0) continue; // pose 0
        hessian[start[high] + low] += first * J[b] + second * J[6 + b] + third * J[12 + b];
      }
    }
  }
  return { pattern: graph.pattern, hessian, gradient };
}

/**
 * Return { step, decrease }: the δ (3n) with (H + S) δ = −g and δ = 0 at pose 0, S being `damping`
 * times the diagonal of H, and the decrease of the linearised cost, ½ δᵀ(S δ − g). It is null
 * where the matrix is singular to working precision.
 */
export function solveEquations({ pattern, hessian, gradient }, damping = 0) {
  const { size, start } = pattern;
  const damped = hessian.slice();
  for (let r = 0; r < size; r++) damped[start[r] + r] *= 1 + damping;
  if (!skylineFactor(pattern, damped)) return null;
  const step = gradient.map((entry) => -entry).fill(0, 0, 3);
  const free = step.subarray(3);
  skylineSolve(pattern, damped, free);
  let decrease = 0;
  for (let r = 0; r < size; r++) {
    if (!Number.isFinite(free[r])) return null;
    const gain = damping * hessian[start[r] + r] * free[r] - gradient[r + 3];
    decrease += 0.5 * free[r] * gain;
  }
  return { step, decrease };
}

/**
 * Set `J` (3, 6) to the derivatives of the residual, from `at` on, by the tail and by the head:
 * J_j is the inverse of the right Jacobian at r, and J_i = −J_j Ad(x_j⁻¹ ∘ x_i).
 */
function setJacobian(J, relative, residuals, at) {
  const [x, y, angle] = [residuals[at], residuals[at + 1], residuals[at + 2]];
  const [a, c, half] = [halfCotangent(angle), logCoefficient(angle), angle / 2];
  const [cosine, sine] = [Math.cos(relative[at + 2]), Math.sin(relative[at + 2])];
  const along = sine * relative[at] - cosine * relative[at + 1];
  const across = cosine * relative[at] + sine * relative[at + 1];
  const rows = [[a, -half, c * x + y / 2], [half, a, c * y - x / 2]];
  rows.forEach(([p, q, turn], row) => {
    J[6 * row] = -p * cosine + q * sine;
    J[6 * row + 1] = -p * sine - q * cosine;
    J[6 * row + 2] = -p * along - q * across - turn;
    J[6 * row + 3] = p;
    J[6 * row + 4] = q;
    J[6 * row + 5] = turn;
  });
  [J[14], J[17]] = [-1, 1];
}
