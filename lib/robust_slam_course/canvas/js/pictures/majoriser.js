import { KERNELS } from "../solve/kernels.js";
import { majoriser, minimaOf, sampledCost } from "../solve/landscapes.js";
import { locationProblem } from "../solve/location.js";
import { irls, STOP } from "../solve/loop.js";
import { numberText, putAxes, putCurve } from "../draw/axes.js";
import { putHandle } from "../draw/handle.js";
import { putMarker } from "../draw/marker.js";
import { freePlace } from "../draw/labels.js";
import { boundedNumber } from "../draw/link.js";
import { livePicture } from "../draw/picture.js";
import { pathThrough, setAttributes } from "../draw/scene.js";

/** Steps of IRLS: weights above, and below them the cost and the parabola that touches it. */
export function render(context) {
  const { kernels } = context.model.get("data");
  return livePicture(context, {
    layers: ["axes", "curves", "steps", "words"],
    controls: [
      {
        kind: "choice", name: "kernel", label: "Kernel",
        options: kernels.map((name) => [name, KERNELS[name].label]),
      },
      {
        kind: "slider", name: "sigma", label: "Noise σ", min: 0.1, max: 1.5, step: 0.05,
        text: (sigma) => `σ = ${sigma.toFixed(2)}`,
      },
      {
        kind: "button", label: "Back", when: (state, { step }) => step > 0,
        does: (state, { step }) => ({ step: step - 1 }),
      },
      {
        kind: "button", label: "Step", when: (state, { step, path }) => step < path.length - 1,
        does: (state, { step }) => ({ step: step + 1 }),
      },
      {
        kind: "player", name: "step", label: "Steps", count: (state, { path }) => path.length - 1,
        text: (step, result) => `${result.step} of ${result.path.length - 1}`,
      },
    ],
    main: ["step"],
    clean: cleanMajoriser,
    solve: solveMajoriser,
    moving: ({ at, top }) => [at, top],
    draw: drawMajorisers,
    caption: majoriserCaption,
  });
}

const WEIGHTS_HEIGHT = 110; // pixels
const AXIS_RANGE = [-1, 7.5];
const START_RANGE = [-0.9, 7.4];
const OUTLIER_RANGE = [0, 7];
const MOST_STEPS = 60;

function cleanMajoriser(state) {
  return {
    ...state,
    start: boundedNumber(state.start, START_RANGE, 1, 3),
    outlier: boundedNumber(state.outlier, OUTLIER_RANGE, 5, 3),
  };
}

function solveMajoriser({ kernel, start, outlier, sigma, step }, { inliers, c }) {
  const z = [...inliers, outlier];
  const problem = locationProblem(z, sigma);
  const { history, stop } = irls(problem, kernel, c, start, { tol: 1e-4, maxIterations: MOST_STEPS });
  // A step that rejects every reading moves nothing.
  const path = history.slice(0, stop === STOP.allRejected ? -1 : undefined).map(({ x }) => x);
  const shown = Math.min(step, path.length - 1);
  const cost = (x) => z.reduce((sum, reading) => sum + KERNELS[kernel].rho((x - reading) / sigma, c), 0);
  const heights = sampledCost(z, sigma, (u) => KERNELS[kernel].rho(u, c), AXIS_RANGE, 341);
  return {
    z, path, stop, cost, step: shown, at: path[shown],
    parabola: majoriser(z, sigma, kernel, c, path[shown]),
    minima: minimaOf(heights).length, top: 1.12 * Math.max(...heights),
  };
}

function drawMajorisers(scene, view) {
  const { width, height, state, result, shown: [at, top], data } = view;
  const moved = majoriser(result.z, state.sigma, state.kernel, data.c, at);
  const upper = putAxes(
    scene, "axes", "weights", { x: 0, y: 0, width, height: WEIGHTS_HEIGHT },
    { domain: AXIS_RANGE, label: "", ticks: [] }, { domain: [-0.4, 1.12], label: "weight w", ticks: [0, 0.5, 1] },
  );
  const lower = putAxes(
    scene, "axes", "cost", { x: 0, y: WEIGHTS_HEIGHT, width, height: height - WEIGHTS_HEIGHT },
    { domain: AXIS_RANGE, label: "estimate x" }, { domain: [0, top], label: "cost" },
  );
  const x = upper.toX(at);
  const foot = lower.inner.y + lower.inner.height;
  scene.path("axes", "at", "rs-edge is-estimate", `M${x} ${upper.inner.y}V${foot}`);
  drawWeightBell(scene, upper, view, at, moved.weights);
  drawCostAndParabola(scene, lower, view, at, moved);
}

/** The weight that a reading at z has at this estimate, as a curve, and of each reading. */
function drawWeightBell(scene, axes, { state, result, data, change }, at, weights) {
  const bell = (z) => KERNELS[state.kernel].weight((z - at) / state.sigma, data.c);
  putCurve(scene, "curves", "bell", axes, AXIS_RANGE, bell, { class: "rs-line is-muted" }, 340);
  const floor = axes.toY(0);
  result.z.forEach((z, k) => {
    const wrong = k === data.inliers.length;
    const [x, y] = [axes.toX(z), axes.toY(weights[k])];
    const look = wrong ? "is-outlier" : "is-inlier";
    const d = `M${x.toFixed(1)} ${floor.toFixed(1)}V${y.toFixed(1)}`;
    scene.path("steps", `weight-${k}`, `rs-bar ${look}`, d, wrong ? 5 : 3);
    putMarker(scene, "steps", `weight-top-${k}`, x, y, wrong ? "diamond" : "circle", wrong ? "outlier" : "inlier");
  });
  const outlier = result.z.at(-1);
  putHandle(scene, "outlier", {
    // Below the axis, where it hides no weight.
    x: axes.toX(outlier), y: floor + 13, shape: "diamond", look: "rs-wrong",
    label: "Outlier", text: outlier.toFixed(2), now: outlier, least: OUTLIER_RANGE[0], most: OUTLIER_RANGE[1],
    drag: (px) => change({ outlier: axes.fromX(px) }),
    step: (right, up) => change({ outlier: outlier + 0.05 * (right || up) }),
  });
}

