/**
 * The cost of a location problem over x: its values, its minima, where descents end, and the
 * parabola that one step of IRLS minimises.
 *
 * Source: as `robust_slam_course.plots.landscapes` and `robust_slam.estimators.irls`.
 */
import { KERNELS } from "./kernels.js";

/**
 * Return the cost Σ ρ(|x − z|/σ) at `count` places from `low` to `high`, ends included.
 *
 * `rho(u)` is the cost of a whitened residual; `z` are the readings and `sigma` their standard
 * deviation, in the unit of x. `times` says how often each reading occurs, once by default.
 */
export function sampledCost(z, sigma, rho, [low, high], count, times = null) {
  const values = new Float64Array(count);
  for (let k = 0; k < count; k++) {
    const x = low + ((high - low) * k) / (count - 1);
    for (let i = 0; i < z.length; i++) {
      values[k] += (times ? times[i] : 1) * rho(Math.abs(x - z[i]) / sigma);
    }
  }
  return values;
}

/**
 * Return the places of the local minima of `values`, ends left out. A flat floor counts once, at
 * its middle, and only if it rises again on both sides.
 */
export function minimaOf(values) {
  const places = [];
  let fell = -1;
  for (let k = 0; k + 1 < values.length; k++) {
    const change = values[k + 1] - values[k];
    if (Math.abs(change) <= 1e-12) continue;
    if (change > 0 && fell >= 0) places.push(Math.floor((fell + 1 + k) / 2));
    fell = change < 0 ? k : -1;
  }
  return places;
}

/**
 * Return the majoriser of Σ ρ((x − z)/σ) that touches it at `at`, for readings `z` (m,).
 *
 * It is floor + ½ Σ w ((x − z)/σ)²: { weights (m,), floor, lowest, value(x) }. `lowest` is the x of
 * its minimum, in the unit of z, and null where all weights are 0.
 *
 * Source: Black and Rangarajan 1996; Hunter and Lange 2004, majorisation–minimisation.
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
  const value = (x) => weights.reduce((cost, weight, k) => cost + 0.5 * weight * ((x - z[k]) / sigma) ** 2, floor);
  return { weights, floor, lowest: total > 0 ? sum / total : null, value };
}
