import { numberText } from "../canvas/js/draw/number.js";
import { possibleJoins } from "../canvas/js/draw/link.js";
import { audiblePicture } from "../canvas/js/draw/listen.js";
import { fitMap, posePixels, putClosureHandles, putDrive, putEdge } from "../canvas/js/draw/map.js";
import { setAttributes } from "../canvas/js/draw/scene.js";
import { stageHeight, twoPanels, WIDE } from "../canvas/js/draw/stage.js";
import { putStrip } from "../canvas/js/draw/strip.js";
import { alignPoses, ate } from "../canvas/js/solve/metrics.js";
import {
  CHI_99_SE2, graphResidualNorms, graphWithWrong, leastSquares, poseGraphProblem,
} from "../canvas/js/solve/pose_graph.js";

/**
 * A town in which the reader moves a wrong closure. Each edge has the colour and the width of its
 * whitened residual, so that the edges which share a cycle with the wrong closure stand out.
 */
export function render(context) {
  const undisturbed = new Map(); // without the wrong closure, by whether there are correct ones
  return audiblePicture(context, {
    layers: ["ghost", "edges", "drive", "wrong", "strip"],
    controls: [
      { kind: "toggle", name: "correct", label: "Correct closures" },
      {
        kind: "slider", name: "sigma", label: "σ of the wrong closure", min: 0.01, max: 1, step: 0.01,
        log: true, text: (value) => `${numberText(value, 2)} m`,
      },
    ],
    main: ["correct"],
    clean: cleanCycles,
    solve: (state, data) => solveCycles(state, data, undisturbed),
    moving: (result) => result.poses,
    height: (width) => (width < WIDE ? 405 : stageHeight(width)),
    draw: drawCycles,
    caption: cyclesCaption,
  });
}

const ROOM = 1.9; // m around the true path, whatever bends: a scale that changes would hide how much
const CHANGED = 0.005; // a residual that moved by more than this, in standard deviations

function cleanCycles(state, data) {
  const [wrong = [36, 69]] = possibleJoins([state.wrong], data.truth.length / 3 - 1, 2, 1);
  return { ...state, wrong };
}

/** The edges of the map, without its correct closures if so chosen, and the wrong ones. */
function joinedGraph(data, correct, joins, sigma) {
  const stiff = [1 / sigma ** 2, 1 / sigma ** 2, 1 / (data.turn * sigma) ** 2];
  const information = [stiff[0], 0, 0, 0, stiff[1], 0, 0, 0, stiff[2]];
  const taken = [...data.edges, ...joins].map((_, k) => k).filter((k) => correct || data.trusted[k] !== 0);
  return graphWithWrong(data, { edges: joins, information }, taken);
}

/** Least squares on `graph`, from dead reckoning: the poses and the norm of each residual. */
function squaresOf(graph) {
  const { poses } = leastSquares(poseGraphProblem(graph));
  return { poses, norms: graphResidualNorms(graph, poses) };
}

function solveCycles({ wrong, correct, sigma }, data, undisturbed) {
  if (!undisturbed.has(correct)) {
    undisturbed.set(correct, squaresOf(joinedGraph(data, correct, [], sigma)).norms);
  }
  const before = undisturbed.get(correct);
  const graph = joinedGraph(data, correct, [wrong], sigma);
  const { poses: held, norms } = squaresOf(graph);
  const poses = alignPoses(held, data.truth);
  const steps = data.truth.length / 3 - 1;
  return {
    poses, norms, graph, steps, closures: before.length - steps,
    heard: { graph, poses, map: "town" },
    changed: before.reduce((sum, norm, k) => sum + (Math.abs(norms[k] - norm) > CHANGED), 0),
    off: ate(held, data.truth),
  };
}

/** 0 for a residual of half a standard deviation or less, 1 from eight on, in twentieths. */
function heatOf(norm) {
  return Math.round(20 * Math.min(1, Math.max(0, Math.log(norm / 0.5) / Math.log(16)))) / 20;
}

/** From blue through purple to orange: none of the colours between is grey. */
function heatStyle(norm) {
  const percent = Math.round(200 * heatOf(norm));
  const [colour, other] = percent > 100 ? ["outlier", "accent"] : ["accent", "estimate"];
  return `stroke:color-mix(in srgb,var(--rs-${colour}) ${percent > 100 ? percent - 100 : percent}%,var(--rs-${other}))`;
}

function drawCycles(scene, { result, state, shown, width, height, data, change }) {
  const { truth } = data;
  const [left, right] = twoPanels({ x: 0, y: 0, width, height }, [1.25, 1], 0.66);
  const box = { ...left, y: 22, height: left.height - 22 };
  const map = fitMap(box, truth, 6, ROOM);
  scene.fits.set("town", map);
  putDrive(scene, "ghost", "truth", map, truth, "is-ghost");
  putHeatedEdges(scene, box, map, shown, result);
  putEdge(scene, "wrong", "wrong", map, truth, state.wrong, "is-outlier", 3);
  scene.text("strip", "key", 2, 14, "dotted: true path; colour: u", "rs-tick");
  putStrip(scene, "strip", "norms", right, residualGroups(result), {
    domain: [0.1, 100], ticks: [0.1, 1, 10, 100], label: "whitened residual u; line: 99 % of inliers", line: CHI_99_SE2,
  });
  putClosureHandles(scene, map, truth, [state.wrong], ([wrong]) => change({ wrong }), {
    noun: "Wrong closure", removable: false,
  });
}

/** The edges that are within the box: those that wrong closures swing farther run out of the picture. */
function putHeatedEdges(scene, box, map, shown, { graph, norms, steps, closures }) {
  const isWithin = ([x, y]) => (
    x > box.x && x < box.x + box.width && y > box.y && y < box.y + box.height);
  for (let k = 0; k < steps + closures; k += 1) {
    const ends = [graph.tail[k], graph.head[k]];
    if (!ends.every((pose) => isWithin(posePixels(map, shown, pose)))) continue;
    const wide = (k < steps ? 2 : 1.2) * (1 + 1.5 * heatOf(norms[k]));
    const layer = k < steps ? "drive" : "edges";
    const edge = putEdge(scene, layer, `edge-${k}`, map, shown, ends, "is-estimate", wide.toFixed(1));
    setAttributes(edge, { style: heatStyle(norms[k]) });
  }
}

function residualGroups({ norms, steps, closures }) {
  const others = steps + closures;
  const bars = (from, to) => Array.from(norms.subarray(from, to), (value, k) => (
    { value, style: heatStyle(value), part: from < others ? `edge-${from + k}` : "wrong" }));
  const groups = [{ name: "odometry", share: 5, bars: bars(0, steps) }];
  if (closures) groups.push({ name: "correct", share: 2.3, bars: bars(steps, others) });
  return [...groups, { name: "wrong", share: 2, bars: bars(others, norms.length) }];
}

function cyclesCaption({ result }) {
  const { norms, steps, closures, changed, off } = result;
  const others = steps + closures;
  const largest = norms[others];
  const worse = norms.subarray(0, others).reduce((sum, norm) => sum + (norm > largest), 0);
  const hides = worse ? `It hides behind ${worse} that look worse` : "None of them looks worse than it";
  return `The wrong closure bends ${changed === others ? "all" : `${changed} of`} the ${others} other edges. `
    + `${hides}, and the map is ${off.toFixed(2)}\u00a0m off.`;
}
