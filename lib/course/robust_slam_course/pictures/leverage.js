import { KERNELS } from "../canvas/js/solve/kernels.js";
import { lineLeverages, lineProblem } from "../canvas/js/solve/location.js";
import { irls } from "../canvas/js/solve/loop.js";
import { putAxes, putCurve, roundTicks } from "../canvas/js/draw/axes.js";
import { numberText } from "../canvas/js/draw/number.js";
import { putHandle } from "../canvas/js/draw/handle.js";
import { putLegend } from "../canvas/js/draw/legend.js";
import { boundedNumber } from "../canvas/js/draw/link.js";
import { livePicture } from "../canvas/js/draw/picture.js";
import { pathThrough } from "../canvas/js/draw/scene.js";
import { twoPanels } from "../canvas/js/draw/stage.js";

/** Readings of a wall, the fitted line, the pull of each reading and the influence, as far as a reading was moved. */
export function render(context) {
  const { kernels } = context.model.get("data");
  return livePicture(context, {
    layers: ["axes", "springs", "lines", "words"],
    controls: [
      { kind: "choice", name: "kernel", label: "Kernel", options: Object.keys(kernels).map((name) => [name, kernelText(name)]) },
    ],
    main: ["kernel"],
    clean: cleanLeverage,
    solve: solveLeverage,
    moving: ({ line, span, top }) => [...line, ...span, top],
    draw: drawLeverage,
    caption: leverageCaption,
  });
}

const PLACE_RANGE = [0, 16];
const HEIGHT_RANGE = [0, 7]; // m

function kernelText(name) {
  return name === "squared" ? "squared (least squares)" : KERNELS[name].label;
}

function cleanLeverage(state, data) {
  const count = data.y.length;
  const held = Number.isInteger(state.held) && state.held >= 0 && state.held < count ? state.held : 0;
  const p = numbersWithin(state.p, data.p, PLACE_RANGE);
  // Readings at one place do not determine a slope.
  const possible = Math.max(...p) - Math.min(...p) >= 1;
  const next = { ...state, held, p: possible ? p : data.p, y: numbersWithin(state.y, data.y, HEIGHT_RANGE) };
  const u = Number(solveLeverage(next, data).residuals[held].toFixed(2));
  // The least and the largest residual that a reading has had with a kernel.
  const key = `${next.kernel} ${held}`;
  const [low, high] = state.tried[key] ?? [u, u];
  return { ...next, tried: { ...state.tried, [key]: [Math.min(low, u), Math.max(high, u)] } };
}

/** `values` within a range and to a thousandth, with `first` where one is no number. */
function numbersWithin(values, first, range) {
  return first.map((value, k) => boundedNumber(values[k], range, value, 3));
}

function solveLeverage({ kernel, p, y, tried }, { sigma, kernels }) {
  const problem = lineProblem(p, y, sigma);
  const options = { tol: 1e-9, maxIterations: 500 };
  // Huber's cost is convex, so that every kernel starts from the same line.
  const start = irls(problem, "huber", kernels.huber, null, options).x;
  const line = irls(problem, kernel, kernels[kernel], start, options).x;
  const residuals = problem.residuals(line).map((u) => -u); // positive above the line
  const pulls = residuals.map((u) => KERNELS[kernel].psi(u, kernels[kernel]));
  const had = [...residuals, ...y.flatMap((_, k) => tried[`${kernel} ${k}`] ?? [])].map((u) => u * sigma);
  const span = [Math.min(-1.2, ...had), Math.max(3.4, ...had)]; // m
  const top = { squared: Math.max(...span.map(Math.abs)) / sigma, tls: 3 }[kernel] ?? 1.6;
  return { line, residuals, pulls, leverages: lineLeverages(p), span, top };
}

/** Whether a reading is more than three standard deviations from the true wall. */
function isOffWall(p, y, { truth, sigma }) {
  return Math.abs(y - truth[0] - truth[1] * p) > 3 * sigma;
}

function drawLeverage(scene, view) {
  const { width, height, shown: [a, b, low, high, top] } = view;
  const [wall, beside] = twoPanels({ x: 0, y: 0, width, height }, [1.5, 1], 0.55, 4);
  drawWall(scene, wall, view, { a, b });
  drawInfluence(scene, beside, view, [low, high], top);
}

