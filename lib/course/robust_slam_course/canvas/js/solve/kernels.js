/**
 * Robust kernels: the cost ρ, the influence ψ = ρ' and the weight w = ψ/u, and the surrogates of
 * graduated non-convexity.
 *
 * u is a whitened residual (no unit), c > 0 the kernel's scale, ρ(u) ≈ u²/2 near 0, so w(0) = 1.
 * Every kernel is even in u, and |u| = c belongs to the inner piece.
 *
 * Source: as `robust_slam.estimators.kernels` and `robust_slam.estimators.graduation`.
 */

/** The kernels of the pictures by the names that the library gives them. */
export const KERNELS = {
  /** The squared kernel ρ = u²/2 of least squares; c has no effect. */
  squared: { label: "squared", rho: (u, c) => 0.5 * u * u, psi: (u, c) => u, weight: (u, c) => 1 },

  /** Huber 1964: u²/2 up to |u| = c and c(|u| − c/2) beyond. */
  huber: {
    label: "Huber",
    rho(u, c) {
      const size = Math.abs(u);
      return size <= c ? 0.5 * size * size : c * (size - 0.5 * c);
    },
    psi: (u, c) => Math.min(Math.max(u, -c), c),
    weight: (u, c) => c / Math.max(Math.abs(u), c),
  },

  /** Cauchy: ρ = (c²/2) ln(1 + u²/c²). */
  cauchy: {
    label: "Cauchy",
    rho: (u, c) => 0.5 * c * c * Math.log1p((u / c) ** 2),
    psi: (u, c) => u / (1 + (u / c) ** 2),
    weight: (u, c) => 1 / (1 + (u / c) ** 2),
  },

  /** Geman and McClure 1985: ρ = (u²/2)/(1 + u²/c²), bounded by c²/2. */
  "geman-mcclure": {
    label: "Geman–McClure",
    rho: (u, c) => (0.5 * u * u) / (1 + (u / c) ** 2),
    psi: (u, c) => u / (1 + (u / c) ** 2) ** 2,
    weight: (u, c) => 1 / (1 + (u / c) ** 2) ** 2,
  },

  /** Truncated least squares: ρ = min(u², c²)/2. */
  tls: {
    label: "TLS",
    rho: (u, c) => 0.5 * Math.min(Math.abs(u), c) ** 2,
    psi: (u, c) => (Math.abs(u) <= c ? u : 0),
    weight: (u, c) => (Math.abs(u) <= c ? 1 : 0),
  },
};

/**
 * Return the weight of the TLS surrogate at μ: 1 up to u² = c²μ/(μ+1), 0 from u² = c²(μ+1)/μ,
 * and (c/|u|)√(μ(μ+1)) − μ between them.
 *
 * Source: Yang et al. 2020, equation (14).
 */
export function tlsWeight(u, c, mu) {
  const between = (c / Math.abs(u)) * rootOfMuAndNext(mu) - mu;
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
  return KERNELS["geman-mcclure"].weight(u, c * Math.sqrt(mu));
}

/** Return the Geman–McClure surrogate ½ μc²u²/(μc² + u²): the kernel itself at μ = 1. */
export function gmSurrogate(u, c, mu) {
  return KERNELS["geman-mcclure"].rho(u, c * Math.sqrt(mu));
}

/** Return √(μ(μ+1)) as √μ √(μ+1), which does not overflow. */
function rootOfMuAndNext(mu) {
  return Math.sqrt(mu) * Math.sqrt(mu + 1);
}
