/**
 * A pose graph in the plane as arrays: residual norms, dead reckoning, and the problem for the
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
import { edgesAt, equationsPattern } from "./normal_equations.js";
import { poseOf, se2Compose, se2Inverse } from "./se2.js";

/** The norm that a whitened Gaussian residual of 3 dimensions does not exceed with 99 %. */
export const CHI_99_SE2 = 3.368214175218727;

/**
 * Return a graph for the functions of this module.
 *
 * `poses` is the number of poses n; `edges` [[i, j], …] (m, 2); `measurements` (m, 3) in m, m and
 * rad; `information` (m, 3, 3); `trusted` a mask (m,) of the odometry, whose edges are in the
 * order of the drive. Arrays may be nested or flat.
 */
export function makeGraph({ poses, edges, measurements, information, trusted }) {
  const rows = (values, width) => {
    const flat = values.flat(2);
    return edges.map((_, k) => flat.slice(width * k, width * (k + 1)));
  };
  const given = rows(measurements, 3);
  return {
    n: poses,
    m: edges.length,
    tail: edges.map(([i]) => i),
    head: edges.map(([, j]) => j),
    measurements: given,
    inverses: given.map(se2Inverse),
    information: rows(information, 9),
    isOdometry: Uint8Array.from(trusted, Number),
    pattern: equationsPattern(poses, edges),
  };
}

/**
 * Return the graph of `data`, as `robust_slam_course.pictures.graphs.graph_data` gives it, with
 * one more closure for each of `wrong`: { edges [[i, j], …], measurements (3 for each edge, by
 * default "one place"), information (9, by default that of the data) }. Of all these edges it has those of
 * the numbers `taken`, in their order, by default all.
 */
export function graphWithWrong(data, { edges, measurements, information }, taken = null) {
  const all = [...data.edges, ...edges];
  const numbers = taken ?? [...all.keys()];
  const precision = information ?? data.wrongInformation;
  const rows = (own, more, width) => {
    const values = [...own, ...more];
    return numbers.flatMap((k) => values.slice(width * k, width * (k + 1)));
  };
  return makeGraph({
    poses: data.truth.length / 3,
    edges: numbers.map((k) => all[k]),
    measurements: rows(data.measurements, measurements ?? edges.flatMap(() => [0, 0, 0]), 3),
    information: rows(data.information, edges.flatMap(() => precision), 9),
    trusted: rows(data.trusted, edges.map(() => 0), 1),
  });
}

/** Return the whitened residual norm of each edge (m,): the u of a kernel. */
export function graphResidualNorms(graph, poses) {
  return edgesAt(graph, poses).squares.map((square) => Math.sqrt(Math.max(0, square)));
}

/** Return the poses (3n) from the odometry alone, pose 0 the identity. */
export function deadReckoning(graph) {
  const poses = new Float64Array(3 * graph.n);
  graph.measurements.forEach((z, k) => {
    if (!graph.isOdometry[k]) return;
    poses.set(se2Compose(poseOf(poses, graph.tail[k]), z), 3 * graph.head[k]);
  });
  return poses;
}

/**
 * Return the problem of a pose graph for the loop; its x are poses (3n).
 *
 * `guess` (3n) is where `leastSquares` starts, by default the poses of `deadReckoning`; give the
 * loop a start. The odometry is trusted. Each solve takes at most `steps` Gauss–Newton steps.
 */
export function poseGraphProblem(graph, options = {}) {
  const { guess = deadReckoning(graph), tol = 1e-6, steps = 1 } = options;
  return {
    graph,
    guess,
    tol,
    count: graph.m,
    trusted: graph.isOdometry,
    residualNorms: (poses) => graphResidualNorms(graph, poses),
    solve: (weights, poses) => undampedDescent(graph, poses, weights, tol, steps)?.poses ?? null,
  };
}

/**
 * Return the least-squares poses from `problem.guess` as { poses, cost, converged }.
 *
 * Gross errors can make Gauss–Newton very slow, so this is Levenberg–Marquardt.
 */
export function leastSquares({ graph, guess, tol }) {
  return dampedDescent(graph, guess, new Float64Array(graph.m).fill(1), tol, DESCENT_LIMIT);
}
