import { KERNELS } from "../canvas/js/solve/kernels.js";
import { majoriser, sampledCost } from "../canvas/js/solve/landscapes.js";
import { locationProblem } from "../canvas/js/solve/location.js";
import { irls, STOP } from "../canvas/js/solve/loop.js";
import { putAxes, putCurve } from "../canvas/js/draw/axes.js";
import { numberText } from "../canvas/js/draw/number.js";
import { putHandle } from "../canvas/js/draw/handle.js";
import { putMarker } from "../canvas/js/draw/marker.js";
import { putLegend } from "../canvas/js/draw/legend.js";
import { boundedNumber } from "../canvas/js/draw/link.js";
import { livePicture } from "../canvas/js/draw/picture.js";
import { letterOf, painted, putRibbon } from "../canvas/js/draw/ribbon.js";
import { pathThrough } from "../canvas/js/draw/scene.js";

/**
 * IRLS from a start that the reader drags: the weights there, the cost with the parabola that touches
 * it, and where the steps lead. The ribbon keeps where each start that was tried ended.
 */
export function render(context) {
  const { kernels } = context.model.get("data");
  return livePicture(context, {
    layers: ["axes", "curves", "steps", "words"],
    controls: [
      { kind: "words", name: "kernel", label: "Kernel", options: kernels.map((name) => [name, KERNELS[name].label]) },
      { kind: "slider", name: "sigma", label: "Noise σ", min: 0.1, max: 1.5, step: 0.05, text: (sigma) => `σ = ${sigma.toFixed(2)}` },
    ],
    main: ["kernel"],
    clean: cleanMajoriser,
    solve: solveMajoriser,
    draw: drawMajorisers,
    caption: majoriserCaption,
  });
}

const [WEIGHTS_HEIGHT, STARTS_HEIGHT] = [100, 30]; // pixels
const AXIS_RANGE = [-1, 7.5];
const START_RANGE = [-0.9, 7.4];
const START_STEP = 0.1;
const NEAR_INLIERS = 1; // how far from 0 an estimate may be

function cleanMajoriser(state, data) {
  const start = boundedNumber(state.start, START_RANGE, 5, 1);
  const key = triedKey(state);
  const { path } = solveMajoriser({ ...state, start }, data);
  const letter = letterOf(Math.abs(path.at(-1)) > NEAR_INLIERS);
  const count = Math.round((START_RANGE[1] - START_RANGE[0]) / START_STEP) + 1;
  const at = Math.round((start - START_RANGE[0]) / START_STEP);
  return { ...state, start, tried: { ...state.tried, [key]: painted(state.tried[key], count, at, letter) } };
}

function triedKey({ kernel, sigma }) {
  return `${kernel} ${sigma}`;
}

function solveMajoriser({ kernel, start, sigma }, { readings, c }) {
  const { history, stop } = irls(locationProblem(readings, sigma), kernel, c, start, { tol: 1e-4, maxIterations: 60 });
  // A step that rejects every reading moves nothing.
  const path = history.slice(0, stop === STOP.allRejected ? -1 : undefined).map(({ x }) => x);
  const cost = (x) => readings.reduce((sum, z) => sum + KERNELS[kernel].rho((x - z) / sigma, c), 0);
  const heights = sampledCost(readings, sigma, (u) => KERNELS[kernel].rho(u, c), AXIS_RANGE, 341);
  return {
    path, cost, parabola: majoriser(readings, sigma, kernel, c, start), top: 1.12 * Math.max(...heights),
  };
}

