import { MAP_LEGEND, putLegend } from "../../canvas/js/draw/legend.js";
import { putHandle } from "../../canvas/js/draw/handle.js";
import { boundedNumber } from "../../canvas/js/draw/link.js";
import { livePicture } from "../../canvas/js/draw/picture.js";
import { fitAround, posePixels, putClosureHandles, putDrive, putEdge } from "../../canvas/js/draw/map.js";
import { pathThrough } from "../../canvas/js/draw/scene.js";
import { attackedMap } from "./attack.js";
import { alignPoses } from "../../canvas/js/solve/metrics.js";

/**
 * A game: the reader tells a solver where a part of a small town is not, in as few closures. Each offset
 * that was tried leaves a mark, the larger the more the map was bent.
 */
export function render(context) {
  const { towns, most } = context.model.get("data");
  const solved = new Map(); // by score
  return livePicture(context, {
    layers: ["ghost", "edges", "drive", "wrong"],
    controls: [
      { kind: "choice", name: "solver", label: "Fool", options: Object.entries(SOLVER_NAMES) },
      { kind: "slider", name: "count", label: "Outliers", min: 1, max: most, step: 1, text: String },
      { kind: "choice", name: "town", label: "Town", options: Object.keys(towns).map((name) => [name, name]) },
    ],
    main: ["count", "solver"],
    clean: (state, data) => cleanAttack(state, data, solved),
    solve: (state, data) => solveAttack(state, data, solved),
    moving: ({ poses }) => poses,
    draw: drawAttack,
    caption: attackCaption,
  });
}

const SOLVER_NAMES = {
  squares: "least squares", gm: "Geman–McClure", gnc: "GNC", pcm: "PCM + GNC",
};

function cleanAttack(state, data, solved) {
  const { towns, reach } = data;
  const whole = (value, low, high) => boundedNumber(value, [low, high], low, 0);
  const { town, count } = state;
  const j = whole(state.ends[1], 2, towns[town].truth.length / 3 - count);
  const offset = [0, 1].map((axis) => whole(state.offset[axis], -reach, reach));
  const next = { ...state, ends: [whole(state.ends[0], 0, j - 2), j], offset: offset.some(Boolean) ? offset : [1, 0] };
  const bent = Number(solveAttack(next, data, solved).bent.toFixed(2));
  const place = scoreOf({ ...next, offset: [] });
  return { ...next, tried: { ...state.tried, [place]: { ...state.tried[place], [next.offset]: bent } } };
}

function solveAttack(state, data, solved) {
  const [score, town] = [scoreOf(state), data.towns[state.town]];
  if (!solved.has(score)) {
    const found = attackedMap(town, state);
    solved.set(score, { ...found, poses: alignPoses(found.poses, town.truth), fooled: found.bent > data.bound });
  }
  return solved.get(score);
}

/** The score as `robust-slam replay` reads it. */
function scoreOf({ town, solver, ends, offset, count }) {
  return `${town}:${solver}:${ends.join("-")}:${offset.join(",")}:${count}`;
}

function drawAttack(scene, { state, result, shown, width, height, data, change }) {
  const { truth, edges, trusted } = data.towns[state.town];
  const top = putLegend(scene, "ghost", "legend", 0, 2, width, [...MAP_LEGEND, ["is-rejected", "rejected"], ["is-accent", "offset"]]);
  const box = { x: 0, y: top, width, height: height - top - GAUGE };
  const [east, north] = state.offset;
  const claimed = truth.map((value, k) => value + [east, north, 0][k % 3]);
  const ends = claimed.slice(3 * state.ends[1], 3 * (state.ends[1] + state.count));
  const map = fitAround(scene, `map-${state.town}`, box, truth, [...result.poses, ...ends], 40);
  for (const layer of ["edges", "drive"]) scene.clip(layer, box);
  putDrive(scene, "ghost", "truth", map, truth, "is-ghost");
  const look = (k, kept) => (result.weights[k] > 0.25 ? kept : "is-rejected");
  edges.forEach((edge, k) => {
    if (!trusted[k]) putEdge(scene, "edges", `edge-${k}`, map, shown, edge, look(k, "is-inlier"));
  });
  putDrive(scene, "drive", "map", map, shown, "is-estimate");
  const [i, j] = state.ends;
  for (let k = 0; k < state.count; k += 1) {
    const [from, to, there] = [[truth, i], [truth, j], [claimed, j]].map(([poses, first]) => posePixels(map, poses, first + k));
    const kept = look(edges.length + k, "is-outlier");
    scene.path("wrong", `wrong-${k}`, `rs-edge ${kept}`, pathThrough([from, to]), 2.5);
    scene.path("wrong", `offset-${k}`, "is-accent", pathThrough([to, there]), 2);
  }
  putClosureHandles(scene, map, truth, [state.ends], ([ends]) => change({ ends }), {
    noun: "Outlier", removable: false, last: truth.length / 3 - state.count,
  });
  const bends = Object.entries(state.tried[scoreOf({ ...state, offset: [] })]);
  for (const [offset, bend] of bends) {
    const [right, up] = offset.split(",").map(Number);
    const [cx, cy] = [map.toX(truth[3 * j] + right), map.toY(truth[3 * j + 1] + up)];
    scene.put("wrong", `tried-${offset}`, "circle", { class: bend ? "is-outlier" : "is-muted", cx, cy, r: 3 + 12 * bend, style: SOLID });
  }
  putGauge(scene, { y: height - 14, width }, bends, result.bent, data.bound);
  putOffset(scene, map, claimed, state, data.reach, change);
}

