/**
 * Distributed GNC-TLS for a few robots in the plane, each with its own poses.
 *
 * In a round one robot after another takes a step on its own poses while the boundary, the poses
 * at the other end of shared edges, is fixed; then it sends its side of the boundary to its
 * neighbours. Every few rounds the weights follow. The robot of its first end weighs a shared
 * edge.
 *
 * Source: as `robust_slam.fleet`: Tian et al. 2022, with the schedule of Yang et al. 2020.
 */
import { congruentBlock, transposedBlock } from "./blocks.js";
import { gncTlsRule } from "./graduation.js";
import { STOP } from "./loop.js";
import { deadReckoning, graphResidualNorms, makeGraph, poseGraphProblem } from "./pose_graph.js";
import { poseOf, se2Adjoint, se2Between, se2Compose, se2Inverse, se2Log } from "./se2.js";

/**
 * Run GNC-TLS with the scale `c` on a fleet; `labels` (n,) name the robot of each pose, from 0.
 *
 * The odometry of a robot must join its poses, and shared edges must join all robots. Each μ lasts
 * `every` rounds; when each weight is 0 or 1, rounds follow until no pose moves by `tol` (m, rad).
 * Returns { rounds, stop }. A round is { poses (3n), weights (m,), mu, numbers }: poses in the
 * frame of pose 0, and how many numbers were sent so far. Round 0 is the start, when the robots have
 * met.
 */
export function solveFleet(graph, labels, c, options = {}) {
  const { factor = 1.4, every = 2, tol = 1e-6, maxRounds = 2000 } = options;
  const [rule, fleet] = [gncTlsRule(c, factor), makeFleet(graph, labels)];
  meetFleet(fleet);
  recordRound(fleet, null);
  const worst = largestWord(fleet, fleet.robots.map((robot) => Math.max(0, ...judgedNorms(robot))));
  let mu = rule.start([worst]);
  if (typeof mu === "string") return finishFleet(fleet, mu, null, tol, maxRounds);
  while (!weighFleet(fleet, rule, mu)) {
    if (fleet.rounds.length > maxRounds) return { rounds: fleet.rounds, stop: STOP.iterationLimit };
    descendFleet(fleet, mu, tol, every);
    mu *= factor;
  }
  return finishFleet(fleet, STOP.binaryWeights, mu, tol, maxRounds);
}

function makeFleet(graph, labels) {
  const count = 1 + Math.max(...labels);
  const robots = Array.from({ length: count }, (_, name) => makeRobot(name, graph, labels));
  return { graph, robots, first: robots[labels[0]], numbers: 0, rounds: [] };
}

/** Deliver messages { receiver, poses, weights, word }; tell whether there were any. */
function carryMessages(fleet, messages) {
  for (const { receiver, poses = [], weights = [], word = null } of messages) {
    const robot = fleet.robots[receiver];
    for (const [pose, value] of poses) robot.seen.set(pose, value);
    for (const [edge, weight] of weights) robot.weights[robot.number.indexOf(edge)] = weight;
    fleet.numbers += 3 * poses.length + weights.length + (word === null ? 0 : 1);
  }
  return messages.length > 0;
}

/** Return the largest of one number of each robot, after all robots exchanged theirs. */
function largestWord(fleet, words) {
  const receivers = [...words.keys()];
  carryMessages(fleet, words.flatMap((word, sender) => (
    receivers.filter((k) => k !== sender).map((receiver) => ({ receiver, word })))));
  return Math.max(...words);
}

/** Bring the maps into one frame, one by one, always the robot with the best vote next. */
function meetFleet(fleet) {
  carryMessages(fleet, tellBoundary(fleet.first));
  let waiting = fleet.robots.filter((robot) => robot !== fleet.first);
  while (waiting.length > 0) {
    const votes = new Map(waiting.filter((robot) => robot.seen.size > 0)
      .map((robot) => [robot, frameVote(robot)]));
    largestWord(fleet, fleet.robots.map((robot) => -(votes.get(robot)?.apart ?? Infinity)));
    const best = [...votes.keys()].reduce((one, other) => (
      votes.get(other).apart < votes.get(one).apart ? other : one));
    const { frame } = votes.get(best);
    best.own.forEach((_, k) => best.poses.set(se2Compose(frame, ownPose(best, k)), 3 * k + 3));
    carryMessages(fleet, tellBoundary(best));
    waiting = waiting.filter((robot) => robot !== best);
  }
}

