import { fitAround, fitMap, nearestPose, posePixels, putDrive } from "../canvas/js/draw/map.js";
import { putHandle } from "../canvas/js/draw/handle.js";
import { freePlace } from "../canvas/js/draw/labels.js";
import { putLegend } from "../canvas/js/draw/legend.js";
import { possibleJoins } from "../canvas/js/draw/link.js";
import { livePicture } from "../canvas/js/draw/picture.js";
import { pathThrough } from "../canvas/js/draw/scene.js";
import { sideBySide, stageHeight, WIDE } from "../canvas/js/draw/stage.js";
import { solveFleet } from "../canvas/js/solve/fleet.js";
import { CHI_99_SE2, graphWithWrong } from "../canvas/js/solve/pose_graph.js";

/**
 * Three robots that exchange boundary poses: one map of all, and what each of them knows. Robot C
 * shares as many correct closures with the others as the reader chooses, and wrong ones to move.
 */
export function render(context) {
  const cache = { key: null, fleet: null };
  return livePicture(context, {
    layers: ["ghost", "shared", "own", "views", "words"],
    controls: [
      {
        kind: "slider", name: "correct", label: "Correct closures of C", min: 0,
        max: context.model.get("data").withC.length, step: 1, text: String,
      },
      {
        kind: "player", name: "round", label: "Round", count: (_, { last }) => last,
        text: (value, { last }) => `${Math.min(value, last)} of ${last}`,
      },
      { kind: "toggle", name: "views", label: "Show what each robot knows" },
    ],
    main: ["round", "correct"],
    clean: cleanRobots,
    solve: (state, data) => solveRobots(state, data, cache),
    moving: (result) => result.poses,
    // Two controls stand below it, in two rows.
    height: (width) => stageHeight(width) - 36,
    draw: drawRobots,
    caption: robotsCaption,
  });
}

const MOST_ROUNDS = 60;
const ROBOT_NAMES = ["A", "B", "C"];
const ROBOT_LOOKS = ["is-estimate", "is-accent", "is-ink"];

function cleanRobots(state, { labels, wrong: first }) {
  const wrong = possibleJoins(state.wrong, labels.length - 1, 1, 1).filter(([i, j]) => labels[i] === 2 && labels[j] !== 2);
  return { ...state, wrong: wrong.length ? wrong : first };
}

/**
 * The graph with `correct` of the closures of C, and before them a wrong one for each of `wrong`:
 * of two closures, a robot takes its frame from the first.
 */
function meetingGraph(data, correct, wrong) {
  const left = data.withC.slice(correct);
  const used = [...data.edges.keys()].filter((k) => !left.includes(k));
  const first = wrong.map((_, k) => data.edges.length + k);
  return graphWithWrong(data, { edges: wrong }, [...first, ...used]);
}

function solveRobots({ wrong, correct, round }, data, cache) {
  const key = JSON.stringify([wrong, correct]);
  if (cache.key !== key) {
    const graph = meetingGraph(data, correct, wrong);
    const { rounds } = solveFleet(graph, data.labels, CHI_99_SE2, { tol: 1e-3, maxRounds: MOST_ROUNDS });
    Object.assign(cache, { key, fleet: { graph, rounds } });
  }
  const { graph, rounds } = cache.fleet;
  const last = rounds.length - 1;
  const seen = rounds[Math.min(round, last)];
  const [{ poses }, { labels }] = [seen, data];
  const shared = Array.from(graph.tail, (_, k) => k)
    .filter((k) => labels[graph.tail[k]] !== labels[graph.head[k]]);
  const isWrong = (k) => k < wrong.length;
  return { graph, labels, poses, seen, last, shared, isWrong, off: robotOffsets(poses, data) };
}

/** The mean distance (m) of each robot's poses from where they were. */
function robotOffsets(poses, { truth, labels }) {
  return ROBOT_NAMES.map((_, name) => {
    const own = labels.flatMap((label, k) => (label === name ? [3 * k] : []));
    const far = own.map((at) => Math.hypot(poses[at] - truth[at], poses[at + 1] - truth[at + 1]));
    return far.reduce((sum, one) => sum + one, 0) / own.length;
  });
}

