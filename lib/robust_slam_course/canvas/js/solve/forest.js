/**
 * Spanning trees of a pose graph by shortest paths, and the poses along them.
 *
 * Source: as `robust_slam.graphs.forest`: Bellman 1958 for the paths.
 */
import { se2Compose } from "./se2.js";

/**
 * Return the trees of shortest paths from `roots` as { parent, edge, order }.
 *
 * `lengthOf(k)` is the length of edge k, Infinity to leave it out. A root, or a pose that is not
 * reached, is its own parent with edge −1. `order` lists the poses that are reached, parents
 * before their children. Ties are broken by the lowest edge.
 */
export function shortestForest({ n, m, tail, head }, lengthOf, roots) {
  const length = Float64Array.from({ length: m }, (_, k) => lengthOf(k));
  const distance = new Float64Array(n).fill(Infinity);
  for (const root of roots) distance[root] = 0;
  for (let shorter = true; shorter; ) {
    shorter = false;
    for (let k = 0; k < m; k++) {
      for (const [from, to] of [[tail[k], head[k]], [head[k], tail[k]]]) {
        if (!(distance[from] + length[k] < distance[to])) continue;
        distance[to] = distance[from] + length[k];
        shorter = true;
      }
    }
  }
  const parent = Int32Array.from({ length: n }, (_, pose) => pose);
  const edge = new Int32Array(n).fill(-1);
  for (let k = m - 1; k >= 0; k--) {
    if (length[k] === Infinity) continue;
    for (const [from, to] of [[tail[k], head[k]], [head[k], tail[k]]]) {
      if (distance[from] + length[k] === distance[to]) [parent[to], edge[to]] = [from, k];
    }
  }
  const order = [...distance.keys()].filter((pose) => distance[pose] < Infinity);
  order.sort((a, b) => distance[a] - distance[b]);
  return { parent, edge, order };
}

/** Return the poses (3n) along the trees of `shortestForest`, each root the identity. */
export function posesAlong(graph, { parent, edge, order }) {
  const poses = new Float64Array(3 * graph.n);
  for (const pose of order) {
    const k = edge[pose];
    if (k < 0) continue;
    const relative = graph.head[k] === pose ? graph.measurement : graph.inverseMeasurement;
    const from = poses.subarray(3 * parent[pose], 3 * parent[pose] + 3);
    poses.set(se2Compose(from, relative.subarray(3 * k, 3 * k + 3)), 3 * pose);
  }
  return poses;
}