/** Let each robot weigh its edges; tell whether every weight is 0 or 1. */
function weighFleet(fleet, rule, mu) {
  for (const robot of fleet.robots) carryMessages(fleet, weighEdges(robot, rule, mu));
  const open = fleet.robots.map((robot) => Number(robot.weights.some((w) => w > 0 && w < 1)));
  return largestWord(fleet, open) === 0;
}

/** Run up to `count` rounds; tell whether no pose moved by `tol` in the last. */
function descendFleet(fleet, mu, tol, count) {
  for (let round = 0; round < count; round++) {
    const moved = fleet.robots.map((robot) => Number(carryMessages(fleet, improveRobot(robot, tol))));
    const converged = largestWord(fleet, moved) === 0;
    recordRound(fleet, mu);
    if (converged) return true;
  }
  return false;
}

function finishFleet(fleet, stop, mu, tol, count) {
  const converged = descendFleet(fleet, mu, tol, count);
  return { rounds: fleet.rounds, stop: converged ? stop : STOP.iterationLimit };
}

/** Record the poses and weights of all robots, which no robot knows. */
function recordRound({ graph, robots, rounds, numbers }, mu) {
  const poses = new Float64Array(3 * graph.n);
  const weights = new Float64Array(graph.m).fill(1);
  for (const robot of robots) {
    robot.own.forEach((pose, k) => poses.set(ownPose(robot, k), 3 * pose));
    robot.number.forEach((edge, k) => { weights[edge] = robot.weights[k]; });
  }
  const frame = poses.slice(0, 3);
  for (let at = 0; at < poses.length; at += 3) {
    poses.set(se2Between(frame, poses.subarray(at, at + 3)), at);
  }
  rounds.push({ poses, weights, mu, numbers });
}

/**
 * Return one robot: its `own` poses, the numbers of its edges (own ones, then from `shared` on
 * those to a neighbour), the boundary poses that it has `seen`, and the `problem` of its own
 * poses. In that problem pose 0 is the common frame and pose k + 1 is the own pose k. A shared
 * edge measures an own pose in the frame, and the last edge holds the first pose where no shared
 * edge counts.
 */
function makeRobot(name, graph, labels) {
  const { tail, head } = graph;
  const touches = (k) => Number(labels[tail[k]] === name) + Number(labels[head[k]] === name);
  const edges = Array.from({ length: graph.m }, (_, k) => k);
  const inner = edges.filter((k) => touches(k) === 2);
  const number = [...inner, ...edges.filter((k) => touches(k) === 1)];
  const own = Array.from(labels, (_, pose) => pose).filter((pose) => labels[pose] === name);
  const placeOf = new Map(own.map((pose, k) => [pose, k]));
  const shared = number.slice(inner.length).map((k) => sharedEdge(graph, k, labels[tail[k]] === name));
  const robot = {
    name, own, number, placeOf, shared, firstShared: inner.length,
    judged: number.map((k) => labels[tail[k]] === name && !graph.isOdometry[k]),
    neighbour: shared.map(({ outside }) => labels[outside]),
    weights: new Float64Array(number.length).fill(1),
    seen: new Map(),
  };
  robot.problem = ownProblem(robot, graph, inner);
  return robot;
}

/** Return a shared edge directed inwards: its ends, measurement z and information. */
function sharedEdge(graph, k, begins) {
  const [z, information] = [graph.measurements[k], graph.information[k]];
  const [outside, inside] = begins ? [graph.head[k], graph.tail[k]] : [graph.tail[k], graph.head[k]];
  if (!begins) return { outside, inside, z, information };
  // Log(z⁻¹ x_i⁻¹ x_j) is −Ad(z⁻¹) Log(z x_j⁻¹ x_i), so the whitened norm is unchanged.
  const back = se2Inverse(z);
  const turned = congruentBlock(transposedBlock(se2Adjoint(back)), information);
  return { outside, inside, z: back, information: turned };
}

/** Return the problem of the robot's own poses, and start them at its dead reckoning. */
function ownProblem(robot, graph, inner) {
  const ends = inner.map((k) => [graph.tail[k], graph.head[k]].map((pose) => robot.placeOf.get(pose)));
  const [measurements, information] = [graph.measurements, graph.information]
    .map((rows) => inner.map((k) => rows[k]));
  const trusted = inner.map((k) => graph.isOdometry[k]);
  const parts = { measurements, information, trusted };
  const alone = makeGraph({ poses: robot.own.length, edges: ends, ...parts });
  robot.poses = Float64Array.from([0, 0, 0, ...deadReckoning(alone)]);
  const edges = [
    ...ends.map(([i, j]) => [i + 1, j + 1]),
    ...robot.shared.map(({ inside }) => [0, robot.placeOf.get(inside) + 1]),
    [0, 1],
  ];
  const block = makeGraph({
    poses: robot.own.length + 1,
    edges,
    measurements: [...measurements, ...robot.shared.map(({ z }) => z), [0, 0, 0]],
    information: [...information, ...robot.shared.map((edge) => edge.information), [1, 0, 0, 0, 1, 0, 0, 0, 1]],
    trusted: edges.map(() => 1),
  });
  return poseGraphProblem(block, { guess: robot.poses, tol: 1e-9 });
}

