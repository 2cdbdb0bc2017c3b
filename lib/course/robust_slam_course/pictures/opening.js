import { gnc } from "../canvas/js/solve/graduation.js";
import { CHI_99_SE2, graphWithWrong, leastSquares, poseGraphProblem } from "../canvas/js/solve/pose_graph.js";
import { putLegend } from "../canvas/js/draw/legend.js";
import { possibleJoins } from "../canvas/js/draw/link.js";
import { audiblePicture } from "../canvas/js/draw/listen.js";
import { fitAround, putClosureHandles, putDrive, putEdge } from "../canvas/js/draw/map.js";

/** A drive through a town, correct closures, and wrong ones, which join the map when they are moved. */
export function render(context) {
  return audiblePicture(context, {
    layers: ["ghost", "edges", "drive", "wrong"],
    controls: [
      { kind: "toggle", name: "robust", label: "Reject outliers (GNC)" },
      { kind: "button", label: "Add a wrong closure", does: addWrongClosure, when: (state) => state.wrong.length < MOST_WRONG },
    ],
    main: ["robust"],
    joins: true,
    clean: cleanOpening,
    solve: solveOpening,
    moving: (result) => result.poses,
    draw: drawOpening,
    caption: openingCaption,
  });
}

const MOST_WRONG = 6;

function cleanOpening(state, data) {
  const wrong = possibleJoins(state.wrong, data.truth.length / 3 - 1, 2, MOST_WRONG);
  return { ...state, wrong, joined: Boolean(state.joined) };
}

// Far from each other and from the first: each new one folds another part of the map.
function addWrongClosure(state, result) {
  const count = result.poses.length / 3;
  const k = state.wrong.length;
  const from = (13 + 29 * k) % count;
  return { wrong: [...state.wrong, [from, (from + Math.floor(count / 2) + 7 * k) % count]], joined: true };
}

function solveOpening(state, data) {
  const graph = graphWithWrong(data, { edges: state.joined ? state.wrong : [] });
  const problem = poseGraphProblem(graph);
  const result = state.robust
    ? gnc(problem, CHI_99_SE2, "tls", problem.guess)
    : leastSquares(problem);
  const poses = state.robust ? result.x : result.poses;
  const weights = state.robust ? result.weights : new Float64Array(graph.m).fill(1);
  return { poses, weights, heard: { graph, poses, weights, map: "map" }, farthest: farthestPose(poses, data.truth) };
}

/** The largest distance (m) of a pose from its true place. */
function farthestPose(poses, truth) {
  let most = 0;
  for (let k = 0; k < poses.length; k += 3) {
    most = Math.max(most, Math.hypot(poses[k] - truth[k], poses[k + 1] - truth[k + 1]));
  }
  return most;
}

function drawOpening(scene, { state, result, shown, width, height, data, change }) {
  const top = putLegend(scene, "ghost", "legend", 0, 2, width, [
    ["is-ghost", "true path"], ["is-estimate", "map"], ["is-inlier", "correct closure"],
    ["is-outlier", "wrong closure"], ["is-rejected", "rejected"],
  ]);
  const box = { x: 0, y: top, width, height: height - top };
  const map = fitAround(scene, "map", box, data.truth, result.poses, Math.min(56, 0.1 * width));
  for (const layer of ["edges", "drive"]) scene.clip(layer, box);
  putDrive(scene, "ghost", "truth", map, data.truth, "is-ghost");
  data.edges.forEach((edge, k) => {
    if (data.trusted[k]) return;
    const look = result.weights[k] > 0.5 ? "is-inlier" : "is-rejected";
    putEdge(scene, "edges", `edge-${k}`, map, shown, edge, look);
  });
  putDrive(scene, "drive", "map", map, shown, "is-estimate");
  state.wrong.forEach((edge, k) => {
    const kept = !state.joined || result.weights[data.edges.length + k] > 0.5;
    putEdge(scene, "wrong", `wrong-${k}`, map, data.truth, edge, kept ? "is-outlier" : "is-rejected", 3);
  });
  putClosureHandles(scene, map, data.truth, state.wrong, (wrong) => change({ wrong, joined: true }), {
    noun: "Wrong closure",
  });
}

function openingCaption({ state, result, data }) {
  const count = state.joined ? state.wrong.length : 0;
  const off = `the farthest pose is ${result.farthest.toFixed(1)}\u00a0m from its true place`;
  if (!count) return `The dashed closure does not take part yet${state.robust ? " in what GNC sees" : ""}: ${off}.`;
  const wrong = count === 1 ? "the wrong closure" : `${count} wrong closures`;
  if (!state.robust) return `Least squares trusts ${wrong}: ${off}.`;
  const kept = state.wrong.filter((_, k) => result.weights[data.edges.length + k] > 0.5).length;
  return `GNC ${kept ? `lets ${kept} of ${wrong} in` : `rejects ${wrong}`}: ${off}.`;
}
