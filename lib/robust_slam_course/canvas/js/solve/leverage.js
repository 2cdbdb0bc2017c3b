/**
 * How far readings pull a line towards themselves.
 *
 * Source: Hoaglin and Welsch 1978, the diagonal of the hat matrix.
 */

/**
 * Return the leverage of each reading at places `p` (m,) on a line fitted by least squares.
 *
 * It is the share of a reading's movement that the fit at its place follows, between 1/m and 1.
 */
export function lineLeverages(p) {
  const mean = p.reduce((sum, place) => sum + place, 0) / p.length;
  const spread = p.reduce((sum, place) => sum + (place - mean) ** 2, 0);
  return Float64Array.from(p, (place) => 1 / p.length + (place - mean) ** 2 / spread);
}