function ownPose(robot, k) {
  return poseOf(robot.poses, k + 1);
}

/** Place the shared measurements of the robot's problem in the common frame. */
function placeBoundary(robot) {
  const { inverses } = robot.problem.graph;
  robot.shared.forEach(({ outside, z }, k) => {
    inverses[robot.firstShared + k] = se2Inverse(se2Compose(robot.seen.get(outside), z));
  });
  inverses[robot.number.length] = se2Inverse(ownPose(robot, 0));
}

/** Return a message to each neighbour with the poses on this side of the boundary. */
function tellBoundary(robot) {
  return [...new Set(robot.neighbour)].sort((a, b) => a - b).map((receiver) => {
    const border = new Set(robot.shared.filter((_, k) => robot.neighbour[k] === receiver)
      .map(({ inside }) => inside));
    const poses = [...border].map((pose) => [pose, ownPose(robot, robot.placeOf.get(pose))]);
    return { receiver, poses };
  });
}

/**
 * Return how well the shared edges agree on the robot's frame, `apart` (m), and the best `frame`.
 *
 * The disagreement of an edge is the mean distance between the own poses in its frame and in that
 * of the second closest other edge: three edges have to agree. It is Infinity for fewer.
 */
function frameVote(robot) {
  const frames = robot.shared.filter(({ outside }) => robot.seen.has(outside))
    .map(({ outside, inside, z }) => se2Compose(
      se2Compose(robot.seen.get(outside), z),
      se2Inverse(ownPose(robot, robot.placeOf.get(inside))),
    ));
  if (frames.length < 3) return { apart: Infinity, frame: frames[0] };
  const placed = frames.map((frame) => robot.own.map((_, k) => se2Compose(frame, ownPose(robot, k))));
  const votes = placed.map((poses) => placed.map((others) => meanDistance(poses, others))
    .sort((a, b) => a - b)[2]);
  const apart = Math.min(...votes);
  return { apart, frame: frames[votes.indexOf(apart)] };
}

function meanDistance(poses, others) {
  const sum = poses.reduce((all, [x, y], k) => all + Math.hypot(x - others[k][0], y - others[k][1]), 0);
  return sum / poses.length;
}

/** Return the whitened residual norms of the edges that this robot weighs. */
function judgedNorms(robot) {
  placeBoundary(robot);
  const norms = graphResidualNorms(robot.problem.graph, robot.poses);
  return robot.judged.flatMap((judged, k) => (judged ? [norms[k]] : []));
}

/** Take one step on the own poses; return the boundary after a move of more than `tol`. */
function improveRobot(robot, tol) {
  placeBoundary(robot);
  const lone = !robot.weights.subarray(robot.firstShared).some((w) => w > 0);
  const better = robot.problem.solve(Float64Array.from([...robot.weights, Number(lone)]), robot.poses);
  let most = 0;
  for (let at = 3; at < better.length; at += 3) {
    const moved = se2Log(se2Between(poseOf(robot.poses, at / 3), poseOf(better, at / 3)));
    most = Math.max(most, ...moved.map(Math.abs));
  }
  // Steps below tol are dropped, so neighbours keep exact boundary poses.
  if (most <= tol) return [];
  robot.poses = better;
  return tellBoundary(robot);
}

/** Compute the weights of this robot's edges; return the shared weights that changed. */
function weighEdges(robot, rule, mu) {
  const norms = judgedNorms(robot);
  const told = new Map();
  let judgement = 0;
  robot.number.forEach((edge, k) => {
    if (!robot.judged[k]) return;
    const weight = rule.weight(norms[judgement++], mu);
    const changed = weight !== robot.weights[k];
    robot.weights[k] = weight;
    if (!changed || k < robot.firstShared) return;
    const receiver = robot.neighbour[k - robot.firstShared];
    told.set(receiver, [...(told.get(receiver) ?? []), [edge, weight]]);
  });
  return [...told].map(([receiver, weights]) => ({ receiver, weights }));
}
