import { KERNELS } from "../solve/kernels.js";
import { locationEnds, minimaOf, sampledCost } from "../solve/landscapes.js";
import { locationProblem } from "../solve/location.js";
import { irls } from "../solve/loop.js";
import { putAxes, putPath } from "../draw/axes.js";
import { numberText } from "../draw/number.js";
import { putHandle } from "../draw/handle.js";
import { boundedNumber } from "../draw/link.js";
import { livePicture } from "../draw/picture.js";

/** The cost of two groups of readings, a descent on it, and where descents end from any start. */
export function render(context) {
  const fork = { key: null, rows: [], minima: [] };
  return livePicture(context, {
    layers: ["areas", "grid", "lines", "marks"],
    controls: [
      { kind: "choice", name: "kernel", label: "Cost", options: LANDSCAPE_KERNELS },
      {
        kind: "choice", name: "readings", label: "Readings",
        options: [["crowd", "twenty and one"], ["pair", "one and one"]],
      },
      {
        kind: "slider", name: "c", label: "c", min: LEAST_C, max: MOST_C, step: 0.1,
        text: (c) => c.toFixed(1),
      },
      {
        kind: "slider", name: "sigma", label: "σ", min: 0.3, max: 3, step: 0.1,
        text: (sigma) => sigma.toFixed(1),
      },
      {
        kind: "choice", name: "view", label: "Show",
        options: [["cost", "the cost"], ["every c", "all starts, for every c"]],
      },
    ],
    main: ["sigma"],
    clean: cleanBasins,
    solve: (state, data) => solveBasins(state, data, fork),
    moving: (result) => result.cost,
    draw: drawBasins,
    caption: basinsCaption,
  });
}

const LANDSCAPE_KERNELS = [
  ["tls", "TLS"], ["cauchy", "Cauchy"], ["geman-mcclure", "Geman–McClure"], ["squared", "squared"],
];
const [LEAST_C, MOST_C] = [0.5, 12];
/** The part of the x axis that is shown, and in which readings and the start may be. */
const BASIN_SPAN = [-4, 14];
const BASIN_PLACES = 181;
const MAP_ROWS = 47;

function cleanBasins(state, data) {
  const z = data.z.map((given, k) => boundedNumber(state.z[k], BASIN_SPAN, given, 1));
  return { ...state, z, start: boundedNumber(state.start, BASIN_SPAN, 8, 2) };
}

function basinPlace(k) {
  return BASIN_SPAN[0] + ((BASIN_SPAN[1] - BASIN_SPAN[0]) * k) / (BASIN_PLACES - 1);
}

/** The k-th of the values of c for which the map has a row. */
function levelOf(k) {
  return LEAST_C + ((MOST_C - LEAST_C) * k) / (MAP_ROWS - 1);
}

function costOver({ z, sigma, kernel }, c, times) {
  return sampledCost(z, sigma, (u) => KERNELS[kernel].rho(u, c), BASIN_SPAN, BASIN_PLACES, times);
}

/** The places of the minima, which have a wall on both sides wherever readings may be. */
function minimaOver({ z, sigma, kernel }, c, times) {
  const [more, step] = [10, basinPlace(1) - basinPlace(0)];
  const span = [BASIN_SPAN[0] - more * step, BASIN_SPAN[1] + more * step];
  const cost = sampledCost(z, sigma, (u) => KERNELS[kernel].rho(u, c), span, BASIN_PLACES + 2 * more, times);
  return minimaOf(cost).map((k) => basinPlace(k - more));
}

/** The minima of the cost at this c, and for each start which of the groups its end is near. */
function basinsAt(state, c, times, options) {
  const { z, sigma, kernel } = state;
  const cost = costOver(state, c, times);
  const starts = Float64Array.from({ length: BASIN_PLACES }, (_, k) => basinPlace(k));
  const { ends, kept } = locationEnds(z, sigma, kernel, c, starts, { ...options, times });
  const kinds = Array.from(ends, (end, k) => (kept[k] > 0 ? nearGroup(z, end) : "stays"));
  return { c, cost, kinds, ends, minima: minimaOver(state, c, times) };
}

/** Which group of readings `x` is near, or that it is between the two. */
function nearGroup([first, second], x) {
  const share = first === second ? 0 : (x - first) / (second - first);
  if (share < 0.46) return "first";
  return share > 0.54 ? "second" : "between";
}

const LOOK_OF = { first: "is-estimate", second: "is-outlier", between: "is-accent" };

