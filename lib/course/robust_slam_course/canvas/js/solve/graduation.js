/**
 * Graduated non-convexity: the loop with a surrogate kernel that becomes less convex.
 *
 * The surrogate is nearly convex at first and equals the kernel in the end. Its parameter μ grows
 * from near 0 for TLS and decreases to 1 for Geman–McClure. Each step computes the weights at the
 * last residuals, solves once from the current x, and updates μ.
 *
 * Source: as `robust_slam.estimators.graduation`: Yang et al. 2020, (12), (14) and Remark 5.
 */
import { KERNELS, gmWeight, tlsWeight } from "./kernels.js";
import { STOP, reweight, settle } from "./loop.js";

/**
 * Return the first μ for the largest norm `uMax`; `kind` is "tls" or "gm".
 *
 * For TLS it is c²/(2u² − c²), Infinity when 2u² ≤ c²: there is nothing to reject. For
 * Geman–McClure it is 2u²/c².
 *
 * Source: Yang et al. 2020, Remark 5.
 */
function startMu(uMax, c, kind = "tls") {
  const ratio = 2 * (uMax / c) ** 2;
  if (kind === "gm") return ratio;
  return ratio <= 1 ? Infinity : 1 / (ratio - 1);
}

/** Return the rule of GNC-TLS: μ grows by `factor` until every weight is 0 or 1. */
export function gncTlsRule(c, factor) {
  return {
    start(norms) {
      const mu = startMu(Math.max(0, ...norms), c, "tls");
      return mu === Infinity ? STOP.nothingToReject : mu;
    },
    weight: (u, mu) => tlsWeight(u, c, mu),
    rho: (u) => KERNELS.tls.rho(u, c),
    next: (mu) => factor * mu,
    finished(weights) {
      // Clipped weights are exactly 0 and 1, so this needs no tolerance.
      return weights.every((w) => w === 0 || w === 1) ? STOP.binaryWeights : null;
    },
  };
}

/** Return the rule of GNC-GM: μ decreases by `factor` to 1, the kernel itself. */
function gncGmRule(c, factor) {
  return {
    start: (norms) => Math.max(1, startMu(Math.max(0, ...norms), c, "gm")),
    weight: (u, mu) => gmWeight(u, c, mu),
    rho: (u) => KERNELS["geman-mcclure"].rho(u, c),
    next: (mu) => Math.max(1, mu / factor),
    finished: (weights, mu) => (mu === 1 ? STOP.converged : null),
  };
}

/**
 * Minimise Σ ρ(u) of the TLS or Geman–McClure kernel by graduated non-convexity.
 *
 * `c` is the scale of the kernel and `kind` "tls" or "gm". Without `x0` it starts at least
 * squares; on a pose graph with trusted odometry `problem.guess` is the better start. `factor` is
 * that of μ; tol and maxIterations are those of `reweight`. The last solve is repeated until it
 * converges.
 *
 * Source: Yang et al. 2020, (12), (14) and Remark 5.
 */
export function gnc(problem, c, kind = "tls", x0 = null, options = {}) {
  const { factor = 1.4, tol = 1e-9, maxIterations = 1000 } = options;
  const rule = (kind === "gm" ? gncGmRule : gncTlsRule)(c, factor);
  const result = reweight(problem, rule, x0, { tol, maxIterations });
  if (result.stop !== STOP.binaryWeights && result.stop !== STOP.converged) return result;
  return settle(problem, rule, result, tol);
}
