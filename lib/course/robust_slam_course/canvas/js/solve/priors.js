/**
 * Switches whose closures have priors.
 *
 * A switch minimises s² u² + λ (1 − s)², and λ grows by twice the log-odds that the closure is an
 * inlier.
 *
 * Source: Sünderhauf and Protzel 2012 for the switches; the priors are derived in the labs.
 */
import { reweight, steadyRule } from "./loop.js";

const OFF = 1e-6; // the λ of a closure that its prior alone switches off

/**
 * Minimise the switched cost from `start`, with the `lambda` of even odds and the log-odds
 * `logOdds` of the closures, which follow the trusted edges. Returns what `reweight` returns.
 */
export function switchesWithPriors(problem, lambda, logOdds, start, options) {
  const first = problem.count - logOdds.length;
  const of = (k) => Math.max(OFF, lambda + 2 * logOdds[k - first]);
  const rule = steadyRule((u, state, k) => (of(k) / (of(k) + u * u)) ** 2, (u, k) => (0.5 * of(k) * u * u) / (of(k) + u * u));
  return reweight(problem, rule, start, options);
}
