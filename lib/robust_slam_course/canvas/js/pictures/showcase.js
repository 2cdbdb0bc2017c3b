import { numberText, putAxes, putCurve, putPath } from "../draw/axes.js";
import { boundedNumber } from "../draw/link.js";
import { audiblePicture } from "../draw/listen.js";
import { fitAround, putClosureHandles, putDrive, putEdge } from "../draw/map.js";
import { sideBySide, stageHeight, WIDE } from "../draw/stage.js";
import { agreeingClosures } from "../solve/aliasing.js";
import { gnc } from "../solve/graduation.js";
import { KERNELS } from "../solve/kernels.js";
import { irls } from "../solve/loop.js";
import { alignPoses, ate } from "../solve/metrics.js";
import {
  CHI_99_SE2, graphResidualNorms, graphWithWrong, leastSquares, poseGraphProblem,
} from "../solve/pose_graph.js";

/**
 * One drive and three estimators side by side: least squares, switchable constraints, GNC. The
 * reader moves a wrong closure; below each map stand the weights of all closures over their
 * residuals, on the curve of that estimator.
 */
export function render(context) {
  return audiblePicture(context, {
    layers: ["ghost", "edges", "drive", "wrong", "words", "axes", "curve", "points"],
    controls: [
      {
        kind: "slider", name: "size", label: "Wrong closures", min: 1, max: MOST_AGREEING, step: 1,
        text: String,
      },
      {
        kind: "choice", name: "start", label: "Start from",
        options: [["squares", "least squares"], ["odometry", "odometry"]],
      },
    ],
    main: [context.model.get("data").main ?? "size"],
    height: (width) => (width < WIDE ? 402 : stageHeight(width)),
    clean: cleanShowcase,
    solve: solveShowcase,
    moving: (result) => result.numbers,
    draw: drawShowcase,
    caption: showcaseCaption,
  });
}

const MOST_AGREEING = 9;
const ESTIMATORS = [
  { key: "squares", name: "Least squares", weight: () => 1 },
  { key: "switches", name: "Switches", weight: (u) => KERNELS["geman-mcclure"].weight(u, CHI_99_SE2) },
  { key: "gnc", name: "GNC", weight: (u) => (u <= CHI_99_SE2 ? 1 : 0) },
];
const IN_USE = 0.25; // the weight of a switched closure at the 99 % quantile; GNC has only 0 and 1
const chartHeight = (width) => (width < WIDE ? 62 : 142); // pixels
const HEAD = 22; // pixels above a map

/** Where the maps stand, over their charts; where the page is narrow the first one has a row and no chart. */
function cellsOf(width, height) {
  const below = chartHeight(width);
  if (width >= WIDE) return sideBySide({ x: 0, y: 0, width, height: height - below }, [1, 1, 1]);
  const top = height / 2;
  const second = { x: 0, y: top, width, height: height - top - below };
  return [{ x: 0, y: 0, width, height: top }, ...sideBySide(second, [1, 1])];
}

function cleanShowcase(state, data) {
  const count = data.truth.length / 3;
  const inside = (pose, instead) => boundedNumber(pose, [0, count - state.size], instead, 0);
  let [i, j] = [inside(state.wrong[0], 42), inside(state.wrong[1], 9)];
  if (Math.abs(i - j) < 2) [i, j] = i > 1 ? [i, i - 2] : [i, i + 2];
  return { ...state, wrong: [i, j] };
}

/** The three maps, each laid over the true path, with the norms and weights of the closures. */
function solveShowcase(state, data) {
  const graph = graphWithWrong(data, agreeingClosures(data.truth, state.wrong, state.size));
  const problem = poseGraphProblem(graph);
  const squares = leastSquares(problem).poses;
  const start = state.start === "squares" ? squares : problem.guess;
  // Switches that are always at their optimum are the kernel of Geman and McClure.
  const switched = irls(problem, "geman-mcclure", CHI_99_SE2, start, { tol: 1e-3, maxIterations: 60 });
  const graduated = gnc(problem, CHI_99_SE2, "tls", start, { tol: 1e-4 });
  const { truth } = data;
  const first = data.trusted.reduce((sum, value) => sum + value, 0);
  const weights = [new Float64Array(graph.m).fill(1), switched.weights, graduated.weights];
  const answers = [squares, switched.x, graduated.x].map((poses, k) => ({
    poses: alignPoses(poses, truth), off: ate(poses, truth),
    norms: graphResidualNorms(graph, poses).slice(first), weights: weights[k].slice(first),
  }));
  const numbers = Float64Array.from(answers.flatMap(({ poses, norms, weights: own }) => [
    ...poses, ...norms.map((norm) => Math.log10(Math.max(norm, 0.1))), ...own,
  ]));
  const heard = { graph, poses: answers[2].poses, weights: graduated.weights, map: "gnc", of: "GNC’s map: " };
  return { answers, numbers, heard, first, correct: data.edges.length - first, edges: edgesOf(graph) };
}

function edgesOf(graph) {
  return Array.from({ length: graph.m }, (_, k) => [graph.tail[k], graph.head[k]]);
}

