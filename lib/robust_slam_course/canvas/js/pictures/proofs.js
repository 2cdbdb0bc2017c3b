import { putAxes } from "../draw/axes.js";
import { putLegend } from "../draw/legend.js";
import { audiblePicture } from "../draw/listen.js";
import { fitAround, putDrive, putEdge } from "../draw/map.js";
import { putMarker } from "../draw/marker.js";
import { stageHeight, twoPanels, WIDE } from "../draw/stage.js";
import { gnc } from "../solve/graduation.js";
import { irls } from "../solve/loop.js";
import { alignPoses, ate } from "../solve/metrics.js";
import { CHI_99_SE2, graphWithWrong, poseGraphProblem } from "../solve/pose_graph.js";

/**
 * The steps of a reweighting loop, each with the map of its weights and its certificate. The loop
 * runs here; the certificates are the library's, see `tools/data/labs.py`.
 */
export function render(context) {
  const runs = new Map();
  return audiblePicture(context, {
    layers: ["ghost", "edges", "drive", "axes", "points", "words"],
    controls: [
      {
        kind: "player", name: "step", label: "Step", count: (state, { last }) => last,
        text: (step, { now, last }) => `${now} of ${last}`,
      },
      {
        kind: "choice", name: "start", label: "Start from", options: [
          ["odometry", "odometry"], ["squares", "least squares"],
          ["twice", "headings wound twice"], ["thrice", "headings wound three times"],
        ],
      },
      { kind: "choice", name: "solver", label: "Solver", options: [["gnc", "GNC"], ["switches", "switches"]] },
    ],
    main: ["step", "start"],
    solve: (state, data) => solveProofs(state, data, runs),
    moving: ({ poses }) => poses,
    height: (width) => (width < WIDE ? 365 : stageHeight(width)),
    draw: drawProofs,
    caption: proofsCaption,
  });
}

const HALF_OPEN = 0.25; // the weight of a closure whose switch is one half

/** The steps of one run, computed once. */
function stepsOf({ solver, start }, data, runs) {
  const key = `${solver} ${start}`;
  if (!runs.has(key)) {
    const problem = poseGraphProblem(graphWithWrong(data, { edges: [] }), { tol: 1e-9, steps: 200 });
    const x0 = Float64Array.from(data.starts[start]);
    const found = solver === "gnc"
      ? gnc(problem, CHI_99_SE2, "tls", x0, { tol: 1e-6 })
      : irls(problem, "geman-mcclure", CHI_99_SE2, x0, { tol: 1e-6 });
    runs.set(key, { graph: problem.graph, history: found.history, gaps: data.proofs[key] });
  }
  return runs.get(key);
}

function solveProofs(state, data, runs) {
  const { graph, history, gaps } = stepsOf(state, data, runs);
  const last = gaps.length;
  const now = Math.min(state.step, last, history.length - 1);
  const off = (map) => ate(map, data.best);
  const { x, weights } = history[now];
  const poses = alignPoses(x, data.best);
  return {
    now, last, gaps, weights, poses, heard: { graph, poses, weights, map: "map" },
    off: off(x), lost: off(history.at(-1).x) > 0.1,
  };
}

function drawProofs(scene, view) {
  const { width, height, result, shown, data } = view;
  const [map, chart] = twoPanels({ x: 0, y: 0, width, height }, [1, 1], 0.56);
  const top = putLegend(scene, "words", "legend", map.x, map.y, map.width, [
    ["is-ghost", "best map"], ["is-estimate", "map"], ["is-inlier", "inlier"], ["is-outlier", "outlier"],
  ]);
  const box = { ...map, y: map.y + top, height: map.height - top };
  const fit = fitAround(scene, "map", box, data.best, result.poses, 16);
  putDrive(scene, "ghost", "best", fit, data.best, "is-ghost");
  putDrive(scene, "drive", "map", fit, shown, "is-estimate");
  data.edges.forEach((ends, k) => {
    if (data.trusted[k]) return;
    const look = data.outlier[k] ? "is-outlier" : "is-inlier";
    putEdge(scene, "edges", `edge-${k}`, fit, shown, ends, result.weights[k] >= HALF_OPEN ? look : "is-rejected", data.outlier[k] ? 3 : 2);
  });
  drawGaps(scene, chart, result);
}

/** The share of the cost that is not proved, over the steps. */
function drawGaps(scene, box, { gaps, now, last }) {
  scene.text("words", "head", box.x + 46, box.y + 15, "not proved, share of the cost", "rs-head");
  const maps = putAxes(
    scene, "axes", "gaps", { ...box, y: box.y + 18, height: box.height - 18 },
    { domain: [0.4, last + 0.6], label: "step", ticks: [1, Math.round((last + 1) / 2), last] },
    { domain: [-0.08, 1.08], label: "", ticks: [0, 0.5, 1] },
  );
  if (now > 0) {
    scene.path("axes", "now", "is-estimate", `M${maps.toX(now)} ${maps.inner.y}v${maps.inner.height}`, 2);
  }
  gaps.forEach((gap, k) => {
    const [shape, colour] = gap > 0 ? ["triangle", "outlier"] : ["circle", "inlier"];
    putMarker(scene, "points", `gap-${k}`, maps.toX(k + 1), maps.toY(gap), shape, colour);
  });
}

function proofsCaption({ result }) {
  const { now, last, gaps, off, lost } = result;
  const failed = gaps.filter((gap) => gap > 0).length;
  const proof = now === 0 ? "Step 0 is the start."
    : gaps[now - 1] > 0 ? `Step ${now} of ${last}: not certified, ${Math.round(100 * gaps[now - 1])} % of the cost is not proved.`
      : `Step ${now} of ${last}: certified, no map fits these weights better.`;
  const all = failed ? `${failed} of the ${last} certificates fail` : `all ${last} certificates succeed`;
  return `${proof} The map is ${off.toFixed(2)}\u00a0m from the best one. In this run ${all}, and it ends in a ${lost ? "lost" : "good"} map.`;
}