function drawMajorisers(scene, view) {
  const { width, height, state, result } = view;
  const upper = putAxes(
    scene, "axes", "weights", { x: 0, y: 0, width, height: WEIGHTS_HEIGHT },
    { domain: AXIS_RANGE, label: "", ticks: [] }, { domain: [-0.1, 1.12], label: "weight w", ticks: [0, 0.5, 1] },
  );
  const { inner } = upper;
  const legend = putLegend(scene, "words", "legend", inner.x, WEIGHTS_HEIGHT - 16, inner.width, [
    ["is-muted", "weight"], ["is-ink", "cost"], ["is-accent", "majoriser"], ["is-estimate", "steps"],
  ]);
  const y = WEIGHTS_HEIGHT - 20 + legend;
  const lower = putAxes(
    scene, "axes", "cost", { x: 0, y, width, height: height - y - STARTS_HEIGHT },
    { domain: AXIS_RANGE, label: "estimate x" }, { domain: [0, result.top], label: "cost" },
  );
  const x = upper.toX(state.start);
  const at = [upper, lower].map(({ inner }) => `M${x} ${inner.y}v${inner.height}`).join("");
  scene.path("axes", "at", "rs-edge is-estimate", at);
  drawWeightBell(scene, upper, view);
  drawCostAndParabola(scene, lower, view);
  const [left, right] = START_RANGE.map((end) => lower.toX(end));
  const half = lower.toX(START_STEP / 2) - lower.toX(0);
  putRibbon(scene, "steps", "tried", {
    x: left - half, y: height - 18, width: right - left + 2 * half, height: 16,
  }, state.tried[triedKey(state)]);
  scene.text("words", "tried-name", left - half - 6, height - 4, "ends", "rs-tick", "end");
}

/** The weight that a reading at z has at the start, as a curve, and of each reading. */
function drawWeightBell(scene, axes, { state, result, data }) {
  const bell = (z) => KERNELS[state.kernel].weight((z - state.start) / state.sigma, data.c);
  putCurve(scene, "curves", "bell", axes, AXIS_RANGE, bell, { class: "rs-line is-muted" }, 340);
  const floor = axes.toY(0);
  data.readings.forEach((z, k) => {
    const wrong = k === data.readings.length - 1;
    const [x, y] = [axes.toX(z), axes.toY(result.parabola.weights[k])];
    const d = `M${x.toFixed(1)} ${floor.toFixed(1)}V${y.toFixed(1)}`;
    scene.path("steps", `weight-${k}`, `rs-bar ${wrong ? "is-outlier" : "is-inlier"}`, d, wrong ? 5 : 3);
    putMarker(scene, "steps", `weight-top-${k}`, x, y, wrong ? "diamond" : "circle", wrong ? "outlier" : "inlier");
  });
}

function drawCostAndParabola(scene, axes, { state, result, change }) {
  const { cost, path, parabola: { lowest, value } } = result;
  const { start } = state;
  const pixels = (x, f) => [axes.toX(x), axes.toY(f(x))];
  putCurve(scene, "curves", "cost-curve", axes, AXIS_RANGE, cost, { class: "rs-line is-ink" }, 340);
  putCurve(scene, "curves", "parabola", axes, AXIS_RANGE, value, { class: "rs-line is-accent" }, 200);
  const walked = path.map((x) => pixels(x, cost));
  scene.path("steps", "walked", "rs-edge is-estimate", pathThrough(walked), 1.5);
  walked.forEach(([x, y], k) => putMarker(scene, "steps", `walked-${k}`, x, y, "circle", "estimate"));
  if (lowest !== null) {
    const [x, y] = pixels(lowest, value);
    scene.path("steps", "down", "rs-edge is-ghost", `M${x} ${y}V${axes.toY(cost(lowest))}`);
    putMarker(scene, "steps", "lowest", x, y, "diamond", "accent");
  }
  const [x, y] = pixels(start, cost);
  putHandle(scene, "start", {
    x, y, shape: "circle", label: "Start", text: start.toFixed(1),
    now: start, least: START_RANGE[0], most: START_RANGE[1], unit: START_STEP,
    drag: (px) => change({ start: axes.fromX(px) }),
    step: (right, up) => change({ start: start + START_STEP * (right || up) }),
  });
}

function majoriserCaption({ state, result: { path, cost, parabola } }) {
  const fixed = (x) => numberText(Number(x.toFixed(2)), 4);
  const name = KERNELS[state.kernel].label;
  if (parabola.lowest === null) {
    return `${name}: at ${fixed(state.start)} every weight is 0, so the majoriser is flat and IRLS stays.`;
  }
  const end = path.at(-1);
  const where = Math.abs(end) > NEAR_INLIERS ? "away from the inliers" : "among the inliers";
  return `${name}: from ${fixed(state.start)} the first step jumps to ${fixed(parabola.lowest)}, and IRLS ends at`
    + ` ${fixed(end)}, ${where}; the cost falls from ${cost(state.start).toFixed(2)} to ${cost(end).toFixed(2)}.`;
}
