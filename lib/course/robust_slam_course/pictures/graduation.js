import { putAxes } from "../canvas/js/draw/axes.js";
import { numberText } from "../canvas/js/draw/number.js";
import { boundedNumber } from "../canvas/js/draw/link.js";
import { putEndLabels } from "../canvas/js/draw/labels.js";
import { fitMap } from "../canvas/js/draw/map.js";
import { putMarker } from "../canvas/js/draw/marker.js";
import { livePicture } from "../canvas/js/draw/picture.js";
import { pathThrough, setAttributes } from "../canvas/js/draw/scene.js";
import { posesOf } from "../canvas/js/draw/steps.js";
import { WIDE } from "../canvas/js/draw/stage.js";

/**
 * Small maps of ten towns in a table, two starts by IRLS and GNC, each by two costs. The reader makes
 * the odometry noisier, maps fold one by one, and the counts of rows and columns are drawn as far as
 * the noise has been. The maps are the library's, see `tools/data/graduation.py`.
 */
export function render(context) {
  const { noises } = context.model.get("data");
  const shapes = new Map(); // of maps by their letters and squares
  return livePicture(context, {
    layers: ["maps", "axes", "points", "words"],
    controls: [{
      kind: "slider", name: "noise", label: "Odometry noise", min: 0, max: noises.length - 1, step: 1,
      text: (noise) => `${noises[noise]} rad a step`,
    }],
    main: ["noise"],
    clean: ({ noise, tried }) => ({
      noise, tried: Math.max(noise, boundedNumber(tried, [0, noises.length - 1], 0, 0)),
    }),
    solve: solveGraduation,
    height: (width) => (width < WIDE ? 396 : 380),
    draw: (scene, view) => drawGraduation(scene, view, shapes),
    caption: graduationCaption,
  });
}

const STARTS = ["odometry", "least squares"];
const WAYS = ["IRLS", "GNC"];
const COSTS = ["TLS", "GM"];
/** Of rows and columns, whose counts are drawn over the noise. */
const MARGIN_LOOKS = [
  { name: "odometry", shape: "circle", colour: "ink", dash: "none" },
  { name: "least squares", shape: "square", colour: "ink", dash: "none" },
  { name: "IRLS", shape: "triangle", colour: "plum", dash: "6 4" },
  { name: "GNC", shape: "diamond", colour: "plum", dash: "6 4" },
];

/** The column of `lost` of a start, a way and a cost. */
function columnOf(start, way, cost) {
  return 4 * start + 2 * cost + way;
}

function solveGraduation({ noise }, { lost, noises }) {
  const good = (columns, at) => columns.reduce((sum, k) => sum + lost[k][at].filter((map) => !map).length, 0);
  const pairs = [0, 1].flatMap((one) => [0, 1].map((other) => [one, other]));
  const rows = [0, 1].map((start) => pairs.map(([way, cost]) => columnOf(start, way, cost)));
  const columns = [0, 1].map((way) => pairs.map(([start, cost]) => columnOf(start, way, cost)));
  const margins = [...rows, ...columns].map((each) => noises.map((_, at) => good(each, at)));
  return { margins, now: margins.map((counts) => counts[noise]), maps: lost.map((each) => each[noise]) };
}

function drawGraduation(scene, view, shapes) {
  const { width, height, data, result } = view;
  const [across, head, left] = [width < WIDE ? 5 : 10, 20, 36];
  const wide = 0.5 * (width - left);
  const size = Math.min(width < WIDE ? 28 : 36, (wide - 8) / across);
  const tall = (10 / across) * size;
  STARTS.forEach((start, row) => WAYS.forEach((way, column) => {
    const [x, y] = [left + column * wide, row * (COSTS.length * tall + head)];
    const blocks = COSTS.map((_, c) => result.maps[columnOf(row, column, c)]);
    const good = blocks.flat().filter((lost) => !lost).length;
    const narrow = column ? `${way} ${good} of 20` : `${start}: ${way} ${good}`;
    const [words, look] = width < WIDE ? [narrow, ""] : [`${way} from ${start}: ${good} of 20`, "rs-head"];
    scene.text("words", `head-${row}-${column}`, x, y + 14, words, look);
    blocks.forEach((maps, c) => {
      const top = y + head + c * tall;
      if (!column) scene.text("words", `cost-${row}-${c}`, 0, top + 0.5 * tall + 5, COSTS[c], "rs-tick");
      maps.forEach((lost, k) => {
        const corner = [x + (k % across) * size, top + Math.floor(k / across) * size, size];
        const letters = lost || data.towns[k];
        const key = `${letters} ${corner}`;
        if (!shapes.has(key)) shapes.set(key, shapeOf(corner, letters, data.towns[k], data.unit));
        const [fate, thick] = lost ? ["is-outlier", 0.9] : ["is-estimate", 1.5];
        const drawn = scene.path("maps", `town-${row}-${column}-${c}-${k}`, fate, shapes.get(key), thick);
        setAttributes(drawn, { style: "stroke-dasharray:none" });
      });
    });
  }));
  const top = 2 * (COSTS.length * tall + head) + 4;
  drawMargins(scene, { x: 0, y: top, width, height: height - top }, view);
}