function solveBasins(state, data, fork) {
  const times = data.times[state.readings];
  // The map over c does not depend on the start nor on c, which are dragged most.
  const key = JSON.stringify([state.z, state.sigma, state.kernel, times]);
  if (fork.key !== key) {
    fork.key = key;
    fork.rows = Array.from({ length: MAP_ROWS }, (_, k) => basinsAt(
      state, levelOf(k), times, { tol: 1e-3, maxIterations: 40 },
    ));
    // Dots are four times as close as the rows of the map, so that a branch is seen as a curve.
    fork.minima = Array.from({ length: 4 * MAP_ROWS - 3 }, (_, k) => [
      levelOf(k / 4), minimaOver(state, levelOf(k / 4), times),
    ]);
  }
  const here = basinsAt(state, state.c, times, { tol: 1e-6, maxIterations: 500 });
  const all = state.z.flatMap((reading, k) => Array(times[k]).fill(reading));
  const problem = locationProblem(all, state.sigma);
  const run = irls(problem, state.kernel, state.c, state.start, { maxIterations: 1000 });
  const lowest = irls(
    problem, state.kernel, state.c, basinPlace(here.cost.indexOf(Math.min(...here.cost))),
    { maxIterations: 1000 },
  );
  const [least, most] = [Math.min(...here.cost), Math.max(...here.cost)];
  return {
    ...here, run, lowest, times,
    cost: here.cost.map((value) => (value - least) / Math.max(most - least, 1e-9)),
    rows: fork.rows,
    branches: fork.minima,
    kept: run.weights.reduce((sum, weight) => sum + weight, 0),
    count: all.length,
  };
}

/** Where the panels are: the cost or the map over c, the readings, the band of basins. */
function basinPanels(width, height) {
  return {
    upper: { x: 0, y: 22, width, height: height - 108 },
    readings: height - 72, band: { y: height - 30, height: 28 },
  };
}

function drawBasins(scene, { state, result, shown, width, height, change }) {
  const panels = basinPanels(width, height);
  const drawUpper = state.view === "cost" ? drawLandscape : drawFork;
  const maps = drawUpper(scene, panels.upper, state, result, shown, change);
  drawGroups(scene, panels.readings, maps, state, result, change);
  drawBand(scene, panels.band, maps, result);
}

function drawLandscape(scene, box, state, result, cost, change) {
  const maps = putAxes(scene, "grid", "cost", box,
    { domain: BASIN_SPAN, label: "" }, { domain: [-0.12, 1.1], label: "cost, low to high", ticks: [] });
  scene.text("marks", "cost-head", maps.inner.x, 14, "Cost and descent; circle: start", "rs-head");
  const height = (x) => {
    const k = Math.min(BASIN_PLACES - 1.001, Math.max(0, (x - BASIN_SPAN[0]) / (basinPlace(1) - basinPlace(0))));
    const left = Math.floor(k);
    return maps.toY(cost[left] + (k - left) * (cost[left + 1] - cost[left]));
  };
  putPath(scene, "lines", "cost-line", maps, Array.from(cost, (value, k) => [maps.toX(basinPlace(k)), maps.toY(value)]),
    { class: "rs-line is-ink" });
  const { history } = result.run;
  const end = result.run.x;
  const dots = history.slice(1).map(({ x }) => `M${maps.toX(x).toFixed(1)} ${height(x).toFixed(1)}h0`);
  scene.path("lines", "steps", "rs-dots is-estimate", dots.slice(0, 60).join(""));
  const [x, y] = [maps.toX(end), height(end)];
  const look = LOOK_OF[nearGroup(state.z, end)];
  scene.path("marks", "end-line", `rs-edge ${look}`, `M${x} ${y}V${maps.inner.y + maps.inner.height}`, 2);
  scene.path("marks", "end", "rs-full is-estimate", `M${x} ${y - 7}l7 7l-7 7l-7 -7Z`);
  const room = [x - maps.inner.x > 80, maps.inner.x + maps.inner.width - x > 80];
  // The words stand on the side of the end that the descent does not come from.
  const onRight = !room[1] || (room[0] && state.start > end);
  const place = [x + (onRight ? -12 : 12), y + 16];
  scene.text("marks", "end-text", ...place, `end ${placeText(end)}`, "rs-halo", onRight ? "end" : "start");
  putStart(scene, maps, height(state.start), state, end, change);
  return maps;
}

function putStart(scene, maps, y, state, end, change) {
  putHandle(scene, "start", {
    x: maps.toX(state.start), y, label: "Start of the descent",
    text: `${numberText(state.start)}, ends at ${placeText(end)}`,
    now: state.start, least: BASIN_SPAN[0], most: BASIN_SPAN[1],
    drag: (px) => change({ start: maps.fromX(px) }),
    step: (right, up) => change({ start: state.start + 0.1 * (right || up) }),
  });
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
    const move = (value) => change({ z: state.z.map((other, j) => (j === k ? value : other)) });
    putHandle(scene, `reading-${k}`, {
      x, y, shape: "square", look: k ? "rs-wrong" : "",
      label: count === 1 ? `Reading ${k + 1}` : `The ${count} readings`, text: numberText(reading),
      now: reading, least: BASIN_SPAN[0], most: BASIN_SPAN[1],
      drag: (px) => move(maps.fromX(px)),
      step: (right, up) => move(reading + 0.1 * (right || up)),
    });
  });
}

/** Runs of equal values as [value, first place, last place]. */
function runsOf(kinds) {
  const runs = [];
  kinds.forEach((kind, k) => {
    const last = runs.at(-1);
    if (last && last[0] === kind) last[2] = k;
    else runs.push([kind, k, k]);
  });
  return runs;
}

