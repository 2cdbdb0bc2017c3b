import { fitAround, posePixels, putClosureHandles, putDrive, putEdge } from "../canvas/js/draw/map.js";
import { boundedNumber } from "../canvas/js/draw/link.js";
import { livePicture } from "../canvas/js/draw/picture.js";
import { twoPanels } from "../canvas/js/draw/stage.js";
import { agreeingClosures } from "../canvas/js/solve/aliasing.js";
import { pcm } from "../canvas/js/solve/consistency.js";
import { irls } from "../canvas/js/solve/loop.js";
import { alignPoses, ate } from "../canvas/js/solve/metrics.js";
import { graphWithWrong, leastSquares, poseGraphProblem } from "../canvas/js/solve/pose_graph.js";

/**
 * Closures on a map, correct ones and wrong ones that agree and that the reader moves; which of all
 * agree, as a graph with its largest clique.
 */
export function render(context) {
  return livePicture(context, {
    layers: ["ghost", "edges", "drive", "wrong", "pairs", "members", "vertices", "words"],
    controls: [
      { kind: "slider", name: "count", label: "Wrong closures", min: 0, max: MOST_WRONG_CLOSURES, step: 1, text: String },
      { kind: "choice", name: "map", label: "Map by", options: [["pcm", "PCM"], ["switches", "switches, λ = γ²"]] },
    ],
    main: ["count"],
    clean: cleanConsistency,
    solve: solveConsistency,
    moving: (result) => result.shown,
    draw: drawConsistency,
    caption: consistencyCaption,
  });
}

const MOST_WRONG_CLOSURES = 10;

function cleanConsistency(state, data) {
  const last = data.truth.length / 3 - Math.max(1, state.count);
  const [tail, head] = [0, 1].map((end) => boundedNumber(state.group[end], [0, last], 0, 0));
  return { ...state, group: Math.abs(tail - head) >= 2 ? [tail, head] : [tail, tail > 1 ? tail - 2 : tail + 2] };
}

function solveConsistency({ group, count, map }, data) {
  const wrong = agreeingClosures(data.truth, group, count);
  const graph = graphWithWrong(data, wrong);
  const agreement = pcm(graph, data.gamma);
  const { closures, clique, adjacency } = agreement;
  const found = map === "pcm" ? agreedByPcm(data, wrong, agreement) : keptBySwitching(graph, data.gamma);
  return {
    clique, adjacency, shown: alignPoses(found.poses, data.truth), off: ate(found.poses, data.truth),
    correct: closures.length - wrong.edges.length,
    ends: closures.map((edge) => [graph.tail[edge], graph.head[edge]]),
    isMember: closures.map((_, place) => clique.includes(place)),
    used: closures.map((edge) => found.weights[edge] >= 0.25),
  };
}

function agreedByPcm(data, wrong, { kept: weights }) {
  const agreed = [...weights.keys()].filter((k) => weights[k]);
  return { weights, poses: leastSquares(poseGraphProblem(graphWithWrong(data, wrong, agreed))).poses };
}

/** Switches that are always at their optimum are the kernel of Geman and McClure, λ = γ². */
function keptBySwitching(graph, gamma) {
  const problem = poseGraphProblem(graph);
  const start = leastSquares(problem).poses;
  const { x: poses, weights } = irls(problem, "geman-mcclure", gamma, start, { tol: 1e-3, maxIterations: 60 });
  return { poses, weights };
}

/** A, B, … for correct closures, 1, 2, … for wrong ones. */
function closureName(place, correct) {
  return place < correct ? String.fromCharCode(65 + place) : String(place - correct + 1);
}

function drawConsistency(scene, view) {
  const all = { x: 0, y: 0, width: view.width, height: view.height };
  const [map, beside] = twoPanels(all, [1, 1], 0.53);
  drawClosureMap(scene, view, map);
  drawAgreement(scene, view.result, beside);
}

