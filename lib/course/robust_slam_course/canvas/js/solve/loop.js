/**
 * The one loop of the course: reweight, solve, repeat.
 *
 * A problem computes residuals and a weighted solution; a rule turns residuals into weights.
 * A problem is an object with
 *   count             the number of measurements, m
 *   trusted           a mask (m,) of the measurements whose weight stays 1
 *   initial()         the least-squares solution, all weights 1; not needed with a start
 *   residualNorms(x)  the whitened residual norms (m,), at least 0
 *   solve(weights, x) the minimiser of Σ w u², started at x; null if it is not determined
 * A rule is an object with start, weight, rho, next and finished, as `steadyRule` below. The norms
 * and weights that it is given are those of the untrusted measurements alone; `weight` and `rho`
 * are told the measurement's number, too.
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
 * step 0 is the start with weights 1.
 */
export function reweight(problem, rule, x0 = null, options = {}) {
  const { tol = 1e-12, maxIterations = 100 } = options;
  let x = x0 ?? problem.initial();
  let norms = problem.residualNorms(x);
  const ofUntrusted = (values) => values.filter((_, k) => !problem.trusted[k]);
  const ones = new Float64Array(problem.count).fill(1);
  const history = [{ x, weights: ones, cost: loopCost(problem, rule, norms), mu: null }];
  let state = rule.start(ofUntrusted(norms));
  if (typeof state === "string") return resultOf(history, state);
  for (let iteration = 0; iteration < maxIterations; iteration++) {
    const weights = norms.map((u, k) => (problem.trusted[k] ? 1 : rule.weight(u, state, k)));
    const own = ofUntrusted(weights);
    const solution = problem.solve(weights, x);
    if (solution === null) {
      history.push({ x, weights, cost: history.at(-1).cost, mu: state });
      const rejected = own.length > 0 && own.every((w) => w === 0);
      return resultOf(history, rejected ? STOP.allRejected : STOP.underdetermined);
    }
    x = solution;
    const before = norms;
    norms = problem.residualNorms(x);
    history.push({ x, weights, cost: loopCost(problem, rule, norms), mu: state });
    const stop = rule.finished(own, state, haveSettled(before, norms, tol));
    if (stop !== null) return resultOf(history, stop);
    state = rule.next(state);
  }
  return resultOf(history, STOP.iterationLimit);
}

/**
 * Return `result` with its last solve repeated until no norm changes by more than `tol`, or
 * until Σ w u² no longer falls. An exact solve leaves the result unchanged.
 */
export function settle(problem, rule, result, tol) {
  const { weights, stop, history } = result;
  const first = problem.residualNorms(result.x);
  const finish = (x, norms, ending) => {
    if (ending === stop && haveSettled(first, norms, tol)) return result;
    const last = { x, weights, cost: loopCost(problem, rule, norms), mu: history.at(-1).mu };
    return resultOf([...history, last], ending);
  };
  let [x, norms] = [result.x, first];
  for (let solve = 0; solve < SETTLING_SOLVES; solve++) {
    x = problem.solve(weights, x);
    const before = norms;
    norms = problem.residualNorms(x);
    const change = weights.reduce((sum, w, k) => sum + w * (norms[k] ** 2 - before[k] ** 2), 0);
    if (haveSettled(before, norms, tol) || change >= 0) return finish(x, norms, stop);
  }
  return finish(x, norms, STOP.iterationLimit);
}

/**
 * Minimise Σ ρ(u) by reweighting, from `x0`, or from least squares if it is null.
 *
 * `kernelName` is a key of KERNELS and `c` the kernel's scale. Options are those of `reweight`;
 * on a pose graph give tol = 1e-6, as the library does.
 */
export function irls(problem, kernelName, c, x0 = null, options = {}) {
  const { weight, rho } = KERNELS[kernelName];
  return reweight(problem, steadyRule((u) => weight(u, c), (u) => rho(u, c)), x0, options);
}

/** Return the rule of weights and costs that stay the same functions until the norms have settled. */
export function steadyRule(weight, rho) {
  const finished = (weights, state, settled) => (settled ? STOP.converged : null);
  return { start: () => null, weight, rho, next: () => null, finished };
}

function resultOf(history, stop) {
  const { x, weights, cost } = history.at(-1);
  return { x, weights, cost, stop, history };
}

function loopCost(problem, rule, norms) {
  let robust = 0;
  let trusted = 0;
  for (let k = 0; k < norms.length; k++) {
    if (problem.trusted[k]) trusted += norms[k] * norms[k];
    else robust += rule.rho(norms[k], k);
  }
  return robust + 0.5 * trusted;
}

/** Tell whether no norm u changed by more than `tol`, relative to 1 + u. */
function haveSettled(before, norms, tol) {
  return norms.every((u, k) => Math.abs(u - before[k]) <= tol * (1 + before[k]));
}
