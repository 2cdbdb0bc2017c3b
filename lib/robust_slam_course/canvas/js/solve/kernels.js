/**
 * Robust kernels: the cost ρ, the influence ψ = ρ' and the weight w = ψ/u, and the surrogates of
 * graduated non-convexity.
 *
 * u is a whitened residual (no unit), c > 0 the kernel's scale, ρ(u) ≈ u²/2 near 0, so w(0) = 1.
 * Every kernel is even in u, and |u| = c belongs to the inner piece.
 *
 * Source: as `robust_slam.estimators.kernels` and `robust_slam.estimators.graduation`.
 */

/** A ratio u/c whose square is still a float. */
const LARGEST_RATIO = 1e100;

/** The smallest normal float, so that 1/u is finite at u = 0. */
const SMALLEST_NORMAL = 2.2250738585072014e-308;

/** The squared kernel ρ = u²/2 of least squares; c has no effect. */
const squaredKernel = {
  label: "squared",
  influence: "unbounded",
  rho: (u, c) => 0.5 * u * u,
  psi: (u, c) => u,
  weight: (u, c) => 1,
  convexUntil: (c) => Infinity,
};

/** Huber 1964: u²/2 up to |u| = c and c(|u| − c/2) beyond. */
const huberKernel = {
  label: "Huber",
  influence: "bounded",
  rho(u, c) {
    const size = Math.abs(u);
    return size <= c ? 0.5 * size * size : c * (size - 0.5 * c);
  },
  psi: (u, c) => Math.min(Math.max(u, -c), c),
  weight: (u, c) => c / Math.max(Math.abs(u), c),
  convexUntil: (c) => Infinity,
};

/** Cauchy: ρ = (c²/2) ln(1 + u²/c²). */
const cauchyKernel = {
  label: "Cauchy",
  influence: "redescending",
  rho(u, c) {
    const size = Math.abs(u) / c;
    // ln(1 + v²) = 2 ln v where v² is beyond all floats, and to rounding long before.
    return c * c * (size < LARGEST_RATIO ? 0.5 * Math.log1p(size * size) : Math.log(size));
  },
  psi: (u, c) => u / (1 + (u / c) ** 2),
  weight: (u, c) => 1 / (1 + (u / c) ** 2),
  convexUntil: (c) => c,
};

/** Geman and McClure 1985: ρ = (u²/2)/(1 + u²/c²), bounded by c²/2. */
const gemanMcClureKernel = {
  label: "Geman–McClure",
  influence: "redescending",
  rho(u, c) {
    const size = Math.min(Math.abs(u) / c, LARGEST_RATIO);
    return (0.5 * c * c * (size * size)) / (1 + size * size);
  },
  psi: (u, c) => gemanMcClureKernel.weight(u, c) * u,
  weight: (u, c) => 1 / (1 + (u / c) ** 2) ** 2,
  convexUntil: (c) => c / Math.sqrt(3),
};

/** Truncated least squares: ρ = min(u², c²)/2. */
const tlsKernel = {
  label: "TLS",
  influence: "redescending",
  rho: (u, c) => 0.5 * Math.min(Math.abs(u), c) ** 2,
  psi: (u, c) => (Math.abs(u) <= c ? u : 0),
  weight: (u, c) => (Math.abs(u) <= c ? 1 : 0),
  convexUntil: (c) => c,
};

/** The kernel whose weight is that of dynamic covariance scaling with Φ = c² (Agarwal 2013). */
const dcsKernel = {
  label: "DCS",
  influence: "redescending",
  rho(u, c) {
    const square = (u / c) ** 2;
    const beyond = Math.max(square, 1);
    return c * c * (square <= 1 ? 0.5 * square : (1.5 - 0.5 / beyond) / (1 + 1 / beyond));
  },
  psi: (u, c) => dcsKernel.weight(u, c) * u,
  weight: (u, c) => Math.min(1, 2 / (1 + (u / c) ** 2)) ** 2,
  convexUntil: (c) => c,
};

/** Welsch: ρ = (c²/2)(1 − exp(−u²/c²)), bounded by c²/2. */
const welschKernel = {
  label: "Welsch",
  influence: "redescending",
  rho: (u, c) => -0.5 * c * c * Math.expm1(-((u / c) ** 2)),
  psi: (u, c) => welschKernel.weight(u, c) * u,
  weight: (u, c) => Math.exp(-((u / c) ** 2)),
  convexUntil: (c) => c / Math.sqrt(2),
};

/** Every kernel by the name that the library gives it. */
export const KERNELS = {
  squared: squaredKernel,
  huber: huberKernel,
  cauchy: cauchyKernel,
  "geman-mcclure": gemanMcClureKernel,
  tls: tlsKernel,
  dcs: dcsKernel,
  welsch: welschKernel,
};

/**
 * Return the weight of the TLS surrogate at μ: 1 up to u² = c²μ/(μ+1), 0 from u² = c²(μ+1)/μ,
 * and (c/|u|)√(μ(μ+1)) − μ between them.
 *
 * Source: Yang et al. 2020, equation (14).
 */
export function tlsWeight(u, c, mu) {
  const size = Math.max(Math.abs(u), SMALLEST_NORMAL);
  const between = (c / size) * rootOfMuAndNext(mu) - mu;
  return Math.min(Math.max(between, 0), 1);
}

/** Return the TLS surrogate ρ_μ(u), which becomes the TLS kernel as μ grows. */
export function tlsSurrogate(u, c, mu) {
  const size = Math.abs(u);
  if (size <= c * Math.sqrt(mu / (mu + 1))) return 0.5 * size * size;
  if (size >= c * Math.sqrt((mu + 1) / mu)) return 0.5 * c * c;
  return c * size * rootOfMuAndNext(mu) - 0.5 * mu * (c * c + size * size);
}

/** Return the weight (μc²/(u² + μc²))² of the Geman–McClure surrogate (Yang 2020, (12)). */
export function gmWeight(u, c, mu) {
  return gemanMcClureKernel.weight(u, c * Math.sqrt(mu));
}

/** Return the Geman–McClure surrogate ½ μc²u²/(μc² + u²): the kernel itself at μ = 1. */
export function gmSurrogate(u, c, mu) {
  return gemanMcClureKernel.rho(u, c * Math.sqrt(mu));
}

/** Return √(μ(μ+1)) as √μ √(μ+1), which does not overflow. */
function rootOfMuAndNext(mu) {
  return Math.sqrt(mu) * Math.sqrt(mu + 1);
}