function drawClosureMap(scene, { state, result, shown, data, change }, box) {
  const inner = { ...box, y: box.y + 20, height: box.height - 20 };
  const map = fitAround(scene, "map", inner, data.truth, result.shown);
  const head = `Map, ${result.off.toFixed(2)} m off`;
  scene.text("words", "map-head", box.x + 0.5 * box.width, box.y + 14, head, "rs-head", "middle");
  scene.clip("drive", { x: box.x, y: box.y + 18, width: box.width, height: box.height - 18 });
  putDrive(scene, "ghost", "truth", map, data.truth, "is-ghost");
  putDrive(scene, "drive", "map", map, shown, "is-estimate");
  result.ends.forEach((ends, place) => {
    const [used, right] = [result.used[place], place < result.correct];
    const look = used ? (right ? "is-inlier" : "is-outlier") : "is-rejected";
    const [layer, poses] = right ? ["edges", shown] : ["wrong", data.truth];
    putEdge(scene, layer, `edge-${place}`, map, poses, ends, look, used && !right ? 3 : 2);
  });
  if (!state.count) return;
  const [x, y] = posePixels(map, data.truth, state.group[0]);
  const name = state.count > 1 ? `1–${state.count}` : "1";
  scene.text("words", "name", x - 13, y + 20, name, "rs-head rs-halo", "end");
  putClosureHandles(scene, map, data.truth, [state.group], ([group]) => change({ group }), {
    noun: "Wrong closures", removable: false, last: data.truth.length / 3 - state.count,
  });
}

const VERTEX = { true: "M-7 -7H7V7H-7Z", false: "M-8 0a8 8 0 1 0 16 0a8 8 0 1 0 -16 0Z" };

/** The closures in a ring, lines between those that agree, thick ones within the largest clique. */
function drawAgreement(scene, { adjacency, isMember, correct }, box) {
  const count = isMember.length;
  scene.text("words", "ring-head", box.x + 0.5 * box.width, box.y + 14, "A line joins closures that agree", "rs-head", "middle");
  const [rx, ry] = [0.5 * Math.min(box.width, 340) - 34, 0.5 * (Math.min(box.height, 340) - 22) - 28];
  const [cx, cy] = [box.x + 0.5 * box.width, box.y + 22 + 0.5 * (box.height - 22)];
  const at = (place, out = 0) => {
    const angle = (2 * Math.PI * place) / count - 0.5 * Math.PI;
    return [cx + (rx + out) * Math.cos(angle), cy + (ry + out) * Math.sin(angle)];
  };
  const lines = { pairs: "", members: "" };
  for (let p = 0; p < count; p += 1) {
    for (let q = p + 1; q < count; q += 1) {
      if (!adjacency[p * count + q]) continue;
      const [[x, y], [u, v]] = [at(p), at(q)];
      lines[isMember[p] && isMember[q] ? "members" : "pairs"] += `M${x.toFixed(1)} ${y.toFixed(1)}L${u.toFixed(1)} ${v.toFixed(1)}`;
    }
  }
  scene.path("pairs", "pairs", "is-muted", lines.pairs, 1);
  scene.path("members", "members", "is-ink", lines.members, 2);
  for (let place = 0; place < count; place += 1) {
    const wrong = place >= correct;
    const [x, y] = at(place);
    const colour = `var(--rs-${wrong ? "outlier" : "inlier"})`;
    scene.put("vertices", `vertex-${place}`, "path", {
      "data-part": `edge-${place}`, d: VERTEX[wrong], transform: `translate(${x.toFixed(1)} ${y.toFixed(1)})`, "stroke-width": 2.5,
      style: `stroke:${colour};fill:${isMember[place] ? colour : "var(--rs-card)"}`,
    });
    const [tx, ty] = at(place, 20);
    scene.text("words", `vertex-name-${place}`, tx, ty + 4, closureName(place, correct), "", "middle");
  }
}

function consistencyCaption({ state, result: { used, correct, clique, off } }) {
  const kept = (from, to) => used.slice(from, to).filter(Boolean).length;
  const [right, wrong] = [kept(0, correct), kept(correct)];
  const [keep, lets] = state.map === "pcm" ? ["PCM keeps", "lets"] : ["Switches keep", "let"];
  const map = `The map is ${off.toFixed(2)}\u00a0m off.`;
  if (state.map === "pcm" && clique.length === correct && used.length === 2 * correct) {
    return `${correct} against ${correct} is a tie: PCM happens to keep the ${wrong ? "outliers" : "inliers"}. ${map}`;
  }
  if (!wrong) return `${keep} ${right} of the ${correct} inliers and ${lets} no outlier in. ${map}`;
  return right ? `${keep} ${wrong} of ${used.length - correct} outliers beside ${right} of the ${correct} inliers. ${map}`
    : `The outliers win: ${keep} ${wrong} of them and no inlier. ${map}`;
}