/** The outline of a map in the square of its town, which it may not leave. */
function shapeOf([left, top, size], letters, town, unit) {
  const map = fitMap({ x: left, y: top, width: size, height: size }, posesOf(stepsFrom(town), unit), 3);
  const within = (value, low) => Math.min(low + size - 1, Math.max(low + 1, value));
  const poses = posesOf(stepsFrom(letters), unit);
  return pathThrough(Array.from({ length: poses.length / 3 }, (_, k) => [
    within(map.toX(poses[3 * k]), left), within(map.toY(poses[3 * k + 1]), top),
  ]));
}

/** Steps from letters, "N" for none. */
function stepsFrom(letters) {
  return Array.from(letters, (letter) => letter.charCodeAt(0) - 78);
}

function drawMargins(scene, box, { state, result, data }) {
  const last = data.noises.length - 1;
  const maps = putAxes(scene, "axes", "margins", { ...box, width: box.width - 124 },
    {
      domain: [-0.25, last + 0.25], label: "", ticks: data.noises.map((_, k) => k),
      text: (k) => (box.width < WIDE && k % 2 ? "" : numberText(data.noises[k])),
    },
    { domain: [-1, 41], label: "good", ticks: [0, 20, 40] });
  const x = maps.toX(state.noise);
  scene.path("axes", "now", "is-muted", `M${x} ${maps.inner.y}v${maps.inner.height}`, 1.5);
  // How much the start and the way decide, as bars from one floor.
  const gap = (one, at) => Math.abs(result.margins[one][at] - result.margins[one + 1][at]);
  [[0, -6], [2, 6]].forEach(([one, aside]) => {
    const colour = `var(--rs-${MARGIN_LOOKS[one].colour})`;
    const bars = data.noises.slice(0, state.tried + 1).map((_, at) => `M${maps.toX(at) + aside} ${maps.toY(0)}V${maps.toY(gap(one, at))}`);
    scene.put("points", `gap-${one}`, "path", { d: bars.join(""), style: `stroke:${colour};stroke-linecap:butt`, "stroke-width": 9 });
    const now = gap(one, state.noise);
    scene.put("words", `gap-text-${one}`, "text", {
      class: "rs-halo", x: x + 1.7 * aside, y: maps.toY(now) - 4, "text-anchor": "middle", style: `fill:${colour}`,
    }, String(now));
  });
  if (box.width >= WIDE) {
    scene.text("words", "bars", maps.inner.x + maps.inner.width, maps.inner.y + 14, "bars: saved by the better start, by GNC", "rs-tick", "end");
  }
  MARGIN_LOOKS.forEach(({ shape, colour, dash }, k) => {
    const counts = result.margins[k].slice(0, state.tried + 1);
    const points = counts.map((count, at) => [maps.toX(at), maps.toY(count)]);
    const style = `stroke:var(--rs-${colour});stroke-dasharray:${dash}`;
    scene.put("points", `line-${k}`, "path", { d: pathThrough(points), style, "stroke-width": 1.8 });
    points.forEach(([px, py], at) => putMarker(scene, "points", `at-${k}-${at}`, px, py, shape, colour));
  });
  const ends = MARGIN_LOOKS.map(({ name, colour }, k) => (
    { text: `${name} ${result.margins[k][state.tried]}`, colour, y: maps.toY(result.margins[k][state.tried]) }));
  const { inner } = maps;
  putEndLabels(scene, "words", "end", inner.x + inner.width + 8, ends, inner.y, inner.y + inner.height);
}

function graduationCaption({ state, result, data }) {
  const [odometry, squares, plain, graduated] = result.now;
  const more = (count, worse, better) => (count < 0 ? more(-count, better, worse)
    : `${count} more ${worse} than ${better}`);
  return `At ${numberText(data.noises[state.noise])} rad a step ${80 - odometry - squares} of the 80 maps are lost (orange): `
    + `${more(odometry - squares, "from least squares", "from odometry")}, and`
    + ` ${more(graduated - plain, "by IRLS", "by GNC")}.`;
}