function drawWall(scene, box, { state, data, change }, { a, b }) {
  const top = putLegend(scene, "words", "legend", box.x + 50, box.y, box.width - 50, [["is-estimate", "fit"], ["is-ghost", "true wall"]]);
  const axes = putAxes(
    scene, "axes", "fit", { ...box, y: box.y + top, height: box.height - top },
    { domain: [-0.6, 17.6], label: "place p", ticks: [0, 4, 8, 12, 16] },
    { domain: [-0.5, 7.5], label: "distance y (m)", ticks: [0, 2, 4, 6] },
  );
  const [low, high] = [-0.6, 17.6];
  const wall = (p) => data.truth[0] + data.truth[1] * p;
  const line = (p) => a + b * p;
  putCurve(scene, "lines", "wall", axes, [low, high], wall, { class: "rs-line is-ghost" }, 1);
  putCurve(scene, "lines", "line", axes, [low, high], line, { class: "rs-line is-estimate" }, 1);
  state.y.forEach((y, k) => {
    const [x, from, to] = [axes.toX(state.p[k]), axes.toY(line(state.p[k])), axes.toY(y)];
    const look = isOffWall(state.p[k], y, data) ? "is-outlier" : "is-inlier";
    scene.path("springs", `spring-${k}`, `rs-spring ${look}`, springPath(x, from, to));
    putReading(scene, axes, k, state, data, change);
  });
}

function putReading(scene, axes, k, state, data, change) {
  const [p, y] = [state.p[k], state.y[k]];
  const off = isOffWall(p, y, data);
  const move = (place, height) => change({
    held: k,
    p: state.p.map((value, other) => (other === k ? place : value)),
    y: state.y.map((value, other) => (other === k ? height : value)),
  });
  putHandle(scene, `reading-${k}`, {
    x: axes.toX(p), y: axes.toY(y),
    shape: off ? "diamond" : "circle", look: `${off ? "rs-wrong" : "rs-right"} ${k === state.held ? "" : "is-quiet"}`,
    label: `Reading ${k}`, text: `${y.toFixed(2)} m at place ${numberText(p)}`,
    now: y, least: HEIGHT_RANGE[0], most: HEIGHT_RANGE[1], unit: 0.05,
    drag: (px, py) => move(axes.fromX(px), axes.fromY(py)),
    step: (right, up) => move(p + 0.25 * right, y + 0.05 * up),
  });
}

/** A spring from one height to another: twelve turns, however long it is. */
function springPath(x, from, to) {
  const turns = 12;
  const points = Array.from({ length: turns + 1 }, (_, k) => {
    const side = k === 0 || k === turns ? 0 : 3.5 * (k % 2 ? 1 : -1);
    return [x + side, from + ((to - from) * k) / turns];
  });
  return pathThrough(points);
}

function drawInfluence(scene, box, { state, result, data }, span, top) {
  const c = data.kernels[state.kernel];
  const axes = putAxes(
    scene, "axes", "psi", box,
    { domain: span, label: "above the line (m)", ticks: roundTicks(...span, 5) },
    { domain: [-top, top], label: "influence ψ(u)", ticks: roundTicks(-top, top, 4) },
  );
  const psi = (high) => KERNELS[state.kernel].psi(high / data.sigma, c);
  const above = result.residuals.map((u) => u * data.sigma);
  above.forEach((high, k) => {
    const range = state.tried[`${state.kernel} ${k}`]?.map((u) => u * data.sigma);
    if (range) putCurve(scene, "lines", `psi-${k}`, axes, range, psi, { class: "rs-line is-ink" }, 400);
    if (k === state.held) return;
    const look = isOffWall(state.p[k], state.y[k], data) ? "is-outlier" : "is-inlier";
    const d = `M${axes.toX(high).toFixed(1)} ${axes.toY(psi(high)).toFixed(1)}h0`;
    scene.path("lines", `dot-${k}`, `rs-dots ${look}`, d);
  });
  const held = above[state.held];
  const [x, y] = [axes.toX(held), Math.max(axes.inner.y, axes.toY(psi(held)))];
  scene.put("words", "dot-held", "circle", { class: "rs-ring is-ink", cx: x, cy: y, r: 7 });
  scene.path("words", "dot-stem", "rs-edge is-ink", `M${x} ${y}V${axes.toY(0)}`);
}

function leverageCaption({ state, result, data }) {
  const k = state.held;
  const [u, pull, place] = [result.residuals[k], result.pulls[k], state.p[k]];
  const error = result.line[0] - data.truth[0] + (result.line[1] - data.truth[1]) * place;
  const kernel = state.kernel === "squared" ? "Least squares" : KERNELS[state.kernel].label;
  const force = Math.abs(pull) < 0.005 ? "lets this reading go" : `lets this reading pull with ${Math.abs(pull).toFixed(1)}`;
  const where = `${Math.abs(u * data.sigma).toFixed(2)}\u00a0m ${u < 0 ? "below" : "above"} the line`;
  const side = Math.abs(error) < 0.005 ? "is on the wall" : `is ${Math.abs(error).toFixed(2)}\u00a0m too ${error > 0 ? "high" : "low"}`;
  return `${kernel} ${force}, ${where}. The line ${side} at place ${numberText(place)}.`
    + ` Leverage: ${result.leverages[k].toFixed(2)}.`;
}
