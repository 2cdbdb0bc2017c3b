/**
 * The parabola that one step of IRLS minimises.
 *
 * Source: Black and Rangarajan 1996; Hunter and Lange 2004, majorisation–minimisation.
 */
import { KERNELS } from "./kernels.js";

/**
 * Return the majoriser of Σ ρ((x − z)/σ) that touches it at `at`, for readings `z` (m,).
 *
 * It is floor + ½ Σ w ((x − z)/σ)²: { weights (m,), floor, lowest, value(x) }. `lowest` is the x of
 * its minimum, in the unit of z, and null where all weights are 0.
 */
export function majoriser(z, sigma, kernelName, c, at) {
  const kernel = KERNELS[kernelName];
  const residuals = Float64Array.from(z, (reading) => (at - reading) / sigma);
  const weights = residuals.map((u) => kernel.weight(u, c));
  let [floor, total, sum] = [0, 0, 0];
  for (let k = 0; k < weights.length; k += 1) {
    floor += kernel.rho(residuals[k], c) - 0.5 * weights[k] * residuals[k] ** 2;
    total += weights[k];
    sum += weights[k] * z[k];
  }
  const value = (x) => weights.reduce(
    (cost, weight, k) => cost + 0.5 * weight * ((x - z[k]) / sigma) ** 2, floor,
  );
  return { weights, floor, lowest: total > 0 ? sum / total : null, value };
}
