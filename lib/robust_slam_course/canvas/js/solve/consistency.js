/**
 * Pairwise consistency maximisation: a largest set of mutually consistent closures.
 *
 * Two closures and the odometry between their ends make a cycle. Its error e is zero for exact
 * measurements, and the pair is consistent when √(eᵀ Σ⁻¹ e) is at most γ, with Σ the covariance of
 * e to first order. The largest set of pairwise consistent closures is a maximum clique.
 *
 * Every closure is taken in the direction of travel. Closures are compared when they join the
 * same two sessions, the parts that odometry connects; others do not contradict each other. A
 * closure displaces the world behind it by G = x_i ∘ z ∘ x_j⁻¹, with x from dead reckoning: two
 * closures are consistent when their displacements are equal.
 *
 * Source: as `robust_slam.consistency.pairwise`, where the covariance is derived: Mangelson et
 * al. 2018. As `robust_slam.consistency.cliques`: Tomita and Seki 2003.
 */
import { posesAlong, shortestForest } from "./forest.js";
import { se2Adjoint, se2Between, se2Compose, se2Inverse, se2Log } from "./se2.js";

/**
 * Return the distances √(eᵀ Σ⁻¹ e) of all pairs of closures of a graph.
 *
 * The result is { closures, distances, comparable }: the k closures as numbers of edges, the
 * distances (k, k) by rows, symmetric with a zero diagonal, and a mask (k, k) of the pairs that
 * join the same two sessions; other distances are 0. `sharedOdometry` accounts for odometry that
 * is in both parts of the cycle; the paper assumes that the parts are independent.
 */
export function pairwiseDistances(graph, { sharedOdometry = false } = {}) {
  const closures = [...graph.isOdometry.keys()].filter((edge) => !graph.isOdometry[edge]);
  const k = closures.length;
  const distances = new Float64Array(k * k);
  const comparable = new Uint8Array(k * k);
  const world = odometryWorld(graph);
  const displaced = closures.map((edge) => displacement(graph, world, edge));
  for (let p = 0; p < k; p++) {
    for (let q = p; q < k; q++) {
      const [one, other] = [displaced[p], displaced[q]];
      if (one.sessions[0] !== other.sessions[0] || one.sessions[1] !== other.sessions[1]) continue;
      comparable[p * k + q] = comparable[q * k + p] = 1;
      if (p === q) continue;
      const distance = cycleDistance(world, one, other, sharedOdometry);
      distances[p * k + q] = distances[q * k + p] = distance;
    }
  }
  return { closures, distances, comparable };
}

/** Return the mask (k, k) of the pairs whose distance is at most `gamma`, the diagonal 1. */
export function consistentPairs(distances, k, gamma) {
  const consistent = Uint8Array.from(distances, (distance) => (distance <= gamma ? 1 : 0));
  for (let p = 0; p < k; p++) consistent[p * k + p] = 1;
  return consistent;
}

/**
 * Return the closures that are kept: the largest pairwise consistent set.
 *
 * `gamma` is the largest distance of a consistent pair, for instance CHI_99_SE2; `trusted` a mask
 * (m,) of closures that must be in the set. The result is { kept, closures, clique, adjacency,
 * distances }: a mask (m,) of edges, the closures, the places of the kept ones among them, and
 * the matrices (k, k).
 */
export function pcm(graph, gamma, { trusted = null, sharedOdometry = false } = {}) {
  const { closures, distances } = pairwiseDistances(graph, { sharedOdometry });
  const adjacency = consistentPairs(distances, closures.length, gamma);
  const isFixed = (place) => trusted !== null && trusted[closures[place]];
  const fixed = [...closures.keys()].filter(isFixed);
  const clique = maxClique(adjacency, closures.length, fixed);
  const kept = graph.isOdometry.slice();
  for (const place of clique) kept[closures[place]] = 1;
  return { kept, closures, clique, adjacency, distances };
}

/**
 * Return the vertices, ascending, of a largest clique that contains the vertices `fixed`.
 *
 * `adjacency` (k, k) is symmetric; its diagonal does not matter. Sets of vertices are the bits of
 * a BigInt. Of several largest cliques any one may be returned. Meant for some dozens of
 * vertices.
 *
 * Source: Tomita and Seki 2003, branch and bound with a greedy colouring.
 */
