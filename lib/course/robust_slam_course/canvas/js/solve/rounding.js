/**
 * What counts as rounding where a descent compares costs.
 *
 * Source: as `robust_slam.descent`.
 */

/** A relative increase of the cost that counts as rounding, and a cost that counts as 0. */
const COST_ROUNDING = 1e-12;
const NEGLIGIBLE_COST = 1e-18;

/** Tell whether `cost` is higher than the one `before` by more than rounding. */
export function costIncreases(cost, before) {
  return cost > before * (1 + COST_ROUNDING) + NEGLIGIBLE_COST;
}
