import { gnc } from "../canvas/js/solve/graduation.js";
import { KERNELS, gmSurrogate, tlsSurrogate } from "../canvas/js/solve/kernels.js";
import { minimaOf, sampledCost } from "../canvas/js/solve/landscapes.js";
import { locationProblem } from "../canvas/js/solve/location.js";
import { putAxes, putPath, roundTicks } from "../canvas/js/draw/axes.js";
import { numberText } from "../canvas/js/draw/number.js";
import { LAST_STEP } from "../canvas/js/draw/controls.js";
import { putHandle } from "../canvas/js/draw/handle.js";
import { boundedNumber } from "../canvas/js/draw/link.js";
import { livePicture } from "../canvas/js/draw/picture.js";

/** GNC on a few readings: the cost as it sharpens, the weights, the path of the estimate. */
export function render(context) {
  return livePicture(context, {
    layers: ["grid", "back", "lines", "marks"],
    controls: [
      {
        kind: "player", name: "step", label: "Solve", count: (state, result) => result.last,
        text: (step, result) => `${result.step} of ${result.last}`,
      },
      { kind: "slider", name: "factor", label: "Factor of μ", min: 1.05, max: 2, step: 0.05, text: (factor) => factor.toFixed(2) },
    ],
    main: [context.model.get("data").main],
    clean: cleanAnnealing,
    solve: solveAnnealing,
    moving: (result) => [...result.cost, result.x, ...result.weights],
    draw: drawAnnealing,
    caption: annealingCaption,
  });
}

const COST_SAMPLES = 211;

function cleanAnnealing(state, { z: given, kind, c, span }) {
  const { factor, step } = state;
  const z = given.map((reading, k) => boundedNumber(state.z[k], span, reading, 1));
  const last = gnc(locationProblem(z), c, kind, null, { factor }).history.length - 1;
  // A reader who is at the last step stays there when a reading makes the run longer.
  return { ...state, z, step: step >= last ? LAST_STEP : step };
}

function solveAnnealing({ z, factor, step }, { kind, c, span }) {
  const problem = locationProblem(z);
  const { history, stop } = gnc(problem, c, kind, null, { factor });
  const last = history.length - 1;
  const now = Math.min(step, last);
  const kernelName = kind === "gm" ? "geman-mcclure" : "tls";
  const surrogate = kind === "gm" ? gmSurrogate : tlsSurrogate;
  const sampled = (mu) => sampledCost(z, 1, mu === null ? (u) => 0.5 * u * u : (u) => surrogate(u, c, mu), span, COST_SAMPLES);
  const hard = sampledCost(z, 1, (u) => KERNELS[kernelName].rho(u, c), span, COST_SAMPLES);
  const place = (k) => span[0] + ((span[1] - span[0]) * k) / (COST_SAMPLES - 1);
  return {
    history, stop, last, span,
    step: now,
    x: history[now].x,
    before: history[Math.max(0, now - 1)].x,
    mu: history[now].mu,
    weights: history[now].weights,
    cost: shareOfHighest(sampled(history[now].mu)),
    hard: shareOfHighest(hard),
    minima: history.map(({ mu }) => minimaOf(sampled(mu)).map(place)),
  };
}

/** Values as shares of the highest, so that costs of every μ fit one axis. */
function shareOfHighest(values) {
  const most = Math.max(...values);
  return values.map((value) => value / most);
}

/** Width (px) of the column of weights on the right. */
const WEIGHT_COLUMN = 84;

function drawAnnealing(scene, { state, result, shown, width, height, data, change }) {
  const all = { x: 0, width: width - WEIGHT_COLUMN };
  const middle = Math.round(0.5 * height);
  const upper = { ...all, y: 22, height: middle - 22 };
  const cost = shown.subarray(0, COST_SAMPLES);
  const x = shown[COST_SAMPLES];
  const weights = shown.subarray(COST_SAMPLES + 1);
  const maps = data.view === "cost" ? drawCost(scene, upper, data, result, cost, x)
    : drawPath(scene, upper, result, change);
  const rows = { y: middle + 22, height: height - middle - 22 };
  drawReadings(scene, rows, maps, { state, result, width, change }, weights, x);
}

function drawCost(scene, box, { kind }, result, cost, x) {
  const maps = putAxes(scene, "grid", "cost", box,
    { domain: result.span, label: "", ticks: roundTicks(...result.span, 5) }, { domain: [-0.04, 1.06], label: "cost", ticks: [0, 0.5, 1], text: (share) => (share ? (share < 1 ? "½" : "max") : "0") });
  const [low, high] = result.span;
  const place = (k) => maps.toX(low + ((high - low) * k) / (COST_SAMPLES - 1));
  const points = (values) => Array.from(values, (value, k) => [place(k), maps.toY(value)]);
  const height = (at) => {
    const k = Math.min(COST_SAMPLES - 2, Math.max(0, ((at - low) / (high - low)) * (COST_SAMPLES - 1)));
    const left = Math.floor(k);
    return maps.toY(cost[left] + (k - left) * (cost[left + 1] - cost[left]));
  };
  const family = kind === "gm" ? "GM" : "TLS";
  const head = result.mu === null ? "Squared cost" : `Cost at μ = ${numberText(result.mu)}`;
  scene.text("marks", "cost-head", maps.inner.x, box.y - 8, `${head}; grey: its end, ${family}`, "rs-head");
  putPath(scene, "back", "hard", maps, points(result.hard), { class: "rs-band" });
  putPath(scene, "lines", "soft", maps, points(cost), { class: "rs-line is-ink" });
  const spot = maps.toX(x);
  scene.put("lines", "before", "circle", {
    class: "rs-open is-estimate", cx: maps.toX(result.before), cy: height(result.before), r: 6,
  });
  scene.path("marks", "now", "rs-full is-estimate", `M${spot} ${height(x) - 7}l7 7l-7 7l-7 -7Z`);
  return maps;
}

