import { gnc } from "../solve/graduation.js";
import { CHI_99_SE2, graphWithWrong, leastSquares, poseGraphProblem } from "../solve/pose_graph.js";
import { putLegend } from "../draw/legend.js";
import { possibleJoins } from "../draw/link.js";
import { audiblePicture } from "../draw/listen.js";
import { fitAround, putClosureHandles, putDrive, putEdge } from "../draw/map.js";

/** A drive through a town, correct closures, and wrong ones that the reader moves. */
export function render(context) {
  return audiblePicture(context, {
    layers: ["ghost", "edges", "drive", "wrong"],
    controls: [
      { kind: "toggle", name: "robust", label: "Reject outliers (GNC)" },
      {
        kind: "button", label: "Add a wrong closure", does: addWrongClosure,
        when: (state) => state.wrong.length < MOST_WRONG,
      },
      {
        kind: "button", label: "Remove one", when: (state) => state.wrong.length > 0,
        does: (state) => ({ wrong: state.wrong.slice(0, -1) }),
      },
    ],
    main: ["robust"],
    clean: cleanOpening,
    solve: solveOpening,
    moving: (result) => result.poses,
    draw: drawOpening,
    caption: openingCaption,
  });
}

const MOST_WRONG = 6;

function cleanOpening(state, data) {
  return { ...state, wrong: possibleJoins(state.wrong, data.truth.length / 3 - 1, 2, MOST_WRONG) };
}

// Far from each other and from the first: each new one folds another part of the map.
function addWrongClosure(state, result) {
  const count = result.poses.length / 3;
  const k = state.wrong.length;
  const from = (13 + 29 * k) % count;
  return { wrong: [...state.wrong, [from, (from + Math.floor(count / 2) + 7 * k) % count]] };
}

function solveOpening(state, data) {
  const graph = graphWithWrong(data, { edges: state.wrong });
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
  const map = fitAround(scene, "map", box, data.truth, result.poses);
  for (const layer of ["edges", "drive"]) scene.clip(layer, box);
  putDrive(scene, "ghost", "truth", map, data.truth, "is-ghost");
  data.edges.forEach((edge, k) => {
    if (data.trusted[k]) return;
    const look = result.weights[k] > 0.5 ? "is-inlier" : "is-rejected";
    putEdge(scene, "edges", `edge-${k}`, map, shown, edge, look);
  });
  putDrive(scene, "drive", "map", map, shown, "is-estimate");
  state.wrong.forEach((edge, k) => {
    const kept = result.weights[data.edges.length + k] > 0.5;
    putEdge(scene, "wrong", `wrong-${k}`, map, data.truth, edge, kept ? "is-outlier" : "is-rejected", 3);
  });
  putClosureHandles(scene, map, data.truth, state.wrong, (wrong) => change({ wrong }), {
    noun: "Wrong closure",
  });
}

function openingCaption({ state, result, data }) {
  const count = state.wrong.length;
  const wrong = count === 1 ? "1 wrong closure" : `${count || "no"} wrong closures`;
  const off = `The farthest pose is ${result.farthest.toFixed(1)}\u00a0m from its true place.`;
  const correct = data.trusted.length - data.trusted.reduce((sum, value) => sum + value, 0);
  if (!state.robust) {
    return `Least squares gives all ${correct} correct closures and ${wrong} the same weight. ${off}`;
  }
  const rejected = state.wrong.filter((_, k) => result.weights[data.edges.length + k] <= 0.5).length;
  const kept = data.trusted.filter((value, k) => !value && result.weights[k] > 0.5).length;
  return `Of ${wrong}, GNC rejects ${rejected}; it keeps ${kept} of ${correct} correct closures. ${off}`;
}
