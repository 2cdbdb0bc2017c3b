import { MAP_LEGEND, putLegend } from "../canvas/js/draw/legend.js";
import { fitAround, putDrive, putEdge } from "../canvas/js/draw/map.js";
import { livePicture } from "../canvas/js/draw/picture.js";
import { posesOf } from "../canvas/js/draw/steps.js";
import { sideBySide, stageHeight, WIDE } from "../canvas/js/draw/stage.js";

/**
 * Two solvers of the library on one town, with as many outliers as the reader likes. The maps were
 * computed before: see `tools/data/arena.py`.
 */
export function render(context) {
  const { solvers, kinds } = context.model.get("data");
  const named = solvers.map((name) => [name, name]);
  return livePicture(context, {
    layers: ["ghost", "edges", "drive", "words"],
    controls: [
      { kind: "slider", name: "percent", label: "Outliers", min: 0, max: 90, step: 10, text: (percent) => `${percent} %` },
      { kind: "choice", name: "right", label: "Beside GNC", options: named },
      { kind: "choice", name: "kind", label: "Outliers are", options: kinds.map((kind) => [kind, kind]) },
    ],
    main: ["percent", "right"],
    height: (width) => (width < WIDE ? 280 : stageHeight(width)),
    solve: solveArena,
    moving: ({ runs }) => Float64Array.from(runs.flatMap(({ poses }) => poses)),
    draw: drawArena,
    caption: arenaCaption,
  });
}

function solveArena({ kind, percent, right }, { table, inliers, outliers, solvers }) {
  const runs = ["GNC", right].map((solver) => {
    const [number, letters, off, certified] = table.runs[`${kind} ${percent}`][solvers.indexOf(solver)];
    const used = [...letters].map((letter) => letter === "1");
    const count = (from, to) => used.slice(from, to).filter(Boolean).length;
    const kept = [count(0, inliers.length), count(inliers.length)];
    return { solver, poses: posesOf(table.maps[number], table.unit), off, certified: certified === 1, used, kept };
  });
  const told = runs[0].used.length - inliers.length;
  return { runs, told, closures: [...inliers, ...outliers[kind].slice(0, told)] };
}

function drawArena(scene, { width, height, data, result, shown }) {
  const legend = putLegend(scene, "words", "legend", 0, 0, width, MAP_LEGEND);
  const boxes = sideBySide({ x: 0, y: legend + 22, width, height: height - legend - 22 }, [1, 1]);
  const each = shown.length / 2;
  result.runs.forEach(({ solver, poses, off, used }, side) => {
    const map = fitAround(scene, `map-${side}`, boxes[side], data.truth, poses, 14);
    const own = shown.subarray(side * each, (side + 1) * each);
    const { x, width: wide } = boxes[side];
    scene.text("words", `head-${side}`, x + wide / 2, legend + 16, `${solver}: ${off.toFixed(2)} m`, "rs-head", "middle");
    putDrive(scene, "ghost", `truth-${side}`, map, data.truth, "is-ghost");
    putDrive(scene, "drive", `map-${side}`, map, own, "is-estimate");
    result.closures.forEach((ends, k) => {
      const look = k < data.inliers.length ? "is-inlier" : "is-outlier";
      putEdge(scene, "edges", `edge-${side}-${k}`, map, own, ends, used[k] ? look : "is-rejected", used[k] ? 2 : 0.6);
    });
  });
}

function arenaCaption({ state: { percent }, result: { runs, told } }) {
  const sides = runs.map(({ solver, kept, certified }) => {
    const lets = kept[1] ? `lets ${kept[1]} of ${told} outliers in` : "lets no outlier in";
    return `${solver} ${lets} and keeps ${kept[0]} inliers, ${certified ? "certified" : "not certified"}`;
  });
  return `At ${percent} %: ${sides.join("; ")}.`;
}
