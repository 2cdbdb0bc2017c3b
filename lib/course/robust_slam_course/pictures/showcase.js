import { boundedNumber } from "../canvas/js/draw/link.js";
import { MAP_LEGEND, putLegend } from "../canvas/js/draw/legend.js";
import { fitAround, nearestPose, posePixels, putDrive, putEdge } from "../canvas/js/draw/map.js";
import { putHandle } from "../canvas/js/draw/handle.js";
import { livePicture } from "../canvas/js/draw/picture.js";
import { letterOf, painted, putRibbon } from "../canvas/js/draw/ribbon.js";
import { twoPanels, WIDE } from "../canvas/js/draw/stage.js";
import { putStrip } from "../canvas/js/draw/strip.js";
import { agreeingClosures } from "../canvas/js/solve/aliasing.js";
import { gnc } from "../canvas/js/solve/graduation.js";
import { irls } from "../canvas/js/solve/loop.js";
import { alignPoses, ate } from "../canvas/js/solve/metrics.js";
import { CHI_99_SE2, graphWithWrong, leastSquares, poseGraphProblem } from "../canvas/js/solve/pose_graph.js";

/**
 * One map, which is that of least squares, of switches or of GNC. The reader drags one end of nine
 * wrong closures along the drive, and the ribbon below keeps how each place ended.
 */
export function render(context) {
  const solved = new Map();
  return livePicture(context, {
    layers: ["ghost", "edges", "drive", "wrong", "strip", "words"],
    controls: [
      { kind: "words", name: "method", label: "Method", options: Object.entries(METHODS) },
      { kind: "words", name: "start", label: "Start from", options: [["squares", "least squares"], ["odometry", "odometry"]] },
    ],
    main: [context.model.get("data").main],
    // Half of the places are tried.
    seen: ({ tried }, _, answer) => tried[Object.keys(answer.tried).at(-1)]?.replaceAll(".", "").length > 24,
    height: (width) => (width < WIDE ? 392 : 380),
    clean: (state, data) => cleanShowcase(state, data, solved),
    solve: (state, data) => solveShowcase(state, data, solved),
    moving: ({ poses, weights }) => Float64Array.from([...poses, ...weights]),
    draw: drawShowcase,
    caption: showcaseCaption,
  });
}

const METHODS = { squares: "Least squares", switches: "Switches", gnc: "GNC" };
const NINE = 9; // wrong closures that agree
const IN_USE = 0.25; // the weight of a switched closure at the 99 % quantile; GNC has only 0 and 1
const AT_MOST = 0.4; // m off the true path, at most

/** What is tried by this method from this start; least squares has none. */
function runOf({ method, start }) {
  return method === "squares" ? method : `${method} ${start}`;
}

function cleanShowcase(state, data, solved) {
  const last = data.truth.length / 3 - NINE;
  const place = boundedNumber(state.place, [0, last], NINE, 0);
  const far = Math.abs(place - data.end) >= 2;
  const moved = { ...state, place: far ? place : data.end + 2 * Math.sign(place - data.end || 1) };
  const run = runOf(moved);
  const letter = letterOf(solveShowcase(moved, data, solved).off > AT_MOST);
  return { ...moved, tried: { ...state.tried, [run]: painted(state.tried[run], last + 1, moved.place, letter) } };
}

/** The map of the method that is chosen, laid over the true path, with the weights of its closures. */
function solveShowcase(state, data, solved) {
  const key = `${state.place} ${runOf(state)}`;
  if (!solved.has(key)) solved.set(key, mapOf(state, data));
  return solved.get(key);
}

function mapOf({ place, method, start }, data) {
  const { truth, end, trusted } = data;
  const graph = graphWithWrong(data, agreeingClosures(truth, [end, place], NINE));
  const problem = poseGraphProblem(graph);
  const from = start === "squares" || method === "squares" ? leastSquares(problem).poses : problem.guess;
  // Switches that are always at their optimum are the kernel of Geman and McClure.
  const { x, weights } = {
    squares: () => ({ x: from, weights: new Float64Array(graph.m).fill(1) }),
    switches: () => irls(problem, "geman-mcclure", CHI_99_SE2, from, { tol: 1e-3, maxIterations: 60 }),
    gnc: () => gnc(problem, CHI_99_SE2, "tls", from, { tol: 1e-4 }),
  }[method]();
  const first = trusted.reduce((sum, value) => sum + value, 0);
  const closures = Array.from({ length: graph.m - first }, (_, k) => [graph.tail[first + k], graph.head[first + k]]);
  const own = weights.slice(first);
  const kept = own.slice(-NINE).reduce((sum, weight) => sum + (weight >= IN_USE), 0);
  return { poses: alignPoses(x, truth), off: ate(x, truth), weights: own, closures, kept };
}