/** Where the map of all robots stands, and beside or below it the view of each, if it is shown. */
function robotPanels(width, height, views) {
  const all = { x: 0, y: 0, width, height };
  if (!views) return { all, each: [] };
  if (width < WIDE) {
    const top = 0.68 * height;
    return { all: { ...all, height: top }, each: sideBySide({ ...all, y: top, height: height - top }, [1, 1, 1]) };
  }
  const [left, right] = sideBySide(all, [1.7, 1]);
  const tall = height / 3;
  return { all: left, each: [0, 1, 2].map((k) => ({ ...right, y: k * tall, height: tall - 6 })) };
}

function drawRobots(scene, view) {
  const { state, result, shown, width, height, data, change } = view;
  const panels = robotPanels(width, height, state.views);
  const top = putLegend(scene, "words", "legend", 0, 0, panels.all.width, [
    ["is-ghost", "true paths"], ["is-inlier", "trusted"], ["rs-doubt is-inlier", "in doubt"],
    ["is-rejected", "rejected"], ["is-outlier", "wrong"],
  ]);
  const box = { ...panels.all, y: top, height: panels.all.height - top };
  const map = fitAround(scene, "map", box, data.truth, result.poses);
  for (const layer of ["shared", "own"]) scene.clip(layer, box);
  const handles = state.wrong.flat().map((pose) => posePixels(map, data.truth, pose));
  const points = data.labels.map((_, k) => posePixels(map, shown, k));
  const halfway = points.slice(1).map(([x, y], k) => [(x + points[k][0]) / 2, (y + points[k][1]) / 2]);
  ROBOT_NAMES.forEach((name, k) => {
    putOwnDrive(scene, "ghost", `truth-${k}`, map, data.truth, data.labels, k, "is-ghost");
    putOwnDrive(scene, "own", `map-${k}`, map, shown, data.labels, k, ROBOT_LOOKS[k]);
    putRobotName(scene, `name-${k}`, posePixels(map, shown, data.labels.indexOf(k)), name, box, [...handles, ...points, ...halfway]);
  });
  panels.each.forEach((panel, k) => putRobotView(scene, k, panel, view));
  // A wrong closure is where the reader holds it, on the true paths.
  result.shared.forEach((k) => putMeeting(scene, "shared", `edge-${k}`, map, result.isWrong(k) ? data.truth : shown, result, k));
  putMeetingHandles(scene, map, state, data, change);
}

function putOwnDrive(scene, layer, key, map, poses, labels, robot, look) {
  const own = labels.flatMap((label, k) => (label === robot ? [...poses.slice(3 * k, 3 * k + 3)] : []));
  putDrive(scene, layer, key, map, own, look);
}

/** The name beside the robot's first pose, clear of all in `taken`, and within the map. */
function putRobotName(scene, key, at, name, box, taken) {
  const beside = [[-14, -8], [14, -8], [-14, 16], [14, 16], [0, -20], [0, 20], [-20, 0], [20, 0]].map(([right, down]) => [
    Math.min(box.x + box.width - 8, Math.max(box.x + 8, at[0] + right)),
    Math.min(box.y + box.height - 8, Math.max(box.y + 8, at[1] + down)),
  ]);
  const [x, y] = freePlace(beside, taken, 14);
  scene.text("words", key, x, y + 5, name, "rs-head rs-halo", "middle");
}

/** A shared closure, as its weight and the truth say. */
function putMeeting(scene, layer, key, map, poses, { graph, seen, isWrong }, k) {
  const d = pathThrough([posePixels(map, poses, graph.tail[k]), posePixels(map, poses, graph.head[k])]);
  const weight = seen.weights[k];
  const kept = isWrong(k) ? "is-outlier" : weight < 1 ? "rs-doubt is-inlier" : "is-inlier";
  const look = weight === 0 ? "is-rejected" : kept;
  scene.path(layer, key, `rs-edge ${look}`, d, isWrong(k) ? 3 : 2);
}

