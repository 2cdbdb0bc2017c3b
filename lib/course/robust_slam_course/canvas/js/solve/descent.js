/**
 * Gauss–Newton with backtracking and Levenberg–Marquardt on the poses of a graph.
 *
 * Source: as `robust_slam.descent`: Dennis and Schnabel 1983, section 10.2; Marquardt 1963;
 * Nielsen 1999 for the damping.
 */
import { costOfEdges, edgesAt, normalEquations, solveEquations } from "./normal_equations.js";
import { costIncreases } from "./rounding.js";
import { poseOf, se2Compose, sineRatio, wrapAngle } from "./se2.js";

const STEP_HALVINGS = 30;
/** The largest number of steps: gross errors make Gauss–Newton slow. */
export const DESCENT_LIMIT = 500;
const FIRST_DAMPING = 1e-4;

/**
 * Return the end { poses, cost, converged } of Gauss–Newton from `start`, null where the
 * equations are singular. A step that would increase the cost is halved until it does not.
 */
export function undampedDescent(graph, start, weights, tol, maxIterations) {
  let here = pointOn(graph, start, weights);
  for (let iteration = 0; iteration < maxIterations; iteration++) {
    const solved = solveEquations(normalEquations(graph, here.edges, weights));
    if (solved === null) return null;
    if (stepIsSmall(solved.step, here.poses, tol)) {
      const { poses, cost } = pointOn(graph, retractPoses(here.poses, solved.step), weights);
      return { poses, cost, converged: true };
    }
    here = backtracked(graph, here, weights, solved.step);
  }
  return { poses: here.poses, cost: here.cost, converged: false };
}

/** Take the longest of step, step/2, step/4, … that does not increase the cost. */
function backtracked(graph, here, weights, step) {
  for (let halvings = 0; halvings < STEP_HALVINGS; halvings++) {
    const trial = pointOn(graph, retractPoses(here.poses, step, 0.5 ** halvings), weights);
    if (!costIncreases(trial.cost, here.cost)) return trial;
  }
  return here;
}

/** Return the end of Levenberg–Marquardt, as `undampedDescent` returns its own. */
export function dampedDescent(graph, start, weights, tol, maxIterations) {
  let here = pointOn(graph, start, weights);
  let equations = normalEquations(graph, here.edges, weights);
  let [damping, growth] = [FIRST_DAMPING, 2];
  for (let iteration = 0; iteration < maxIterations; iteration++) {
    const solved = solveEquations(equations, damping);
    if (solved === null) return null;
    const trial = pointOn(graph, retractPoses(here.poses, solved.step), weights);
    if (costIncreases(trial.cost, here.cost)) {
      damping *= growth;
      growth *= 2;
      continue;
    }
    const converged = stepIsSmall(solved.step, here.poses, tol);
    const predicted = Math.max(solved.decrease, Number.MIN_VALUE);
    damping *= dampingFactor((here.cost - trial.cost) / predicted);
    growth = 2;
    here = trial;
    if (converged) return { poses: here.poses, cost: here.cost, converged };
    equations = normalEquations(graph, here.edges, weights);
  }
  return { poses: here.poses, cost: here.cost, converged: false };
}

function pointOn(graph, poses, weights) {
  const edges = edgesAt(graph, poses);
  return { poses, edges, cost: costOfEdges(edges, weights) };
}

/** Return each pose ∘ Exp(scale · δ), with δ its three numbers of `step` (3n). */
function retractPoses(poses, step, scale = 1) {
  const moved = new Float64Array(poses.length);
  for (let at = 0; at < poses.length; at += 3) {
    const [x, y, angle] = [scale * step[at], scale * step[at + 1], scale * step[at + 2]];
    const a = sineRatio(angle);
    const b = Math.sin(angle / 2) * sineRatio(angle / 2);
    const motion = [a * x - b * y, b * x + a * y, wrapAngle(angle)];
    moved.set(se2Compose(poseOf(poses, at / 3), motion), at);
  }
  return moved;
}

/**
 * Tell whether a step moves positions by at most tol · (1 m + extent) and headings by tol; the
 * extent is the map's longest side. The rounding of coordinates is allowed on top.
 */
function stepIsSmall(step, poses, tol) {
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
function dampingFactor(gainRatio) {
  const gain = Math.min(Math.max(gainRatio, 0), 1);
  return Math.max(1 / 3, 1 - (2 * gain - 1) ** 3);
}
