import { KERNELS } from "../canvas/js/solve/kernels.js";
import { sampledCost } from "../canvas/js/solve/landscapes.js";
import { locationProblem } from "../canvas/js/solve/location.js";
import { irls } from "../canvas/js/solve/loop.js";
import { putAxes, putPath } from "../canvas/js/draw/axes.js";
import { numberText } from "../canvas/js/draw/number.js";
import { putHandle } from "../canvas/js/draw/handle.js";
import { boundedNumber } from "../canvas/js/draw/link.js";
import { livePicture } from "../canvas/js/draw/picture.js";
import { letterOf, painted, putRibbon } from "../canvas/js/draw/ribbon.js";

/** The cost of two groups of readings, a descent on it, and where descents from tried starts end. */
export function render(context) {
  return livePicture(context, {
    layers: ["grid", "lines", "marks"],
    controls: [
      { kind: "slider", name: "sigma", label: "σ", min: 0.3, max: 3, step: 0.1, text: (sigma) => sigma.toFixed(1) },
      { kind: "choice", name: "kernel", label: "Cost", options: LANDSCAPE_KERNELS },
    ],
    main: ["sigma"],
    clean: cleanBasins,
    solve: solveBasins,
    moving: (result) => result.cost,
    draw: drawBasins,
    caption: basinsCaption,
  });
}

const LANDSCAPE_KERNELS = [
  ["tls", "TLS"], ["cauchy", "Cauchy"], ["geman-mcclure", "Geman–McClure"], ["squared", "squared"],
];
/** The part of the x axis that is shown, and in which readings and the start may be. */
const BASIN_SPAN = [-4, 14];
const BASIN_PLACES = 181;
const BASIN_STEP = (BASIN_SPAN[1] - BASIN_SPAN[0]) / (BASIN_PLACES - 1);
const TRIED = 90; // cells of the ribbon

/** The nearest possible state, in which the start is tried: the ribbon is of one cost. */
function cleanBasins(state, data) {
  const z = data.z.map((given, k) => boundedNumber(state.z[k], BASIN_SPAN, given, 1));
  const next = { ...state, z, start: boundedNumber(state.start, BASIN_SPAN, 8, 2) };
  const at = Math.min(TRIED - 1, Math.floor((TRIED * (next.start - BASIN_SPAN[0])) / (BASIN_SPAN[1] - BASIN_SPAN[0])));
  const [key, letter] = [costKey(next), letterOf(endOf(z, descentFrom(next, data)) !== "first")];
  return { ...next, tried: { ...state.tried, [key]: painted(state.tried[key], TRIED, at, letter) } };
}

function costKey({ z, sigma, kernel }) {
  return `${kernel} ${sigma} ${z}`;
}

function descentFrom({ z, sigma, kernel, start }, { times, c }) {
  const all = z.flatMap((reading, k) => Array(times[k]).fill(reading));
  return irls(locationProblem(all, sigma), kernel, c, start, { maxIterations: 1000 });
}

function basinPlace(k) {
  return BASIN_SPAN[0] + BASIN_STEP * k;
}

/** Which group of readings a descent ends near, that it ends between the two, or stays where it is. */
function endOf([first, second], { x, stop }) {
  if (stop === "all rejected") return "stays";
  const share = first === second ? 0 : (x - first) / (second - first);
  if (share < 0.46) return "first";
  return share > 0.54 ? "second" : "between";
}

const LOOK_OF = { first: "is-inlier", second: "is-outlier", between: "is-estimate", stays: "is-muted" };

function solveBasins(state, data) {
  const { z, sigma, kernel } = state;
  const { times, c } = data;
  const run = descentFrom(state, data);
  const sampled = sampledCost(z, sigma, (u) => KERNELS[kernel].rho(u, c), BASIN_SPAN, BASIN_PLACES, times);
  const [least, most] = [Math.min(...sampled), Math.max(...sampled)];
  return {
    run, times, end: endOf(z, run), count: times[0] + times[1],
    kept: run.weights.reduce((sum, weight) => sum + weight, 0),
    cost: sampled.map((value) => (value - least) / Math.max(most - least, 1e-9)),
  };
}

/** Where the panels are: the cost, the readings, the band of starts that were tried. */
function basinPanels(width, height) {
  return {
    upper: { x: 0, y: 22, width, height: height - 108 },
    readings: height - 72, band: { y: height - 30, height: 28 },
  };
}

function drawBasins(scene, { state, result, shown, width, height, change }) {
  const panels = basinPanels(width, height);
  const maps = drawLandscape(scene, panels.upper, state, result, shown, change);
  drawGroups(scene, panels.readings, maps, state, result, change);
  drawBand(scene, panels.band, maps, state);
}