/** What robot `name` knows: its own poses, and of the others those that it was sent. */
function putRobotView(scene, name, box, { result, shown, data }) {
  const { graph, shared } = result;
  const { labels } = data;
  const mine = shared.filter((k) => labels[graph.tail[k]] === name || labels[graph.head[k]] === name);
  const sent = [...new Set(mine.flatMap((k) => [graph.tail[k], graph.head[k]]))]
    .filter((pose) => labels[pose] !== name);
  const known = [...labels.flatMap((label, k) => (label === name ? [k] : [])), ...sent];
  const inner = { x: box.x, y: box.y + 20, width: box.width, height: box.height - 20 };
  const map = fitMap(inner, known.flatMap((k) => [...shown.slice(3 * k, 3 * k + 3)]), 14);
  scene.path("views", `view-${name}`, "is-grid", `M${inner.x} ${inner.y}h${inner.width}v${inner.height}h${-inner.width}Z`);
  const count = box.width > 160 ? `${ROBOT_NAMES[name]}: ${known.length - sent.length} own poses, ${sent.length} of others`
    : `${ROBOT_NAMES[name]}: ${known.length - sent.length} + ${sent.length}`;
  scene.text("words", `view-head-${name}`, box.x + 2, box.y + 13, count, "rs-head");
  mine.forEach((k) => putMeeting(scene, "views", `view-${name}-edge-${k}`, map, shown, result, k));
  putOwnDrive(scene, "views", `view-${name}`, map, shown, labels, name, ROBOT_LOOKS[name]);
  for (const pose of sent) {
    const [x, y] = posePixels(map, shown, pose);
    scene.put("views", `view-${name}-sent-${pose}`, "circle", {
      class: `rs-sent ${ROBOT_LOOKS[labels[pose]]}`, cx: x.toFixed(1), cy: y.toFixed(1), r: 4,
    });
  }
}

/** The ends of wrong closures on the true paths: one is a pose of robot C, one of A or B. */
function putMeetingHandles(scene, map, { wrong }, { truth, labels }, change) {
  wrong.forEach((join, number) => {
    join.forEach((pose, end) => {
      const allowed = (k) => (labels[k] === 2) === (end === 0);
      const move = (other) => change({
        wrong: wrong.map((one, k) => (k === number ? one.map((old, at) => (at === end ? other : old)) : one)),
      });
      const [x, y] = posePixels(map, truth, pose);
      const own = labels.flatMap((_, k) => (allowed(k) ? [k] : []));
      putHandle(scene, `meeting-${number}-${end}`, {
        x, y, shape: end ? "diamond" : "circle", look: "rs-wrong",
        label: `Wrong closure ${number + 1}, end ${end ? "at A or B" : "at C"}`,
        text: `pose ${pose} of robot ${ROBOT_NAMES[labels[pose]]}`,
        now: pose, least: own[0], most: own.at(-1),
        drag: (px, py) => move(nearestPose(truth, map.fromX(px), map.fromY(py), pose, allowed)),
        step: (right, up) => move(Math.min(own.at(-1), Math.max(own[0], pose + (right || up)))),
      });
    });
  });
}

function robotsCaption({ state, result }) {
  const { graph, seen, last, shared, isWrong, off, labels } = result;
  const round = Math.min(state.round, last);
  const begin = round ? `After round ${round} of ${last}` : "When the robots have just met";
  const ofC = shared.filter((k) => labels[graph.tail[k]] === 2 || labels[graph.head[k]] === 2);
  const rejected = (wrong) => ofC.filter((k) => isWrong(k) === wrong && seen.weights[k] === 0).length;
  const fate = rejected(true) ? "rejects its wrong closure" : "trusts its wrong closure";
  const lost = rejected(false) ? ` and loses ${rejected(false)} of ${state.correct} correct ones` : "";
  const alone = ofC.length === 1 ? ", which nothing contradicts" : "";
  return `${begin}, C ${fate}${alone}${lost}. It is ${off[2].toFixed(2)}\u00a0m off, and B ${off[1].toFixed(2)}\u00a0m.`;
}
