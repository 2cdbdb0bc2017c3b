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

/** Relative changes of 99 % of the norms below which an adaptive μ takes 2 and 3 factors. */
const SMOOTH_CHANGES = [0.1, 0.05];

/** The smallest normal float: the first μ of TLS is at least this. */
const LEAST_MU = 2.2250738585072014e-308;

/**
 * Return the first μ for the largest norm `uMax`; `kind` is "tls" or "gm".
 *
 * For TLS it is c²/(2u² − c²), Infinity when 2u² ≤ c²: there is nothing to reject. For
 * Geman–McClure it is 2u²/c².
 *
 * Source: Yang et al. 2020, Remark 5.
 */
export function startMu(uMax, c, kind = "tls") {
  const ratio = 2 * (uMax / c) ** 2;
  if (kind === "gm") return Math.min(ratio, Number.MAX_VALUE);
  return ratio <= 1 ? Infinity : Math.max(1 / (ratio - 1), LEAST_MU);
}

/**
 * Return the number of factors, 1 to 3, by which an adaptive rule updates μ.
 *
 * `moved` is the change of each norm u in a step, relative to 1 + u.
 */
export function strides(moved) {
  const most = moved.length > 0 ? quantile99(moved) : 0;
  return 1 + SMOOTH_CHANGES.filter((change) => most <= change).length;
}

/** Return the rule of GNC-TLS: μ grows until every weight is 0 or 1. */
export function gncTlsRule(c, { factor = 1.4, mu0 = null, adaptive = false } = {}) {
  return {
    start(norms) {
      const mu = startMu(largestNorm(norms), c, "tls");
      if (mu === Infinity) return STOP.nothingToReject;
      return mu0 ?? mu;
    },
    weight: (u, mu) => tlsWeight(u, c, mu),
    rho: (u) => KERNELS.tls.rho(u, c),
    next(mu, weights, moved) {
      if (!adaptive) return factor * mu;
      // As long as no weight is 1, an approximate solution is enough.
      return factor ** (weights.includes(1) ? strides(moved) : 2) * mu;
    },
    finished(weights) {
      // Clipped weights are exactly 0 and 1, so this needs no tolerance.
      return weights.every((w) => w === 0 || w === 1) ? STOP.binaryWeights : null;
    },
  };
}

/** Return the rule of GNC-GM: μ decreases to 1, the kernel itself. */
export function gncGmRule(c, { factor = 1.4, mu0 = null, adaptive = false } = {}) {
  return {
    start(norms) {
      if (norms.length === 0) return STOP.nothingToReject;
      return Math.max(1, mu0 ?? startMu(largestNorm(norms), c, "gm"));
    },
    weight: (u, mu) => gmWeight(u, c, mu),
    rho: (u) => KERNELS["geman-mcclure"].rho(u, c),
    next: (mu, weights, moved) => Math.max(1, mu / factor ** (adaptive ? strides(moved) : 1)),
    finished: (weights, mu) => (mu === 1 ? STOP.converged : null),
  };
}

/**
 * Minimise Σ ρ(u) of the TLS or Geman–McClure kernel by graduated non-convexity.
 *
 * `c` is the scale of the kernel and `kind` "tls" or "gm". Without `x0` it starts at least
 * squares; on a pose graph with trusted odometry `problem.guess` is the better start. Options:
 * factor, mu0 and adaptive of the rules, tol, maxIterations and keepHistory of `reweight`. The
 * last solve is repeated until it converges. On a pose graph give tol = 1e-6, as the library
 * does.
 *
 * Source: Yang et al. 2020, (12), (14) and Remark 5.
 */
export function gnc(problem, c, kind = "tls", x0 = null, options = {}) {
  const { tol = 1e-9, maxIterations = 1000, keepHistory = true } = options;
  const rule = kind === "gm" ? gncGmRule(c, options) : gncTlsRule(c, options);
  const result = reweight(problem, rule, x0, { tol, maxIterations, keepHistory });
  if (result.stop !== STOP.binaryWeights && result.stop !== STOP.converged) return result;
  return settle(problem, rule, result, tol, keepHistory);
}

function largestNorm(norms) {
  let most = 0;
  for (const u of norms) if (u > most) most = u;
  return most;
}

/** Return the 0.99 quantile of `values`, interpolated linearly as numpy does. */
function quantile99(values) {
  const sorted = Float64Array.from(values).sort();
  const place = 0.99 * (sorted.length - 1);
  const below = Math.floor(place);
  const share = place - below;
  const low = sorted[below];
  const high = sorted[Math.min(below + 1, sorted.length - 1)];
  return share >= 0.5 ? high - (high - low) * (1 - share) : low + (high - low) * share;
}
