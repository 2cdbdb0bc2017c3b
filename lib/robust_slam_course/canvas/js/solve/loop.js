/**
 * The one loop of the course: reweight, solve, repeat.
 *
 * A problem computes residuals and a weighted solution; a rule turns residuals into weights.
 * A problem is an object with
 *   count             the number of measurements, m
 *   trusted           a mask (m,) of the measurements whose weight stays 1
 *   initial()         the least-squares solution, all weights 1
 *   residualNorms(x)  the whitened residual norms (m,), at least 0
 *   solve(weights, x) the minimiser of Σ w u², started at x; null if it is not determined
 * A rule is an object with start, weights, next, cost and finished, as `irlsRule` below. Its
 * norms and weights are those of the untrusted measurements alone.
 *
 * Source: as `robust_slam.estimators.loop`: Black and Rangarajan 1996.
 */
import { KERNELS } from "./kernels.js";

/** Why the loop ended, in the words of the library. */
export const STOP = {
  converged: "converged",
  binaryWeights: "binary weights",
  nothingToReject: "nothing to reject",
  allRejected: "all rejected",
  underdetermined: "underdetermined",
  iterationLimit: "iteration limit",
};

/** The largest number of repetitions of the last solve. */
const SETTLING_SOLVES = 500;

/**
 * Run the loop from `x0`, or from least squares if it is null, until the rule stops it.
 *
 * A norm u has settled when its change, relative to 1 + u, is at most `tol`. Returns
 * { x, weights, cost, stop, history }; a step of the history is { x, weights, cost, mu }, and
 * step 0 is the start with weights 1. Without `keepHistory` only the last step is kept.
 */
export function reweight(problem, rule, x0 = null, options = {}) {
  const { tol = 1e-12, maxIterations = 100, keepHistory = true } = options;
  let x = x0 ?? problem.initial();
  if (x === null) throw new Error("the measurements do not determine the solution");
  const untrusted = untrustedPlaces(problem.trusted, problem.count);
  const own = new Float64Array(untrusted.length);
  let norms = problem.residualNorms(x);
  const ones = new Float64Array(problem.count).fill(1);
  const history = [{ x, weights: ones, cost: loopCost(problem, rule, norms), mu: null }];
  const record = (step) => (keepHistory ? history.push(step) : (history[0] = step));

  let state = rule.start(chosenNorms(norms, untrusted));
  if (typeof state === "string") return resultOf(history, state);
  for (let iteration = 0; iteration < maxIterations; iteration++) {
    const weights = ones.slice();
    untrusted.forEach((k, place) => {
      own[place] = weights[k] = rule.weight(norms[k], state);
    });
    const solution = problem.solve(weights, x);
    if (solution === null) {
      const cost = history[history.length - 1].cost;
      record({ x, weights, cost, mu: state });
      return resultOf(history, reasonWithoutSolution(own));
    }
    x = solution;
    const before = norms;
    norms = problem.residualNorms(x);
    record({ x, weights, cost: loopCost(problem, rule, norms), mu: state });
    const moved = movedNorms(before, norms);
    const stop = rule.finished(own, state, moved.every((change) => change <= tol));
    if (stop !== null) return resultOf(history, stop);
    state = rule.next(state, own, chosenNorms(moved, untrusted));
  }
  return resultOf(history, STOP.iterationLimit);
}

/**
 * Return `result` with its last solve repeated until no norm changes by more than `tol`, or
 * until Σ w u² no longer falls. An exact solve leaves the result unchanged.
 */
export function settle(problem, rule, result, tol, keepHistory = true) {
  let x = result.x;
  const first = problem.residualNorms(x);
  let norms = first;
  let stop = STOP.iterationLimit;
  for (let solve = 0; solve < SETTLING_SOLVES; solve++) {
    x = problem.solve(result.weights, x);
    const before = norms;
    norms = problem.residualNorms(x);
    let change = 0;
    for (let k = 0; k < norms.length; k++) {
      change += result.weights[k] * (norms[k] * norms[k] - before[k] * before[k]);
    }
    if (movedNorms(before, norms).every((moved) => moved <= tol) || change >= 0) {
      stop = result.stop;
      break;
    }
  }
  const unchanged = movedNorms(first, norms).every((moved) => moved <= tol);
  if (stop === result.stop && unchanged) return result;
  const mu = result.history[result.history.length - 1].mu;
  const last = { x, weights: result.weights, cost: loopCost(problem, rule, norms), mu };
  return resultOf(keepHistory ? [...result.history, last] : [last], stop);
}

/** Return the rule of iteratively reweighted least squares: the weight is ψ(u)/u. */
export function irlsRule(kernelName, c) {
  const kernel = KERNELS[kernelName];
  return {
    start: () => null,
    weight: (u) => kernel.weight(u, c),
    rho: (u) => kernel.rho(u, c),
    next: () => null,
    finished: (weights, state, settled) => (settled ? STOP.converged : null),
  };
}

/**
 * Minimise Σ ρ(u) by reweighting, from `x0`, or from least squares if it is null.
 *
 * `kernelName` is a key of KERNELS and `c` the kernel's scale. Options are those of `reweight`;
 * on a pose graph give tol = 1e-6, as the library does.
 */
export function irls(problem, kernelName, c, x0 = null, options = {}) {
  return reweight(problem, irlsRule(kernelName, c), x0, options);
}

function resultOf(history, stop) {
  const { x, weights, cost } = history[history.length - 1];
  return { x, weights, cost, stop, history };
}

function loopCost(problem, rule, norms) {
  let robust = 0;
  let trusted = 0;
  for (let k = 0; k < norms.length; k++) {
    if (problem.trusted[k]) trusted += norms[k] * norms[k];
    else robust += rule.rho(norms[k]);
  }
  return robust + 0.5 * trusted;
}

function untrustedPlaces(trusted, count) {
  const places = [];
  for (let k = 0; k < count; k++) if (!trusted[k]) places.push(k);
  return places;
}

function chosenNorms(values, places) {
  return Float64Array.from(places, (k) => values[k]);
}

function movedNorms(before, norms) {
  return norms.map((u, k) => Math.abs(u - before[k]) / (1 + before[k]));
}

function reasonWithoutSolution(untrustedWeights) {
  const rejected = untrustedWeights.length > 0 && !untrustedWeights.some((w) => w > 0);
  return rejected ? STOP.allRejected : STOP.underdetermined;
}
