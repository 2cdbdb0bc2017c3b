import { putLegend } from "../../canvas/js/draw/legend.js";
import { putHandle } from "../../canvas/js/draw/handle.js";
import { boundedNumber } from "../../canvas/js/draw/link.js";
import { livePicture } from "../../canvas/js/draw/picture.js";
import { fitAround, posePixels, putClosureHandles, putDrive, putEdge } from "../../canvas/js/draw/map.js";
import { pathThrough } from "../../canvas/js/draw/scene.js";
import { attackedMap } from "./attack.js";
import { alignPoses } from "../../canvas/js/solve/metrics.js";

/** A game: the reader tells a solver where a part of a small town is not, in as few closures. */
export function render(context) {
  const { towns, bound, most } = context.model.get("data");
  return livePicture(context, {
    layers: ["ghost", "edges", "drive", "wrong"],
    controls: [
      { kind: "choice", name: "solver", label: "Fool", options: Object.entries(SOLVER_NAMES) },
      { kind: "slider", name: "count", label: "Outliers", min: 1, max: most, step: 1, text: String },
      { kind: "choice", name: "town", label: "Town", options: Object.keys(towns).map((name) => [name, name]) },
    ],
    main: ["count", "solver"],
    clean: cleanAttack,
    solve: (state, data) => {
      const found = attackedMap(data.towns[state.town], state);
      const poses = alignPoses(found.poses, data.towns[state.town].truth);
      return { ...found, poses, fooled: found.bent > bound };
    },
    moving: ({ poses }) => poses,
    draw: drawAttack,
    caption: attackCaption,
  });
}

const SOLVER_NAMES = {
  squares: "least squares", gm: "Geman–McClure", gnc: "GNC", pcm: "PCM + GNC",
};

function cleanAttack(state, { towns, reach }) {
  const whole = (value, low, high) => boundedNumber(value, [low, high], low, 0);
  const { town, count } = state;
  const j = whole(state.ends[1], 2, towns[town].truth.length / 3 - count);
  const offset = [0, 1].map((axis) => whole(state.offset[axis], -reach, reach));
  return { ...state, ends: [whole(state.ends[0], 0, j - 2), j], offset: offset.some(Boolean) ? offset : [1, 0] };
}

/** The score as `robust-slam replay` reads it. */
function scoreOf({ town, solver, ends, offset, count }) {
  return `${town}:${solver}:${ends.join("-")}:${offset.join(",")}:${count}`;
}

function drawAttack(scene, { state, result, shown, width, height, data, change }) {
  const { truth, edges, trusted } = data.towns[state.town];
  const top = putLegend(scene, "ghost", "legend", 0, 2, width, [
    ["is-ghost", "true path"], ["is-estimate", "map"], ["is-inlier", "inlier"],
    ["is-outlier", "outlier"], ["is-rejected", "rejected"], ["is-accent", "offset"],
  ]);
  const box = { x: 0, y: top, width, height: height - top };
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
  putOffset(scene, map, claimed, state, data.reach, change);
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

function attackCaption({ state, result: { fooled, bent }, data }) {
  const told = (count, far) => `${count} ${count === 1 ? "outlier" : "outliers"} with an offset of ${far.toFixed(2)}\u00a0m`;
  const mine = told(state.count, Math.hypot(...state.offset));
  const does = `${mine} ${state.count === 1 ? "bends" : "bend"} the map by ${bent.toFixed(2)}\u00a0m`;
  const score = `Score: ${scoreOf(state)}`;
  if (!fooled) return `Not fooled: ${does}, and it takes more than ${data.bound}\u00a0m. ${score}`;
  // What is possible is told once the reader has fooled the solver.
  const best = told(...(data.best[`${state.town}:${state.solver}`] ?? [state.count, Math.hypot(...state.offset)]));
  return `Fooled: ${does}. ${best === mine ? "No attack does it with less" : `The best attack has ${best}`}. ${score}`;
}