function drawShowcase(scene, view) {
  const boxes = cellsOf(view.width, view.height);
  const each = view.shown.length / 3;
  const poses = view.data.truth.length;
  const closures = (each - poses) / 2;
  ESTIMATORS.forEach((estimator, k) => {
    const shown = view.shown.subarray(k * each, (k + 1) * each);
    const parts = {
      poses: shown.subarray(0, poses),
      norms: shown.subarray(poses, poses + closures),
      weights: shown.subarray(poses + closures),
    };
    drawEstimator(scene, view, estimator, view.result.answers[k], parts, boxes[k]);
    if (k || view.width >= WIDE) drawWeights(scene, view, estimator, parts, boxes[k]);
  });
  const map = showcaseMap(scene, ESTIMATORS[0].key, boxes[0], view.data.truth, view.result.answers[0].poses);
  const edit = ([wrong]) => view.change({ wrong });
  putClosureHandles(scene, map, view.data.truth, [view.state.wrong], edit, { noun: "Wrong closure", removable: false });
}

function showcaseMap(scene, key, { x, y, width, height }, truth, poses) {
  return fitAround(scene, key, { x, y: y + HEAD, width, height: height - HEAD }, truth, poses);
}

function drawEstimator(scene, view, { key, name }, answer, parts, box) {
  const { result, data } = view;
  const map = showcaseMap(scene, key, box, data.truth, answer.poses);
  const head = `${name}: ${answer.off.toFixed(2)} m off`;
  scene.text("words", `${key}-name`, box.x + 0.5 * box.width, box.y + 14, head, "rs-head", "middle");
  putDrive(scene, "ghost", `${key}-truth`, map, data.truth, "is-ghost");
  putDrive(scene, "drive", key, map, parts.poses, "is-estimate");
  answer.weights.forEach((weight, k) => {
    const edge = result.edges[result.first + k];
    const used = weight >= IN_USE;
    if (k < result.correct) {
      putEdge(scene, "edges", `${key}-${k}`, map, parts.poses, edge, used ? "is-inlier" : "is-rejected");
    } else {
      const width = k === result.correct ? 3 : 1.5;
      putEdge(scene, "wrong", `${key}-${k}`, map, data.truth, edge, used ? "is-outlier" : "is-rejected", width);
    }
  });
}

const CROSS = "m-4.5 -4.5l9 9m0 -9l-9 9";
const RING = "m-4 0a4 4 0 1 0 8 0a4 4 0 1 0 -8 0";

/** The weights of the closures over their residuals, circles for correct ones, crosses for wrong. */
function drawWeights(scene, { result, width }, { key, weight }, parts, box) {
  const place = { x: box.x, y: box.y + box.height, width: box.width, height: chartHeight(width) };
  const [label, ticks] = width < WIDE ? ["", [0, 1]] : ["weight", [0, 0.5, 1]];
  const domain = [-1.05, 2.08];
  const maps = putAxes(
    scene, "axes", key, place,
    { domain, ticks: [-1, 0, 1, 2], label: label && "residual u", text: (power) => numberText(10 ** power) },
    { domain: [-0.06, 1.12], ticks, label },
  );
  const look = { class: "is-muted", "stroke-width": 1.5 };
  if (key === "switches") putCurve(scene, "curve", `${key}-w`, maps, domain, (power) => weight(10 ** power), look, 60);
  else {
    const knee = key === "gnc" ? Math.log10(CHI_99_SE2) : domain[1];
    const corners = [[domain[0], 1], [knee, 1], [knee, weight(100)], [domain[1], weight(100)]];
    putPath(scene, "curve", `${key}-w`, maps, corners.map(([x, y]) => [maps.toX(x), maps.toY(y)]), look);
  }
  const marks = (from, to, mark) => Array.from({ length: to - from }, (_, k) => {
    const x = maps.toX(Math.min(domain[1], parts.norms[from + k]));
    return `M${x.toFixed(1)} ${maps.toY(parts.weights[from + k]).toFixed(1)}${mark}`;
  }).join("");
  const solid = "stroke-dasharray:none";
  scene.put("points", `${key}-right`, "path", {
    class: "is-inlier", "stroke-width": 1.8, style: solid, d: marks(0, result.correct, RING),
  });
  scene.put("points", `${key}-wrong`, "path", {
    class: "is-outlier", "stroke-width": 2.2, style: solid, d: marks(result.correct, parts.norms.length, CROSS),
  });
}

function showcaseCaption({ state, result }) {
  const inUse = (from, to) => result.answers.map(({ weights }) => weights.slice(from, to)
    .reduce((sum, weight) => sum + (weight >= IN_USE), 0));
  const off = result.answers.map((answer) => answer.off.toFixed(2));
  const [right, wrong] = [inUse(0, result.correct), inUse(result.correct, result.correct + state.size)];
  return `Least squares uses all and is ${off[0]}\u00a0m off. Switches use ${wrong[1]} of ${state.size} wrong and `
    + `${right[1]} of ${result.correct} correct closures and are ${off[1]}\u00a0m off; GNC ${wrong[2]} and ${right[2]}, ${off[2]}\u00a0m.`;
}