/** A row for each reading: a handle, its pull on the estimate, its weight as bar and number. */
function drawReadings(scene, { y, height }, maps, { state, result, width, change }, weights, x) {
  const [low, high] = [maps.fromX(maps.inner.x), maps.fromX(maps.inner.x + maps.inner.width)];
  const row = height / state.z.length;
  const column = width - WEIGHT_COLUMN + 6;
  const head = `${width < 420 ? "" : "Readings, pulled to the estimate; "}orange: weight ≤ ½`;
  scene.text("marks", "rows-head", maps.inner.x, y - 8, head, "rs-head");
  scene.text("marks", "weights-head", column, y - 8, "weight", "rs-head");
  scene.path("back", "rows-estimate", "rs-edge is-estimate", `M${maps.toX(x)} ${y}V${y + height}`, 1.5);
  state.z.forEach((reading, k) => {
    const middle = y + (k + 0.5) * row;
    const [at, weight] = [maps.toX(reading), weights[k]];
    const look = weight > 0.0005 ? "rs-edge is-inlier" : "rs-edge is-ghost";
    scene.path("lines", `pull-${k}`, look, `M${at.toFixed(1)} ${middle}H${maps.toX(x).toFixed(1)}`, 1 + 5 * weight);
    scene.path("back", `bar-back-${k}`, "rs-edge is-grid", `M${column} ${middle}h30`, 9);
    const bar = `M${column} ${middle}h${(30 * weight).toFixed(2)}`;
    scene.path("lines", `bar-${k}`, "rs-edge is-inlier", bar, weight > 0.0005 ? 9 : 0);
    scene.text("marks", `weight-${k}`, column + 41, middle + 5, weight.toFixed(3), "rs-tick");
    const away = at < maps.toX(x) ? ["end", -14] : ["start", 14];
    scene.text("marks", `value-${k}`, at + away[1], middle + 5, numberText(reading), "rs-tick rs-halo", away[0]);
    const move = (value) => change({ z: state.z.map((other, j) => (j === k ? value : other)) });
    putHandle(scene, `reading-${k}`, {
      x: at, y: middle, look: `${result.weights[k] > 0.5 ? "rs-right" : "rs-wrong"} ${k < state.z.length - 1 ? "is-quiet" : ""}`,
      label: `Reading ${k + 1}`, text: `${numberText(reading)}, weight ${weight.toFixed(3)}`,
      now: reading, least: low.toFixed(1), most: high.toFixed(1), unit: 0.5,
      drag: (px) => move(maps.fromX(px)),
      step: (right, up) => move(reading + 0.5 * (right || up)),
    });
  });
}

/** The estimate after each solve, from the first μ above to the last below. */
function drawPath(scene, box, result, change) {
  const last = Math.max(1, result.last);
  const maps = putAxes(scene, "grid", "path", box,
    { domain: result.span, label: "" }, { domain: [1.08 * last + 0.5, -0.5], label: null, ticks: [] });
  const head = box.width < 270 ? "Path over μ" : "Path of the estimate over μ; dots: minima";
  scene.text("marks", "path-head", maps.inner.x, box.y - 8, head, "rs-head");
  const every = Math.ceil(last / 4);
  for (let k = every; k <= last; k += every) {
    const mu = result.history[k]?.mu;
    if (mu === undefined) continue;
    scene.text("marks", `mu-${k}`, maps.inner.x - 6, maps.toY(k) + 4, numberText(mu, 2), "rs-tick", "end");
  }
  const dots = result.minima.flatMap((places, k) => places.map(
    (x) => `M${maps.toX(x).toFixed(1)} ${maps.toY(k).toFixed(1)}h0`,
  ));
  scene.path("back", "minima", "rs-dots is-muted", dots.join(""));
  const points = result.history.map(({ x }, k) => [maps.toX(x), maps.toY(k)]);
  putPath(scene, "lines", "path", maps, points, { class: "rs-line is-estimate" });
  const text = result.mu === null ? "least squares" : `μ = ${numberText(result.mu)}`;
  const [x, y] = points[result.step];
  scene.text("marks", "mu-now", x + 16, y + 4, text, "rs-halo");
  const move = (step) => change({ step });
  putHandle(scene, "mu", {
    x, y, shape: "diamond", label: "μ, the step of the run",
    text: `solve ${result.step} of ${result.last}, ${text}`, now: result.step, least: 0, most: result.last,
    drag: (px, py) => move(maps.fromY(py)),
    step: (right, up) => move(result.step + (right || up)),
  });
  return maps;
}

function annealingCaption({ state, result: { step, last, x, before, weights, minima, stop, history } }) {
  const place = (at) => numberText(Number(at.toFixed(2)));
  if (!step) return `Least squares gives all ${state.z.length} readings the same weight and puts the estimate at ${place(x)}; ${last} solves follow.`;
  if (stop === "nothing to reject") return "No residual is large enough: least squares is the answer.";
  const rejected = weights.filter((w) => w <= 0.5).length;
  const kept = state.z.length - rejected;
  if (step === last) {
    return `From the mean, ${place(history[0].x)}, the run goes to ${place(x)} in ${last} solves and `
      + `${kept ? `keeps ${kept} of ${state.z.length} readings` : "has rejected every reading"}.`;
  }
  const valleys = minima[step].length === 1 ? "one minimum" : `${minima[step].length} minima`;
  return `Solve ${step} moves the estimate from ${place(before)} to ${place(x)} and weighs ${rejected} of`
    + ` ${state.z.length} readings less than half. The cost has ${valleys}.`;
}