const [GAUGE, MOST_BENT, SOLID] = [44, 1, "fill:var(--look);fill-opacity:0.3;stroke-dasharray:none"]; // pixels, m

/** How far the attacks that were tried bent the map, and from where on a solver is fooled. */
function putGauge(scene, { y, width }, bends, bent, bound) {
  const toX = (bend) => 8 + (Math.min(bend, MOST_BENT) / MOST_BENT) * (width - 16);
  scene.path("wrong", "gauge", "is-muted", `M8 ${y}H${toX(MOST_BENT)}`, 1.5);
  scene.path("wrong", "bound", "is-ink", `M${toX(bound)} ${y - 12}v20`, 2);
  scene.text("wrong", "gauge-text", 0, y - 14, "map bent by 0 m");
  scene.text("wrong", "bound-text", toX(bound) + 8, y - 14, `fooled from ${bound} m`);
  for (const [offset, bend] of bends) {
    scene.put("wrong", `bent-${offset}`, "circle", { class: "rs-open is-outlier", cx: toX(bend), cy: y, r: 5, style: SOLID });
  }
  scene.path("wrong", "bent", "rs-full is-estimate", `M${toX(bent)} ${y - 8}l8 8l-8 8l-8 -8Z`);
}

/** The handle where pose j is claimed to be; an offset of nothing is stepped over. */
function putOffset(scene, map, claimed, { ends: [, j], offset }, reach, change) {
  const [x, y] = posePixels(map, claimed, j);
  const near = (value) => Math.max(-reach, Math.min(reach, value));
  const to = (wanted) => wanted.some(Boolean) && change({ offset: wanted.map(near) });
  putHandle(scene, "offset", {
    x, y, shape: "square", look: "rs-wrong", label: "Offset",
    text: `${offset[0]} m east, ${offset[1]} m north`, now: Math.hypot(...offset), least: 0, most: Math.hypot(reach, reach),
    drag: (px, py) => to([
      Math.round(map.fromX(px) - claimed[3 * j] + offset[0]), Math.round(map.fromY(py) - claimed[3 * j + 1] + offset[1]),
    ]),
    step: (right, up) => {
      const wanted = [offset[0] + right, offset[1] + up];
      to(wanted.some(Boolean) ? wanted : [right, up].map(Math.sign));
    },
  });
}

function attackCaption({ state, result: { fooled, bent }, data, picture }) {
  const told = (count, far) => `${count} ${count === 1 ? "outlier" : "outliers"} with an offset of ${far.toFixed(2)}\u00a0m`;
  const mine = told(state.count, Math.hypot(...state.offset));
  const does = `${mine} ${state.count === 1 ? "bends" : "bend"} the map by ${bent.toFixed(2)}\u00a0m`;
  const score = `To hand in: ${scoreOf(state)}`;
  if (!fooled) return `Not fooled: ${does}, and it takes more than ${data.bound}\u00a0m. ${score}`;
  const best = told(...(data.best[`${state.town}:${state.solver}`] ?? [state.count, Math.hypot(...state.offset)]));
  if (best === mine) return `Fooled: ${does}. No attack does it with less. ${score}`;
  // The question asks for the best attack.
  const less = picture.querySelector(".rs-predict:not([data-waits]) :checked") ? `The best attack has ${best}.` : "Can fewer do it, or a shorter offset?";
  return `Fooled: ${does}. ${less} ${score}`;
}
