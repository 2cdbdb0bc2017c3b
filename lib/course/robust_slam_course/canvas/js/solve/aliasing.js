import { se2Between, se2Compose, se2Inverse } from "./se2.js";

/**
 * Return `size` wrong closures (i, j), (i + 1, j + 1), … that agree with each other, without
 * noise: { edges [[i, j], …], measurements (3 size, in m, m and rad) }. All follow from the one
 * `displacement` of the world. By default it moves pose j to pose i of `truth` (3n), so the first
 * measures "one place".
 *
 * Source: as `robust_slam.graphs.outliers.add_aliased_closures`.
 */
export function agreeingClosures(truth, [i, j], size, displacement = null) {
  const pose = (k) => truth.slice(3 * k, 3 * k + 3);
  const moved = displacement ?? se2Compose(pose(i), se2Inverse(pose(j)));
  const edges = Array.from({ length: size }, (_, k) => [i + k, j + k]);
  const measurements = edges.flatMap(([a, b]) => [...se2Between(pose(a), se2Compose(moved, pose(b)))]);
  return { edges, measurements };
}