function drawShowcase(scene, view) {
  const { width, height, state, result, data } = view;
  const ribbon = { x: 0, y: height - RIBBON_HEIGHT, width, height: RIBBON_HEIGHT };
  const [left, strip] = twoPanels({ x: 0, y: 0, width, height: height - RIBBON_HEIGHT }, [1.7, 1], 0.66);
  const top = putLegend(scene, "words", "legend", left.x, left.y, left.width, MAP_LEGEND);
  const poses = view.shown.subarray(0, data.truth.length);
  const weights = view.shown.subarray(data.truth.length);
  const box = { ...left, y: left.y + top, height: left.height - top };
  const map = fitAround(scene, "map", box, data.truth, result.poses);
  putDrive(scene, "ghost", "truth", map, data.truth, "is-ghost");
  putDrive(scene, "drive", "map", map, poses, "is-estimate");
  result.closures.forEach((edge, k) => {
    const wrong = k >= weights.length - NINE;
    const look = weights[k] < IN_USE ? "is-rejected" : wrong ? "is-outlier" : "is-inlier";
    putEdge(scene, wrong ? "wrong" : "edges", `edge-${k}`, map, wrong ? data.truth : poses, edge, look,
      wrong && k === weights.length - NINE ? 3 : 1.5);
  });
  const [cx, cy] = posePixels(map, data.truth, data.end);
  putOtherEnd(scene, "end", cx, cy);
  putWeights(scene, strip, weights);
  putTried(scene, ribbon, view);
  putWrongEnd(scene, map, view);
}

function putWeights(scene, box, weights) {
  const bars = (from, to, look) => Array.from(weights.subarray(from, to), (value, k) => (
    { value, look, part: `edge-${from + k}` }));
  const correct = weights.length - NINE;
  putStrip(scene, "strip", "weights", box, [
    { name: `${correct} correct`, share: correct, bars: bars(0, correct, "is-inlier") },
    { name: `${NINE} wrong`, share: NINE, bars: bars(correct, weights.length, "is-outlier") },
  ], { domain: [0, 1], ticks: [0, 0.5, 1], label: "weight", linear: true });
}

const RIBBON_HEIGHT = 66; // pixels

/** What was tried along the drive, and faint what was tried from the other start; the circle is the other end. */
function putTried(scene, { x, y, width }, view) {
  const { state: { method, start, tried, place }, data: { end } } = view;
  const other = runOf({ method, start: start === "squares" ? "odometry" : "squares" });
  const ribbon = tried[runOf({ method, start })];
  const each = width / ribbon.length;
  const free = (letters) => [...letters].map((letter, k) => (Math.abs(k - end) < 2 ? " " : letter)).join("");
  putRibbon(scene, "strip", "tried", { x, y: y + 24, width, height: 16 }, free(ribbon));
  if (other !== method && tried[other]) {
    putRibbon(scene, "strip", "other", { x, y: y + 43, width, height: 8 }, free(tried[other]), true);
  }
  for (let pose = 0; pose < ribbon.length; pose += 10) {
    scene.text("words", `pose-${pose}`, x + (pose + 0.5) * each, y + 64, `${pose}`, "rs-tick", pose ? "middle" : "start");
  }
  putOtherEnd(scene, "end-tried", x + (end + 0.5) * each, y + 32);
  putPlace(scene, "strip", "Wrong closures, place along the drive", [x + (place + 0.5) * each, y + 14], view,
    (px) => Math.floor((px - x) / each));
  const count = (letter) => [...ribbon].filter((one) => one === letter).length;
  const words = `${width < WIDE ? "" : "The drive: "}${count(letterOf(true))} lost of ${ribbon.replaceAll(".", "").length} tried`;
  const right = (place + 0.5) * each < width / 2;
  scene.text("words", "tried", right ? x + width : x, y + 13, words, "rs-tick", right ? "end" : "start");
}

function putOtherEnd(scene, key, cx, cy) {
  scene.put("wrong", key, "circle", { class: "rs-open is-outlier", cx, cy, r: 5, style: "stroke-dasharray:none" });
}

function putWrongEnd(scene, map, view) {
  const { data: { truth, end }, state: { place } } = view;
  putPlace(scene, "place", "Wrong closures, moved end", posePixels(map, truth, place), view, (px, py) => nearestPose(
    truth, map.fromX(px), map.fromY(py), place, (k) => k <= truth.length / 3 - NINE && Math.abs(k - end) >= 2,
  ));
}

/** A handle that moves the nine to the place `under` the pointer. */
function putPlace(scene, key, label, [x, y], { data, state, change }, under) {
  const last = data.truth.length / 3 - NINE;
  const move = (place) => change({ place: Math.min(last, Math.max(0, place)) });
  putHandle(scene, key, {
    x, y, shape: "diamond", look: "rs-wrong", label,
    text: `pose ${state.place}`, now: state.place, least: 0, most: last,
    drag: (px, py) => move(under(px, py)),
    step: (right, up) => {
      const to = state.place + (right || up);
      // Past the other end, on to the first pose on its far side.
      move(Math.abs(to - data.end) < 2 ? data.end + 2 * Math.sign(right || up) : to);
    },
  });
}

function showcaseCaption({ state, result: { kept, off } }) {
  const [name, end] = [METHODS[state.method], `${off.toFixed(2)}\u00a0m off.`];
  const [s, its] = state.method === "switches" ? ["", "their"] : ["s", "its"];
  const where = `with the diamond at pose ${state.place}`;
  const who = kept === NINE ? "the nine" : `${kept} of the nine`;
  if (!kept) return `${name} reject${s} the nine ${where}, and ${its} map stays on the path, ${end}`;
  if (off > AT_MOST) return `${name} follow${s} ${who} ${where}, and they bend ${its} map: it is ${end}`;
  return `${name} keep${s} ${who} ${where}, but they hardly bend ${its} map: it is ${end}`;
}