export function maxClique(adjacency, k, fixed = []) {
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
  const free = fixed.reduce((set, v) => set & near[v], (1n << BigInt(k)) - 1n);
  grow([...fixed], free);
  return best.sort((a, b) => a - b);
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

/**
 * Return what the odometry says: trees, sessions, centred poses, the number of each pose along
 * the drive, and the covariance `sums` accumulated from the root to each pose, in the world frame.
 */
function odometryWorld(graph) {
  const session = odometrySessions(graph);
  const roots = sessionRoots(graph, session);
  const length = (k) => (graph.isOdometry[k] ? 1 : Infinity);
  const forest = shortestForest(graph, length, roots);
  const poses = centredPoses(graph, forest);
  const sums = Array.from({ length: graph.n }, () => new Float64Array(9));
  const depth = new Int32Array(graph.n);
  for (const pose of forest.order) {
    const k = forest.edge[pose];
    if (k < 0) continue;
    const parent = forest.parent[pose];
    const own = conjugated(se2Adjoint(poseAt(poses, graph.head[k])), edgeCovariance(graph, k));
    sums[pose] = sumOfBlocks(sums[parent], own);
    depth[pose] = depth[parent] + 1;
  }
  return { session, poses, sums, depth, parent: forest.parent, number: drivenOrder(forest, roots) };
}

/** Return for each pose the smallest pose that odometry connects it to. */
function odometrySessions({ n, m, tail, head, isOdometry }) {
  const session = Int32Array.from({ length: n }, (_, pose) => pose);
  for (let changed = true; changed; ) {
    changed = false;
    for (let k = 0; k < m; k++) {
      if (!isOdometry[k] || session[tail[k]] === session[head[k]]) continue;
      session[tail[k]] = session[head[k]] = Math.min(session[tail[k]], session[head[k]]);
      changed = true;
    }
  }
  return session;
}

/**
 * Return the root of each session, where its drive begins: the pose with the fewest odometry
 * edges, of these one that no odometry edge leads to, of these the smallest.
 */
function sessionRoots({ n, m, tail, head, isOdometry }, session) {
  const rank = new Float64Array(n);
  const entered = new Uint8Array(n);
  for (let k = 0; k < m; k++) {
    if (!isOdometry[k]) continue;
    rank[tail[k]] += 2;
    rank[head[k]] += 2;
    entered[head[k]] = 1;
  }
  const first = new Map();
  for (let pose = 0; pose < n; pose++) {
    rank[pose] += entered[pose];
    const best = first.get(session[pose]);
    if (best === undefined || rank[pose] < rank[best]) first.set(session[pose], pose);
  }
  return [...first.values()];
}

/** Return the place of each pose in depth-first order, smaller poses first. */
function drivenOrder({ parent }, roots) {
  const children = Array.from(parent, () => []);
  parent.forEach((above, pose) => above !== pose && children[above].push(pose));
  const number = new Int32Array(parent.length);
  const stack = [...roots].sort((a, b) => b - a);
  for (let place = 0; stack.length > 0; place++) {
    const pose = stack.pop();
    number[pose] = place;
    stack.push(...children[pose].reverse());
  }
  return number;
}

/** Return the poses along the trees, moved so that their mean position is the origin. */
function centredPoses(graph, forest) {
  const poses = posesAlong(graph, forest);
  const mean = [0, 1].map((axis) => {
    let sum = 0;
    for (let at = axis; at < poses.length; at += 3) sum += poses[at];
    return sum / graph.n;
  });
  for (let at = 0; at < poses.length; at += 3) {
    poses[at] -= mean[0];
    poses[at + 1] -= mean[1];
  }
  return poses;
}

/** Return a closure in the direction of travel: ends, sessions, G, Ad(G⁻¹) and its covariance. */
function displacement(graph, world, edge) {
  let ends = [graph.tail[edge], graph.head[edge]];
  let z = poseAt(graph.measurement, edge);
  let covariance = edgeCovariance(graph, edge);
  if (world.number[ends[0]] > world.number[ends[1]]) {
    // (z Exp(δ))⁻¹ = z⁻¹ Exp(−Ad(z) δ)
    covariance = conjugated(se2Adjoint(z), covariance);
    z = se2Inverse(z);
    ends = [ends[1], ends[0]];
  }
  const [start, end] = ends.map((pose) => poseAt(world.poses, pose));
  const move = se2Compose(se2Compose(start, z), se2Inverse(end));
  return {
    ends,
    sessions: ends.map((pose) => world.session[pose]),
    move,
    adjoint: se2Adjoint(se2Inverse(move)),
    own: conjugated(se2Adjoint(end), covariance),
  };
}

function cycleDistance(world, p, q, sharedOdometry) {
  const error = se2Log(se2Between(q.move, p.move));
  const across = odometryBetween(world, p.ends[0], q.ends[0]);
  let covariance = sumOfBlocks(p.own, q.own);
  covariance = sumOfBlocks(covariance, odometryBetween(world, p.ends[1], q.ends[1]));
  covariance = sumOfBlocks(covariance, conjugated(q.adjoint, across));
  if (sharedOdometry) covariance = sumOfBlocks(covariance, sharedCovariance(world, p, q));
  const weighted = blockTimesVector(inverseOfBlock(covariance), error);
  return Math.sqrt(Math.max(0, error.reduce((sum, one, k) => sum + one * weighted[k], 0)));
}

/** Return the covariance of the odometry between poses a and b of one session. */
function odometryBetween({ sums, ...world }, a, b) {
  const common = sums[commonAncestor(world, a, b)];
  return sums[a].map((entry, k) => entry + sums[b][k] - 2 * common[k]);
}

/** Return W A_qᵀ + A_q W, with W the covariance of the odometry in both parts of the cycle. */
function sharedCovariance(world, p, q) {
  const above = (a, b) => {
    const common = commonAncestor(world, a, b);
    return common < 0 ? new Float64Array(9) : world.sums[common];
  };
  const [[iP, jP], [iQ, jQ]] = [p.ends, q.ends];
  const added = sumOfBlocks(above(jQ, iP), above(jP, iQ));
  const taken = sumOfBlocks(above(jP, iP), above(jQ, iQ));
  const both = productOfBlocks(q.adjoint, added.map((entry, k) => entry - taken[k]));
  return both.map((entry, k) => entry + both[3 * (k % 3) + Math.floor(k / 3)]);
}

/** Return the lowest common ancestor of poses a and b, −1 if they are in different trees. */
function commonAncestor({ parent, depth }, a, b) {
  while (a !== b) {
    if (depth[a] < depth[b]) [a, b] = [b, a];
    if (parent[a] === a) return -1;
    a = parent[a];
  }
  return a;
}

function poseAt(poses, k) {
  return poses.subarray(3 * k, 3 * k + 3);
}

function edgeCovariance(graph, k) {
  return inverseOfBlock(graph.information.subarray(9 * k, 9 * k + 9));
}

function sumOfBlocks(a, b) {
  return a.map((entry, k) => entry + b[k]);
}

/** Return A Σ Aᵀ of 3 × 3 matrices by rows, Σ symmetric. */
function conjugated(a, covariance) {
  const half = productOfBlocks(a, covariance);
  const transposed = a.map((_, k) => a[3 * (k % 3) + Math.floor(k / 3)]);
  return productOfBlocks(half, transposed);
}

function productOfBlocks(a, b) {
  const product = new Float64Array(9);
  for (let row = 0; row < 9; row += 3) {
    for (let column = 0; column < 3; column++) {
      product[row + column] =
        a[row] * b[column] + a[row + 1] * b[column + 3] + a[row + 2] * b[column + 6];
    }
  }
  return product;
}

function blockTimesVector(a, v) {
  return [0, 3, 6].map((row) => a[row] * v[0] + a[row + 1] * v[1] + a[row + 2] * v[2]);
}

/** Return the inverse of a 3 × 3 matrix by rows: its adjugate over its determinant. */
function inverseOfBlock([a, b, c, d, e, f, g, h, i]) {
  const first = e * i - f * h;
  const second = f * g - d * i;
  const third = d * h - e * g;
  const determinant = a * first + b * second + c * third;
  const adjugate = [
    first, c * h - b * i, b * f - c * e,
    second, a * i - c * g, c * d - a * f,
    third, b * g - a * h, a * e - b * d,
  ];
  return Float64Array.from(adjugate, (entry) => entry / determinant);
}
