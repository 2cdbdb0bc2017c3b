import { putAxes } from "../canvas/js/draw/axes.js";
import { numberText } from "../canvas/js/draw/number.js";
import { putHandle } from "../canvas/js/draw/handle.js";
import { MAP_LEGEND, putLegend } from "../canvas/js/draw/legend.js";
import { fitAround, putDrive, putEdge } from "../canvas/js/draw/map.js";
import { putMarker } from "../canvas/js/draw/marker.js";
import { livePicture } from "../canvas/js/draw/picture.js";
import { twoPanels } from "../canvas/js/draw/stage.js";
import { alignPoses, ate } from "../canvas/js/solve/metrics.js";
import { CHI_99_SE2, graphResidualNorms, graphWithWrong, poseGraphProblem } from "../canvas/js/solve/pose_graph.js";
import { switchesWithPriors } from "../canvas/js/solve/priors.js";

/** A map whose closures claim that they are inliers; the reader drags how sure they are. */
export function render(context) {
  return livePicture(context, {
    layers: ["ghost", "edges", "drive", "axes", "points", "words"],
    controls: [
      {
        kind: "slider", name: "odds", label: "Claimed log-odds of each closure", min: 0, max: MOST_ODDS, step: 1,
        text: (odds) => `${odds} (${claim(odds)})`,
      },
      { kind: "toggle", name: "score", label: "add the log-odds of its score" },
    ],
    main: ["odds"],
    solve: solvePriors,
    moving: ({ poses, powers }) => Float64Array.from([...poses, ...powers]),
    draw: drawPriors,
    caption: priorsCaption,
  });
}

const MOST_ODDS = 45;
const LAMBDA = CHI_99_SE2 ** 2;
const USED_FROM = 0.25; // the weight of a closure whose switch is one half

/** The probability with these log-odds, as a reader's text. */
function claim(odds) {
  const miss = 1 / (1 + Math.exp(odds));
  if (miss > 0.0005) return `${numberText(100 * (1 - miss))} %`;
  return `all but 1 in 10${superscript(Math.round(-Math.log10(miss)))}`;
}

function superscript(whole) {
  return [...String(whole)].map((digit) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[digit]).join("");
}

function solvePriors({ odds, score }, data) {
  const graph = graphWithWrong(data, { edges: [] });
  const problem = poseGraphProblem(graph);
  const logOdds = data.logOdds.map((own) => odds + (score ? own : 0));
  const { x, weights } = switchesWithPriors(problem, LAMBDA, logOdds, problem.guess, { tol: 1e-2, maxIterations: 60 });
  const first = graph.m - logOdds.length;
  const norms = graphResidualNorms(graph, x).slice(first);
  const own = weights.slice(first);
  const poses = alignPoses(x, data.best);
  const used = (wrong) => own.filter((w, k) => data.outlier[k] === wrong && w >= USED_FROM).length;
  return {
    poses, off: ate(x, data.best), first, weights: own,
    powers: norms.map((norm) => Math.log10(Math.max(norm, 0.1))),
    knee: 0.5 * Math.log10(LAMBDA + 2 * odds), used: [used(0), used(1)],
  };
}

function drawPriors(scene, view) {
  const { width, data, result, shown } = view;
  const y = putLegend(scene, "words", "legend", 0, 0, width, [
    ["is-ghost", "best map"], ...MAP_LEGEND.slice(1), ["is-rejected", "switched off"],
  ]);
  const [left, right] = twoPanels({ x: 0, y, width, height: view.height - y }, [1, 1], 0.54);
  const map = fitAround(scene, "map", left, data.best, result.poses, 18);
  const poses = shown.subarray(0, data.best.length);
  putDrive(scene, "ghost", "best", map, data.best, "is-ghost");
  putDrive(scene, "drive", "map", map, poses, "is-estimate");
  data.outlier.forEach((wrong, k) => {
    const look = wrong ? "is-outlier" : "is-inlier";
    const used = result.weights[k] >= USED_FROM;
    putEdge(scene, "edges", `edge-${k}`, map, poses, data.edges[result.first + k], used ? look : "is-rejected", wrong ? 2.5 : 2);
  });
  drawKnee(scene, right, view, shown.subarray(data.best.length));
}

/** The residuals of the closures in two rows, and the one from which a switch is below one half. */
function drawKnee(scene, box, { state, result, data, change }, powers) {
  scene.text("words", "head", box.x + 62, box.y + 15, "closures; grey: switched off", "rs-head");
  const maps = putAxes(
    scene, "axes", "residuals", { x: box.x + 12, y: box.y + 18, width: box.width - 12, height: box.height - 18 },
    { domain: [-1.1, 2.3], ticks: [-1, 0, 1, 2], label: "residual u", text: (power) => numberText(10 ** power) },
    { domain: [0, 3], ticks: [1, 2], label: null, text: (at) => ["", "outliers", "inliers"][at] },
  );
  const rows = [[2, "inlier", "circle"], [1, "outlier", "diamond"]];
  powers.forEach((power, k) => {
    const [at, colour, shape] = rows[data.outlier[k]];
    const y = maps.toY(at + 0.28 * (((k * 7) % 11) / 10 - 0.5));
    putMarker(scene, "points", `closure-${k}`, maps.toX(power), y, shape, result.weights[k] >= USED_FROM ? colour : "muted");
  });
  const x = maps.toX(result.knee);
  const floor = maps.inner.y + maps.inner.height;
  scene.path("axes", "knee", "is-muted", `M${x} ${maps.inner.y}V${floor}`, 2);
  scene.text("words", "knee-text", x + 26, maps.toY(0.45) + 5, "s < ½ →");
  const to = (px) => 0.5 * (10 ** (2 * maps.fromX(px)) - LAMBDA);
  putHandle(scene, "odds", {
    x, y: maps.toY(0.45), label: "Claimed log-odds", text: `log-odds ${state.odds}`, now: state.odds, least: 0, most: MOST_ODDS,
    drag: (px) => change({ odds: to(px) }),
    step: (right, up) => change({ odds: state.odds + (right || up) }),
  });
}

function priorsCaption({ state, result: { used, off }, data }) {
  const all = [0, 1].map((wrong) => data.outlier.filter((each) => each === wrong).length);
  const score = state.score ? " and its score" : "";
  const lets = used[1] ? `lets ${used[1]} of ${all[1]} outliers in` : `keeps all ${all[1]} outliers out`;
  return `A claim of log-odds ${state.odds}${score} ${lets}, beside ${used[0]} of ${all[0]} inliers. The map is ${off.toFixed(2)}\u00a0m from the best one.`;
}
