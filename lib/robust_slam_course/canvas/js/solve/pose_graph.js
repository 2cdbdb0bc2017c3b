/**
 * A pose graph in the plane as arrays: residuals, cost, dead reckoning, and the problem for the
 * loop.
 *
 * Edge k = (i, j) measures z, pose j in the frame of pose i. Its residual is Log(z⁻¹ ∘ x_i⁻¹ ∘ x_j)
 * with the information Ω in the order (ρx, ρy, θ). The cost is ½ Σ w ‖whitened residual‖². Poses
 * are a flat array (3n), pose 0 is fixed, and poses are perturbed on the right.
 *
 * Source: as `robust_slam.graphs.pose_graph`, `robust_slam.graphs.odometry` and
 * `robust_slam.problems`: Grisetti et al. 2010.
 */
import { DESCENT_LIMIT, dampedDescent, undampedDescent } from "./descent.js";
import { posesAlong, shortestForest } from "./forest.js";
import { fillResiduals, normalEquations, quadraticForm } from "./normal_equations.js";
import { se2Inverse } from "./se2.js";

/** The norm that a whitened Gaussian residual of 3 dimensions does not exceed with 99 %. */
export const CHI_99_SE2 = 3.368214175218727;

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

/** Return the poses from the odometry alone, pose 0 the identity; null where it has gaps. */
export function deadReckoning(graph) {
  const forest = shortestForest(graph, (k) => (graph.isOdometry[k] ? 1 : Infinity), [0]);
  return forest.order.length === graph.n ? posesAlong(graph, forest) : null;
}

/**
 * Return the poses along a spanning tree, pose 0 the identity.
 *
 * Of all paths it takes one with the fewest closures, of these one with the fewest edges: a
 * complete odometry gives dead reckoning.
 */
export function spanningTree(graph) {
  // A path has fewer than n edges, so closures of length n are minimised first.
  const length = (k) => (graph.isOdometry[k] ? 1 : graph.n);
  return posesAlong(graph, shortestForest(graph, length, [0]));
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
  const weights = new Float64Array(problem.count).fill(1);
  if (!joinsAllPoses(problem.graph, weights)) return null;
  return dampedDescent(problem.equations, problem.guess, weights, problem.tol, DESCENT_LIMIT);
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

function flatNumbers(values) {
  return Float64Array.from(Array.isArray(values) ? values.flat(2) : values);
}
