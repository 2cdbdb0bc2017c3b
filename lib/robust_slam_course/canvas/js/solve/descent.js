/**
 * Gauss–Newton with backtracking and Levenberg–Marquardt on the poses of a graph.
 *
 * Source: as `robust_slam.descent`: Dennis and Schnabel 1983, section 10.2; Marquardt 1963;
 * Nielsen 1999 for the damping.
 */
import {
  assembleEquations,
  evaluateEdges,
  linearChange,
  linearCostChange,
  lineariseEdges,
  solveEquations,
} from "./normal_equations.js";
import { costIncreases } from "./rounding.js";
import { sineRatio, wrapAngle } from "./se2.js";

const STEP_HALVINGS = 30;
/** The largest number of steps: gross errors make Gauss–Newton slow. */
export const DESCENT_LIMIT = 500;
const FIRST_DAMPING = 1e-4;

export function undampedDescent(equations, start, weights, tol, maxIterations) {
  const { graph, scaled } = equations;
  let poses = start;
  let cost = evaluateEdges(equations, poses, weights);
  let size = Infinity;
  for (let iteration = 0; iteration < maxIterations; iteration++) {
    lineariseEdges(equations);
    assembleEquations(equations, graph.information, weights, scaled);
    const step = solveEquations(equations);
    if (step === null) return null;
    size = largestOfStep(step);
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

export function dampedDescent(equations, start, weights, tol, maxIterations) {
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
    size = largestOfStep(step);
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

function largestOfStep(values) {
  return values.reduce((most, value) => Math.max(most, Math.abs(value)), 0);
}