/** Left and right edge in pixels of the places `from` to `to`, each a cell as wide as a step. */
function cellEdges(maps, from, to) {
  const half = (basinPlace(1) - basinPlace(0)) / 2;
  const clip = (x) => maps.toX(Math.min(BASIN_SPAN[1], Math.max(BASIN_SPAN[0], x)));
  return [clip(basinPlace(from) - half), clip(basinPlace(to) + half)];
}

function drawBand(scene, { y, height }, maps, result) {
  scene.text("marks", "band-head", maps.inner.x, y - 8, "Starts, by where they end", "rs-head");
  const areas = { first: "", second: "", between: "", stays: "" };
  runsOf(result.kinds).forEach(([kind, from, to], k) => {
    const [left, right] = cellEdges(maps, from, to);
    areas[kind] += `M${left.toFixed(1)} ${y}H${right.toFixed(1)}v${height}H${left.toFixed(1)}Z`;
    if (right - left < 44) return;
    const end = result.ends[Math.round((from + to) / 2)];
    const text = kind === "stays" ? "stays" : `→ ${placeText(end)}`;
    scene.text("marks", `band-${k}`, (left + right) / 2, y + height / 2 + 4, text, "", "middle");
  });
  for (const [kind, look] of Object.entries(LOOK_OF)) {
    scene.path("areas", `band-area-${kind}`, `rs-area ${look}`, areas[kind]);
  }
  scene.path("areas", "band-stays", "rs-area is-grid", areas.stays);
}

/** For every c: the minima, and beneath them the starts by where they end. */
function drawFork(scene, box, state, result, _, change) {
  const maps = putAxes(scene, "grid", "fork", box,
    { domain: BASIN_SPAN, label: "" }, { domain: [LEAST_C, MOST_C], label: "c", ticks: [1, 3, 5, 7, 9, 11] });
  scene.text("marks", "fork-head", maps.inner.x, 14, "Starts for every c; black: minima", "rs-head");
  const half = (MOST_C - LEAST_C) / (MAP_ROWS - 1) / 2;
  const areas = { first: "", second: "", between: "", stays: "" };
  const dots = result.branches.flatMap(([c, minima]) => minima.map(
    (x) => `M${maps.toX(x).toFixed(1)} ${maps.toY(c).toFixed(1)}h0`,
  ));
  for (const { c, kinds } of result.rows) {
    const top = maps.toY(Math.min(MOST_C, c + half));
    // Half a pixel more than a row, so that no seam is seen between two rows.
    const height = (maps.toY(Math.max(LEAST_C, c - half)) - top + 0.5).toFixed(1);
    for (const [kind, from, to] of runsOf(kinds)) {
      const [left, right] = cellEdges(maps, from, to);
      areas[kind] += `M${left.toFixed(1)} ${top.toFixed(1)}H${right.toFixed(1)}v${height}H${left.toFixed(1)}Z`;
    }
  }
  for (const [kind, look] of Object.entries(LOOK_OF)) {
    scene.path("areas", `fork-${kind}`, `rs-area ${look}`, areas[kind]);
  }
  scene.path("lines", "fork-minima", "rs-dots is-ink", dots.join(""));
  const y = maps.toY(state.c);
  const right = maps.inner.x + maps.inner.width;
  scene.path("marks", "fork-c", "rs-edge is-ink", `M${maps.inner.x} ${y}H${right}`, 1.5);
  putHandle(scene, "c", {
    x: right - 12, y, shape: "diamond", label: "c, the scale of the cost", text: `c = ${numberText(state.c)}`,
    now: state.c, least: LEAST_C, most: MOST_C,
    drag: (px, py) => change({ c: maps.fromY(py) }),
    step: (across, up) => change({ c: state.c + 0.1 * (across || up) }),
  });
  putStart(scene, maps, y, state, result.run.x, change);
  return maps;
}

/** A place or a cost with two decimals at most. */
function placeText(value) {
  return numberText(Math.round(100 * value) / 100, 6);
}

function basinsCaption({ state, result }) {
  const name = LANDSCAPE_KERNELS.find(([key]) => key === state.kernel)[1];
  const scale = state.kernel === "squared" ? "" : ` and c = ${placeText(state.c)}`;
  const count = result.minima.length;
  const valleys = `${name}${scale}: ${count === 1 ? "one minimum" : `${count} minima`}.`;
  const { run, lowest } = result;
  if (run.stop === "all rejected") {
    return `${valleys} From ${placeText(state.start)} the descent stays where it is: no reading is near`
      + ` enough to have a weight, so the slope is 0.`;
  }
  const kept = state.kernel === "tls"
    ? `and keeps ${result.kept} of ${result.count} readings`
    : `where the weights of ${result.count} readings sum to ${numberText(result.kept)}`;
  const walk = `${valleys} From ${placeText(state.start)} IRLS ends at ${placeText(run.x)}, ${kept}.`;
  if (run.cost > lowest.cost * (1 + 1e-6) + 1e-9) {
    return `${walk} It costs ${placeText(run.cost)} there; the lowest cost is ${placeText(lowest.cost)}, at ${placeText(lowest.x)}.`;
  }
  return `${walk} No x has a lower cost than ${placeText(run.cost)}.`;
}
