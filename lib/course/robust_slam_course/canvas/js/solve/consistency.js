/**
 * Pairwise consistency maximisation: a largest set of mutually consistent closures.
 *
 * Two closures and the odometry between their ends make a cycle. Its error e is zero for exact
 * measurements, and the pair is consistent when √(eᵀ Σ⁻¹ e) is at most γ, with Σ the covariance of
 * e to first order. The largest set of pairwise consistent closures is a maximum clique.
 *
 * The odometry is one drive through the poses in their order, and every closure is taken in the
 * direction of travel. It displaces the world behind it by G = x_i ∘ z ∘ x_j⁻¹, with x from dead
 * reckoning: two closures are consistent when their displacements are equal.
 *
 * Source: as `robust_slam.consistency.pairwise`, where the covariance is derived: Mangelson et
 * al. 2018. As `robust_slam.consistency.cliques`: Tomita and Seki 2003.
 */
import { congruentBlock, inverseBlock, quadraticForm } from "./blocks.js";
import { deadReckoning } from "./pose_graph.js";
import { poseOf, se2Adjoint, se2Between, se2Compose, se2Inverse, se2Log } from "./se2.js";

/**
 * Return the closures that are kept: the largest pairwise consistent set.
 *
 * `gamma` is the largest distance of a consistent pair, for instance CHI_99_SE2. The result is
 * { kept, closures, clique, adjacency, distances }: a mask (m,) of edges, the k closures as
 * numbers of edges, the places of the kept ones among them, and by rows the mask (k, k) of
 * consistent pairs and their distances.
 */
export function pcm(graph, gamma) {
  const closures = [...graph.isOdometry.keys()].filter((edge) => !graph.isOdometry[edge]);
  const distances = pairwiseDistances(graph, closures);
  const adjacency = distances.map((distance) => Number(distance <= gamma));
  const clique = maxClique(adjacency, closures.length);
  const kept = graph.isOdometry.slice();
  for (const place of clique) kept[closures[place]] = 1;
  return { kept, closures, clique, adjacency, distances };
}

/** Return √(eᵀ Σ⁻¹ e) of all pairs of `closures` (k, k), symmetric with a zero diagonal. */
function pairwiseDistances(graph, closures) {
  const k = closures.length;
  const distances = new Float64Array(k * k);
  const poses = deadReckoning(graph);
  const sums = odometryCovariances(graph, poses);
  const displaced = closures.map((edge) => displacement(graph, poses, edge));
  for (let p = 0; p < k; p++) {
    for (let q = p + 1; q < k; q++) {
      const distance = cycleDistance(sums, displaced[p], displaced[q]);
      distances[p * k + q] = distances[q * k + p] = distance;
    }
  }
  return distances;
}

/**
 * Return the vertices, ascending, of a largest clique.
 *
 * `adjacency` (k, k) is symmetric; its diagonal does not matter. Sets of vertices are the bits of
 * a BigInt. Of several largest cliques any one may be returned. Meant for some dozens of
 * vertices.
 *
 * Source: Tomita and Seki 2003, branch and bound with a greedy colouring.
 */
export function maxClique(adjacency, k) {
  const near = Array.from({ length: k }, (_, v) => {
    let set = 0n;
    for (let other = 0; other < k; other++) {
      if (other !== v && adjacency[v * k + other]) set |= 1n << BigInt(other);
    }
    return set;
  });
  let best = [];
  function grow(chosen, candidates) {
    if (chosen.length > best.length) best = chosen;
    const { order, colours } = colouredVertices(candidates, near);
    for (let place = order.length - 1; place >= 0; place--) {
      // No clique among vertices of `colours[place]` colours is larger than that.
      if (chosen.length + colours[place] <= best.length) return;
      const v = order[place];
      grow([...chosen, v], candidates & near[v]);
      candidates &= ~(1n << BigInt(v));
    }
  }
  grow([], (1n << BigInt(k)) - 1n);
  return best.sort((a, b) => a - b);
}

/** Return, of all cliques of `size` among `k` vertices, the first in the order of their numbers. */
export function firstClique(adjacency, k, size, chosen = []) {
  if (chosen.length === size) return chosen;
  for (let v = (chosen.at(-1) ?? -1) + 1; v < k; v++) {
    if (!chosen.every((other) => adjacency[v * k + other])) continue;
    const found = firstClique(adjacency, k, size, [...chosen, v]);
    if (found) return found;
  }
  return null;
}

/** Return vertices in the order of their colours: joined vertices have different colours. */
function colouredVertices(candidates, near) {
  const order = [];
  const colours = [];
  for (let colour = 1; candidates !== 0n; colour++) {
    let free = candidates;
    while (free !== 0n) {
      const lowest = free & -free;
      const v = Math.log2(Number(lowest));
      candidates ^= lowest;
      free &= ~(near[v] | lowest);
      order.push(v);
      colours.push(colour);
    }
  }
  return { order, colours };
}

/** Return the covariance of the odometry from pose 0 to each pose, in the world frame. */
function odometryCovariances(graph, poses) {
  const sums = [Array(9).fill(0)];
  graph.isOdometry.forEach((isOdometry, k) => {
    if (!isOdometry) return;
    const adjoint = se2Adjoint(poseOf(poses, graph.head[k]));
    const own = congruentBlock(adjoint, inverseBlock(graph.information[k]));
    sums[graph.head[k]] = summedBlocks(sums[graph.tail[k]], own);
  });
  return sums;
}

/** Return a closure in the direction of travel: its ends, G, Ad(G⁻¹) and its covariance. */
function displacement(graph, poses, edge) {
  let ends = [graph.tail[edge], graph.head[edge]];
  let z = graph.measurements[edge];
  let covariance = inverseBlock(graph.information[edge]);
  if (ends[0] > ends[1]) {
    // (z Exp(δ))⁻¹ = z⁻¹ Exp(−Ad(z) δ)
    covariance = congruentBlock(se2Adjoint(z), covariance);
    z = se2Inverse(z);
    ends = [ends[1], ends[0]];
  }
  const [start, end] = ends.map((pose) => poseOf(poses, pose));
  const move = se2Compose(se2Compose(start, z), se2Inverse(end));
  const adjoint = se2Adjoint(se2Inverse(move));
  return { ends, move, adjoint, own: congruentBlock(se2Adjoint(end), covariance) };
}

function cycleDistance(sums, p, q) {
  const error = se2Log(se2Between(q.move, p.move));
  const between = (end) => {
    const [first, last] = [p.ends[end], q.ends[end]].sort((a, b) => a - b);
    return sums[last].map((entry, k) => entry - sums[first][k]);
  };
  const covariance = summedBlocks(p.own, q.own, between(1), congruentBlock(q.adjoint, between(0)));
  return Math.sqrt(Math.max(0, quadraticForm(inverseBlock(covariance), error)));
}

function summedBlocks(first, ...others) {
  return first.map((entry, k) => others.reduce((sum, other) => sum + other[k], entry));
}