function drawLandscape(scene, box, state, result, cost, change) {
  const maps = putAxes(scene, "grid", "cost", box,
    { domain: BASIN_SPAN, label: "" }, { domain: [-0.12, 1.1], label: "cost, low to high", ticks: [] });
  scene.text("marks", "cost-head", maps.inner.x, 14, "Cost and descent; circle: start", "rs-head");
  const height = (x) => {
    const k = Math.min(BASIN_PLACES - 1.001, Math.max(0, (x - BASIN_SPAN[0]) / BASIN_STEP));
    const left = Math.floor(k);
    return maps.toY(cost[left] + (k - left) * (cost[left + 1] - cost[left]));
  };
  putPath(scene, "lines", "cost-line", maps, Array.from(cost, (value, k) => [maps.toX(basinPlace(k)), maps.toY(value)]),
    { class: "rs-line is-ink" });
  const { history, x: end } = result.run;
  const dots = history.slice(1).map(({ x }) => `M${maps.toX(x).toFixed(1)} ${height(x).toFixed(1)}h0`);
  scene.path("lines", "steps", "rs-dots is-estimate", dots.slice(0, 60).join(""));
  const [x, y] = [maps.toX(end), height(end)];
  scene.path("marks", "end-line", `rs-edge ${LOOK_OF[result.end]}`, `M${x} ${y}V${maps.inner.y + maps.inner.height}`, 2);
  scene.path("marks", "end", "rs-full is-estimate", `M${x} ${y - 7}l7 7l-7 7l-7 -7Z`);
  const room = [x - maps.inner.x > 80, maps.inner.x + maps.inner.width - x > 80];
  // The words stand on the side of the end that the descent does not come from.
  const onRight = !room[1] || (room[0] && state.start > end);
  const place = [x + (onRight ? -12 : 12), y + 16];
  scene.text("marks", "end-text", ...place, `end ${placeText(end)}`, "rs-halo", onRight ? "end" : "start");
  putHandle(scene, "start", {
    x: maps.toX(state.start), y: height(state.start), label: "Start of the descent",
    text: `${numberText(state.start)}, ends at ${placeText(end)}`,
    now: state.start, least: BASIN_SPAN[0], most: BASIN_SPAN[1], unit: 0.1,
    drag: (px) => change({ start: maps.fromX(px) }),
    step: (right, up) => change({ start: state.start + 0.1 * (right || up) }),
  });
  return maps;
}

function drawGroups(scene, y, maps, state, result, change) {
  state.z.forEach((reading, k) => {
    const x = maps.toX(reading);
    const count = result.times[k];
    const other = maps.toX(state.z[1 - k]);
    const toLeft = Math.abs(other - x) > 190
      ? x > maps.inner.x + maps.inner.width - 80
      : x < other || (x === other && k === 0);
    const fits = toLeft ? x > 100 : x < maps.inner.x + maps.inner.width - 90;
    if (fits) {
      const words = count === 1 ? "1 reading" : `${count} readings`;
      const anchor = toLeft ? "end" : "start";
      scene.text("marks", `group-${k}`, x + (toLeft ? -26 : 26), y + 4, words, "rs-halo", anchor);
    }
    const move = (value) => change({ z: state.z.map((one, j) => (j === k ? value : one)) });
    putHandle(scene, `reading-${k}`, {
      x, y, shape: "square", look: k ? "rs-wrong" : "rs-right",
      label: count === 1 ? `Reading ${k + 1}` : `The ${count} readings`, text: numberText(reading),
      now: reading, least: BASIN_SPAN[0], most: BASIN_SPAN[1], unit: 0.1,
      drag: (px) => move(maps.fromX(px)),
      step: (right, up) => move(reading + 0.1 * (right || up)),
    });
  });
}

/** The starts that were tried, green where they end at the first readings. */
function drawBand(scene, { y, height }, { inner: { x, width } }, state) {
  scene.text("marks", "band-head", x, y - 8, "Starts that you tried; orange: lost", "rs-head");
  putRibbon(scene, "marks", "tried", { x, y, width, height }, state.tried[costKey(state)]);
}

/** A place or a cost with two decimals at most. */
function placeText(value) {
  return numberText(Math.round(100 * value) / 100, 6);
}

function basinsCaption({ state, result: { run, kept, count } }) {
  const from = `From ${placeText(state.start)} the descent`;
  if (run.stop === "all rejected") return `${from} stays where it is: no reading is near enough to pull.`;
  const ends = `${from} ends at ${placeText(run.x)}`;
  return state.kernel === "tls" ? `${ends} and keeps ${kept} of ${count} readings.`
    : `${ends}, where the weights of ${count} readings sum to ${numberText(kept)}.`;
}
