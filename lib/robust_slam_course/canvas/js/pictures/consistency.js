import { numberText } from "../draw/number.js";
import { fitAround, posePixels, putClosureHandles, putDrive, putEdge } from "../draw/map.js";
import { boundedNumber } from "../draw/link.js";
import { audiblePicture } from "../draw/listen.js";
import { twoPanels } from "../draw/stage.js";
import { putStrip } from "../draw/strip.js";
import { agreeingClosures } from "../solve/aliasing.js";
import { pcm } from "../solve/consistency.js";
import { irls } from "../solve/loop.js";
import { alignPoses, ate } from "../solve/metrics.js";
import { graphWithWrong, leastSquares, poseGraphProblem } from "../solve/pose_graph.js";

/**
 * Closures on a map, correct ones and wrong ones that the reader moves; which of them agree, as
 * a graph with its largest clique; the cycle errors of one closure with all others; and how far
 * the switch of each closure stays open.
 */
export function render(context) {
  return audiblePicture(context, {
    layers: ["ghost", "edges", "drive", "wrong", "pairs", "members", "vertices", "strip", "words"],
    controls: [
      {
        kind: "slider", name: "count", label: "Wrong closures", min: 0, max: MOST_WRONG_CLOSURES, step: 1,
        text: String,
      },
      { kind: "toggle", name: "agree", label: "They agree" },
      {
        kind: "slider", name: "gamma", label: "Threshold γ", min: 1, max: 100, step: 0.01, log: true,
        text: (value) => numberText(value, 3),
      },
      {
        kind: "choice", name: "map", label: "Map by",
        options: [["pcm", "PCM"], ["switches", "switches, λ = γ²"]],
      },
      {
        kind: "choice", name: "beside", label: "Beside the map",
        options: [["ring", "who agrees"], ["errors", "cycle errors"], ["switches", "switches"]],
      },
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

const BESIDE = { ring: drawAgreement, errors: drawCycleErrors, switches: drawSwitchStrip };

function cleanConsistency(state, data) {
  const last = data.truth.length / 3 - 1;
  const { count } = state;
  const end = (pose, most, instead) => boundedNumber(pose, [0, most], instead, 0);
  const pair = ([i, j], most, instead) => {
    const [tail, head] = [end(i, most, instead[0]), end(j, most, instead[1])];
    return Math.abs(tail - head) >= 2 ? [tail, head] : [tail, tail > 1 ? tail - 2 : tail + 2];
  };
  const lone = data.lone.map((instead, k) => pair(Array.isArray(state.lone[k]) ? state.lone[k] : instead, last, instead));
  return {
    ...state, lone, group: pair(state.group, last + 1 - Math.max(1, count), data.group),
    chosen: boundedNumber(state.chosen, [0, Math.max(0, count - 1)], 0, 0),
  };
}

function wrongClosures(state, truth) {
  if (state.agree) return agreeingClosures(truth, state.group, state.count);
  return { edges: state.lone.slice(0, state.count) };
}

function solveConsistency(state, data) {
  const wrong = wrongClosures(state, data.truth);
  const graph = graphWithWrong(data, wrong);
  const agreement = pcm(graph, state.gamma);
  const agreed = [...agreement.kept.keys()].filter((k) => agreement.kept[k]);
  const kept = leastSquares(poseGraphProblem(graphWithWrong(data, wrong, agreed))).poses;
  const problem = poseGraphProblem(graph);
  // Switches that are always at their optimum are the kernel of Geman and McClure, λ = γ².
  const switched = irls(problem, "geman-mcclure", state.gamma, leastSquares(problem).poses, {
    tol: 1e-3, maxIterations: 60,
  });
  const { truth } = data;
  const poses = alignPoses(state.map === "pcm" ? kept : switched.x, truth);
  const weights = state.map === "pcm" ? agreement.kept : switched.weights;
  const { closures, clique, adjacency, distances } = agreement;
  const switches = Array.from(closures, (edge) => Math.sqrt(switched.weights[edge]));
  const isMember = closures.map((_, place) => clique.includes(place));
  return {
    shown: poses, heard: { graph, poses, weights, map: "map" }, wrong, clique, adjacency, distances, switches, isMember,
    correct: closures.length - wrong.edges.length,
    ends: closures.map((edge) => [graph.tail[edge], graph.head[edge]]),
    used: state.map === "pcm" ? isMember : switches.map((s) => s >= 0.5),
    off: { pcm: ate(kept, truth), switches: ate(switched.x, truth) },
  };
}

/** A, B, … for correct closures, 1, 2, … for wrong ones. */
function closureName(place, correct) {
  return place < correct ? String.fromCharCode(65 + place) : String(place - correct + 1);
}

function chosenPlace(state, result) {
  return result.wrong.edges.length ? result.correct + state.chosen : 0;
}

function drawConsistency(scene, view) {
  const all = { x: 0, y: 0, width: view.width, height: view.height };
  const [map, beside] = twoPanels(all, [1, 1], 0.53);
  drawClosureMap(scene, view, map);
  BESIDE[view.state.beside](scene, view, beside);
}

function drawClosureMap(scene, { state, result, shown, data, change }, box) {
  const inner = { ...box, y: box.y + 20, height: box.height - 20 };
  const map = fitAround(scene, "map", inner, data.truth, result.shown);
  const way = state.map === "pcm" ? "PCM, then least squares" : "Switches";
  const head = `${way}: ${result.off[state.map].toFixed(2)} m off`;
  scene.text("words", "map-head", box.x + 0.5 * box.width, box.y + 14, head, "rs-head", "middle");
  scene.clip("drive", { x: box.x, y: box.y + 18, width: box.width, height: box.height - 18 });
  putDrive(scene, "ghost", "truth", map, data.truth, "is-ghost");
  putDrive(scene, "drive", "map", map, shown, "is-estimate");
  result.ends.forEach((ends, place) => {
    const used = result.used[place];
    if (place < result.correct) {
      putEdge(scene, "edges", `edge-${place}`, map, shown, ends, used ? "is-inlier" : "is-rejected");
      return;
    }
    putEdge(scene, "wrong", `edge-${place}`, map, data.truth, ends, used ? "is-outlier" : "is-rejected", used ? 3 : 2);
  });
  const held = state.agree ? result.wrong.edges.slice(0, 1) : result.wrong.edges;
  held.forEach(([i], k) => {
    const [x, y] = posePixels(map, data.truth, i);
    const name = state.agree && state.count > 1 ? `1–${state.count}` : String(k + 1);
    scene.text("words", `name-${k}`, x - 13, y + 20, name, "rs-head rs-halo", "end");
  });
  const edit = (list) => {
    if (state.agree) return change({ group: list[0] });
    const chosen = list.findIndex((ends, k) => ends.join() !== held[k].join());
    return change({ lone: [...list, ...state.lone.slice(list.length)], chosen: chosen < 0 ? state.chosen : chosen });
  };
  putClosureHandles(scene, map, data.truth, held, edit, { noun: "Wrong closure", removable: false });
}

const VERTEX = { true: "M-7 -7H7V7H-7Z", false: "M-8 0a8 8 0 1 0 16 0a8 8 0 1 0 -16 0Z" };

/** The closures in a ring, lines between those that agree, thick ones within the largest clique. */
function drawAgreement(scene, { state, result }, box) {
  const { adjacency, isMember, correct, clique } = result;
  const count = isMember.length;
  const head = `Largest set that agrees: ${clique.length} of ${count}`;
  scene.text("words", "ring-head", box.x + 0.5 * box.width, box.y + 14, head, "rs-head", "middle");
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
  scene.path("members", "members", "is-estimate", lines.members, 2);
  for (let place = 0; place < count; place += 1) {
    const wrong = place >= correct;
    const [x, y] = at(place);
    const colour = `var(--rs-${wrong ? "outlier" : "inlier"})`;
    scene.put("vertices", `vertex-${place}`, "path", {
      "data-part": `edge-${place}`, d: VERTEX[wrong], transform: `translate(${x.toFixed(1)} ${y.toFixed(1)})`, "stroke-width": 2.5,
      style: `stroke:${colour};fill:${isMember[place] ? colour : "var(--rs-card)"}`,
    });
    const [tx, ty] = at(place, 20);
    const look = place === chosenPlace(state, result) ? "rs-head" : "";
    scene.text("words", `vertex-name-${place}`, tx, ty + 4, closureName(place, correct), look, "middle");
  }
}

function stripGroups(result, bar) {
  const bars = result.ends.map((_, place) => ({
    look: place < result.correct ? "is-inlier" : "is-outlier",
    name: closureName(place, result.correct), part: `edge-${place}`, ...bar(place),
  }));
  const groups = [
    { name: "correct", share: result.correct, bars: bars.slice(0, result.correct) },
    { name: "wrong", share: bars.length - result.correct, bars: bars.slice(result.correct) },
  ];
  return groups.filter((group) => group.bars.length);
}

function drawCycleErrors(scene, { state, result }, box) {
  const own = chosenPlace(state, result);
  const count = result.ends.length;
  const groups = stripGroups(result, (place) => ({ value: place === own ? 0 : result.distances[own * count + place] }));
  putStrip(scene, "strip", "errors", box, groups, {
    domain: [0.1, 1000], ticks: [0.1, 1, 10, 100, 1000],
    label: `cycle error with ${closureName(own, result.correct)}`, line: { value: state.gamma, text: "dashed: γ" },
  });
}

function drawSwitchStrip(scene, { result }, box) {
  const groups = stripGroups(result, (place) => ({ value: result.switches[place] }));
  putStrip(scene, "strip", "switches", box, groups, {
    domain: [0, 1], ticks: [0, 0.5, 1], linear: true, label: "switch s",
  });
}

function consistencyCaption({ state, result }) {
  const { isMember, correct, switches, off, wrong } = result;
  const count = (list) => [list.slice(0, correct), list.slice(correct)].map((part) => part.reduce((sum, one) => sum + one, 0));
  const [right, bad] = count(isMember);
  const [open, loose] = count(switches.map((s) => s >= 0.5));
  const number = wrong.edges.length;
  const outliers = number === 1 ? "1 outlier" : `${number || "no"} outliers`;
  const group = state.agree && number > 1 ? " that agree" : "";
  return `${correct} inliers and ${outliers}${group}. PCM keeps ${right} and ${bad}: ${off.pcm.toFixed(2)}\u00a0m off. `
    + `The switches keep ${open} and ${loose} above one half: ${off.switches.toFixed(2)}\u00a0m off.`;
}
