/**
 * The marginal covariances of poses, relative to pose 0.
 *
 * Source: as `robust_slam.descent.marginals`: Kaess and Dellaert 2009.
 */
import { edgesAt, normalEquations } from "./normal_equations.js";
import { skylineFactor, skylineSolve } from "./skyline.js";

/**
 * Return the covariance (9, by rows) of each of `numbers`, poses of `graph` other than 0, at a
 * minimum `poses` (3n) of Σ w u². It is that of a perturbation on the right, in m² and rad².
 */
export function poseCovariances(graph, poses, weights, numbers) {
  const { pattern, hessian } = normalEquations(graph, edgesAt(graph, poses), weights);
  if (!skylineFactor(pattern, hessian)) return null;
  return numbers.map((pose) => {
    const first = 3 * (pose - 1);
    return [0, 1, 2].flatMap((axis) => {
      const column = new Float64Array(pattern.size);
      column[first + axis] = 1;
      skylineSolve(pattern, hessian, column);
      return [...column.subarray(first, first + 3)];
    });
  });
}
