import { putAxes } from "../canvas/js/draw/axes.js";
import { numberText } from "../canvas/js/draw/number.js";
import { putHandle } from "../canvas/js/draw/handle.js";
import { MAP_LEGEND, putLegend } from "../canvas/js/draw/legend.js";
import { boundedNumber } from "../canvas/js/draw/link.js";
import { fitMap, putDrive, putEdge } from "../canvas/js/draw/map.js";
import { livePicture } from "../canvas/js/draw/picture.js";
import { letterOf, painted, putRibbon } from "../canvas/js/draw/ribbon.js";
import { posesOf } from "../canvas/js/draw/steps.js";
import { twoPanels, WIDE } from "../canvas/js/draw/stage.js";

/**
 * Runs of a reweighting loop, each of whose steps is certified. The reader winds the headings from
 * which the loop starts, and for each start that was tried there is a column of certificates with
 * the fate of the map below. The runs are the library's, see `robust_slam_course.labs`.
 */
export function render(context) {
  return livePicture(context, {
    layers: ["ghost", "edges", "drive", "axes", "columns", "words"],
    controls: [{ kind: "words", name: "solver", label: "Solver", options: [["gnc", "GNC"], ["switches", "Switches"]] }],
    main: ["solver"],
    clean: cleanProofs,
    solve: ({ solver, wound }, { runs, unit }) => {
      const run = runs[solver][wound];
      return { ...run, poses: posesOf(run.steps, unit), failed: run.signs.replaceAll(".", "").length };
    },
    moving: ({ poses }) => Float64Array.from(poses),
    height: (width) => (width < WIDE ? 390 : 380),
    draw: drawProofs,
    caption: proofsCaption,
  });
}

const GOOD_MAP = 0.1; // m from the map of the inliers, at most

function cleanProofs({ solver, wound, tried }, { runs, turns }) {
  const now = boundedNumber(wound, [0, turns.length - 1], 0, 0);
  const letter = letterOf(runs[solver][now].off > GOOD_MAP);
  return { solver, wound: now, tried: { ...tried, [solver]: painted(tried[solver], turns.length, now, letter) } };
}

function drawProofs(scene, view) {
  const { width, height, result, shown, data } = view;
  const [left, right] = twoPanels({ x: 0, y: 0, width, height }, [1, 1.2], 0.46);
  const top = putLegend(scene, "words", "legend", left.x, left.y, left.width, [["is-ghost", "best map"], ...MAP_LEGEND.slice(1)]);
  const key = `map ${width}`;
  if (!scene.fits.has(key)) {
    const all = Object.values(data.runs).flat().flatMap(({ steps }) => posesOf(steps, data.unit));
    scene.fits.set(key, fitMap({ ...left, y: left.y + top, height: left.height - top }, all, 8));
  }
  const fit = scene.fits.get(key);
  putDrive(scene, "ghost", "best", fit, data.best, "is-ghost");
  putDrive(scene, "drive", "map", fit, shown, "is-estimate");
  data.closures.forEach((ends, k) => {
    const outlier = k >= data.inliers;
    const look = result.used[k] === "1" ? (outlier ? "is-outlier" : "is-inlier") : "is-rejected";
    putEdge(scene, "edges", `edge-${k}`, fit, shown, ends, look, outlier ? 3 : 2);
  });
  drawColumns(scene, right, view);
}

const FATE = 20; // pixels of the row of fates

/** A column for each start that was tried: its certificates from below, and the fate of its map. */
function drawColumns(scene, box, { state, data, change }) {
  const [runs, last] = [data.runs[state.solver], data.turns.length - 1];
  const most = Math.max(...Object.values(data.runs).flat().map(({ signs }) => signs.length));
  scene.text("words", "head", box.x + 34, box.y + 15, "certificates of the steps", "rs-head");
  const maps = putAxes(scene, "axes", "steps", { ...box, y: box.y + 20, height: box.height - 62 - FATE },
    { domain: [-0.5, last + 0.5], label: "", ticks: [] }, { domain: [0, most + 1], label: "", ticks: [1, 10, 20] });
  const { inner } = maps;
  const floor = inner.y + inner.height;
  const [certified, fails] = [[], []];
  const half = Math.min(8, 0.36 * (inner.width / (last + 1)));
  [...state.tried[state.solver]].forEach((letter, k) => {
    if (letter === ".") return;
    const x = maps.toX(k);
    [...runs[k].signs].forEach((sign, step) => {
      const y = maps.toY(step + 1);
      if (sign === ".") certified.push(`M${x - half} ${y}h${2 * half}`);
      else fails.push(`M${x - half} ${y - 3}l${2 * half} 6m0 -6l${-2 * half} 6`);
    });
  });
  scene.path("columns", "certified", "is-ink", certified.join(""), 2.5);
  scene.put("columns", "fails", "path", {
    class: "is-outlier", d: fails.join(""), "stroke-width": 2, style: "stroke-dasharray:none",
  });
  scene.text("words", "fate", inner.x - 4, floor + FATE - 2, "map", "rs-tick", "end");
  putRibbon(scene, "columns", "fates", { ...inner, y: floor + 6, height: FATE - 6 }, state.tried[state.solver]);
  const line = floor + FATE + 18;
  scene.path("axes", "track", "is-muted", `M${inner.x} ${line}H${inner.x + inner.width}`, 2);
  const turn = (to) => change({ wound: Math.min(last, Math.max(0, Math.round(to))) });
  const text = `wound by ${numberText(data.turns[state.wound])} turns`;
  const x = maps.toX(state.wound);
  const atLeft = state.wound > last / 2;
  scene.text("words", "turns", x + (atLeft ? 8 : -8), line + 24, text, "", atLeft ? "end" : "start");
  putHandle(scene, "wound", {
    x, y: line, label: "Turns by which the start is wound", text,
    now: data.turns[state.wound], least: data.turns[0], most: data.turns[last],
    unit: (data.turns[last] - data.turns[0]) / last,
    drag: (px) => turn(maps.fromX(px)), step: (rightwards, up) => turn(state.wound + (rightwards || up)),
  });
}

function proofsCaption({ state, result: { signs, failed, off }, data }) {
  const start = state.wound ? `Wound by ${numberText(data.turns[state.wound])} turns, ` : "From odometry ";
  const lost = off > GOOD_MAP;
  const end = `the map ends ${lost ? "lost" : "good"}, ${off.toFixed(2)}\u00a0m off.`;
  if (failed) return `${start}${failed} of the ${signs.length} certificates fail, and ${end}`;
  return `${start}all ${signs.length} certificates succeed, and ${lost ? "yet " : ""}${end}`;
}