function drawCostAndParabola(scene, axes, { state, result, change }, at, { lowest, value }) {
  const { cost, path, step } = result;
  const pixels = (x, f) => [axes.toX(x), axes.toY(f(x))];
  putCurve(scene, "curves", "cost-curve", axes, AXIS_RANGE, cost, { class: "rs-line is-ink" }, 340);
  putCurve(scene, "curves", "parabola", axes, AXIS_RANGE, value, { class: "rs-line is-accent" }, 200);
  const walked = path.slice(0, step + 1).map((x) => pixels(x, cost));
  scene.path("steps", "walked", "rs-edge is-estimate", pathThrough(walked), 1.5);
  walked.forEach(([x, y], k) => putMarker(scene, "steps", `walked-${k}`, x, y, "circle", "estimate"));
  if (lowest !== null) {
    const [x, y] = pixels(lowest, value);
    const down = scene.path("steps", "down", "rs-edge is-estimate", `M${x} ${y}V${axes.toY(cost(lowest))}`);
    setAttributes(down, { "stroke-dasharray": "2 3" });
    putMarker(scene, "steps", "lowest", x, y, "diamond", "accent");
  }
  putMarker(scene, "steps", "touch", ...pixels(at, cost), "square", "accent");
  const taken = putCurveNames(scene, axes, cost, lowest, value);
  const { start } = state;
  const most = path.length - 1;
  const move = (x) => change({ start: x, step: most > 0 && step === most ? MOST_STEPS : step });
  const [x, y] = pixels(start, cost);
  putHandle(scene, "start", {
    x, y, shape: "circle", label: "Start", text: start.toFixed(2),
    now: start, least: START_RANGE[0], most: START_RANGE[1],
    drag: (px) => move(axes.fromX(px)),
    step: (right, up) => move(start + 0.05 * (right || up)),
  });
  const { inner } = axes;
  const places = [[0, 22], [0, -22], [-36, 0], [36, 0]].map(([right, down]) => [x + right, y + down])
    .filter(([px, py]) => px > inner.x + 16 && px < inner.x + inner.width - 14
      && py > inner.y + 8 && py < inner.y + inner.height - 8);
  const free = freePlace(places, taken, 34);
  if (!free) return; // the start is outside the panel while the axis follows the cost
  scene.text("words", "start-name", free[0], free[1] + 5, "start", "rs-halo", "middle");
}

/** Puts the names of both curves, and returns where they are. */
function putCurveNames(scene, axes, cost, lowest, value) {
  const [low, high] = AXIS_RANGE;
  const ceiling = axes.fromY(axes.inner.y + 14);
  const from = lowest ?? high;
  // Where the parabola leaves the panel, on the side that has more room.
  const side = lowest === null || from < (low + high) / 2 ? 1 : -1;
  let x = from;
  while (x > low + 0.1 && x < high - 0.1 && value(x) < ceiling) x += 0.05 * side;
  // Beside the line where it leaves at the top, above it where it ends at the panel's side.
  const room = Math.abs(axes.toX(side > 0 ? high : low) - axes.toX(x));
  const top = value(x) >= ceiling && room > 75;
  const anchor = top === side > 0 ? "start" : "end";
  const place = {
    x: axes.toX(x) + (top ? 9 : -24) * side,
    y: Math.max(axes.inner.y + 14, axes.toY(value(x)) + (top ? 4 : -10)),
  };
  const name = scene.text("words", "parabola-name", place.x, place.y, "majoriser", "rs-halo", anchor);
  setAttributes(name, { style: "fill: var(--rs-accent)" });
  // Below the cost, where the parabola never is.
  const beside = { x: axes.toX(2.1), y: Math.min(axes.toY(cost(2.1)) + 22, axes.inner.y + axes.inner.height - 4) };
  scene.text("words", "cost-name", beside.x, beside.y, "cost", "rs-halo", "middle");
  return [place, beside].map(({ x: across, y }) => [across, y - 5]);
}

function majoriserCaption({ state, result }) {
  const { step, path, stop, at, cost, parabola } = result;
  const fixed = (x) => numberText(Number(x.toFixed(3)), 4);
  const weight = (w) => (w === 0 ? "0" : w < 0.001 ? "below 0.001" : w.toFixed(3));
  const inliers = Math.max(...parabola.weights.slice(0, -1));
  const votes = `The outlier has the weight ${weight(parabola.weights.at(-1))}, an inlier at most ${weight(inliers)}.`;
  const minima = `The cost has ${["no local minimum", "one local minimum", "two local minima"][result.minima] ?? `${result.minima} local minima`}.`;
  const here = `step ${step} of ${path.length - 1}, cost ${cost(at).toFixed(2)} at ${fixed(at)}.`;
  const name = KERNELS[state.kernel].label;
  if (parabola.lowest === null) return `${name}, ${here} Every weight is 0: the majoriser is flat and has no lowest point. ${minima}`;
  const ended = step === path.length - 1 && stop === STOP.converged;
  const next = ended
    ? `IRLS has converged.`
    : `The majoriser is lowest at ${fixed(parabola.lowest)}, where the cost is ${cost(parabola.lowest).toFixed(2)}.`;
  return `${name}, ${here} ${next} ${votes} ${minima}`;
}
