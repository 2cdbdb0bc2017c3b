import { numberText } from "../draw/number.js";
import { possibleJoins } from "../draw/link.js";
import { audiblePicture } from "../draw/listen.js";
import { fitAround, posePixels, putClosureHandles, putDrive, putEdge } from "../draw/map.js";
import { setAttributes } from "../draw/scene.js";
import { stageHeight, twoPanels, WIDE } from "../draw/stage.js";
import { putStrip } from "../draw/strip.js";
import { alignPoses } from "../solve/metrics.js";
import {
  CHI_99_SE2, graphResidualNorms, graphWithWrong, leastSquares, poseGraphProblem,
} from "../solve/pose_graph.js";

/**
 * Two maps, a town and a pentagon, on which the reader joins any two poses by a wrong closure.
 * Each edge has the colour and the width of its whitened residual, so that the edges which
 * share a cycle with a wrong closure stand out.
 */
export function render(context) {
  const undisturbed = new Map();
  return audiblePicture(context, {
    layers: ["ghost", "edges", "drive", "wrong", "strip"],
    controls: [
      { kind: "choice", name: "place", label: "Map", options: [["town", "town"], ["pentagon", "pentagon"]] },
      { kind: "toggle", name: "correct", label: "Correct closures" },
      {
        kind: "slider", name: "sigma", label: "σ of wrong closures", min: 0.01, max: 1, step: 0.01,
        log: true, text: (value) => `${numberText(value, 2)} m`,
      },
      {
        kind: "button", label: "Add a wrong closure", does: addJoin,
        when: (state) => state[state.place].length < MOST_JOINS,
      },
      {
        kind: "button", label: "Remove one", when: (state) => state[state.place].length > 0,
        does: (state) => ({ [state.place]: state[state.place].slice(0, -1) }),
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

const MOST_JOINS = 4;
const CHANGED = 0.005; // a residual that moved by more than this, in standard deviations

/** The least number of poses between the ends of a join; neighbours of the pentagon may be joined. */
function leastGap(place) {
  return place === "town" ? 2 : 1;
}

function cleanCycles(state, data) {
  const joins = (name) => (
    possibleJoins(state[name], data[name].truth.length / 3 - 1, leastGap(name), MOST_JOINS));
  return { ...state, town: joins("town"), pentagon: joins("pentagon") };
}

// Each new join of the town is long, and none repeats one that is there.
function addJoin(state, result) {
  const joins = state[state.place];
  const count = result.poses.length / 3;
  const there = new Set(joins.map(([i, j]) => i * count + j));
  const offers = state.place === "pentagon"
    ? [[0, 2], [1, 4], [2, 4], [1, 3], [0, 3]]
    : [[36, 69], [10, 52], [22, 86], [47, 97], [3, 30]];
  const join = offers.find(([i, j]) => !there.has(i * count + j));
  return { [state.place]: [...joins, join] };
}

/** The edges of a map, without its correct closures if so chosen, and one for each join. */
function joinedGraph(given, correct, joins, sigma) {
  const stiff = [1 / sigma ** 2, 1 / sigma ** 2, 1 / (given.turn * sigma) ** 2];
  const information = [stiff[0], 0, 0, 0, stiff[1], 0, 0, 0, stiff[2]];
  const numbers = [...given.edges, ...joins].map((_, k) => k);
  const taken = numbers.filter((k) => correct || given.trusted[k] !== 0);
  return graphWithWrong(given, { edges: joins, information }, taken);
}

/** Least squares on `graph`, from dead reckoning: the poses and the norm of each residual. */
function squaresOf(graph) {
  const { poses } = leastSquares(poseGraphProblem(graph));
  return { poses, norms: graphResidualNorms(graph, poses) };
}

function solveCycles({ place, correct, sigma, ...lists }, data, undisturbed) {
  const [given, joins] = [data[place], lists[place]];
  const key = `${place} ${correct}`;
  if (!undisturbed.has(key)) {
    undisturbed.set(key, squaresOf(joinedGraph(given, correct, [], sigma)).norms);
  }
  const before = undisturbed.get(key);
  const graph = joinedGraph(given, correct, joins, sigma);
  const { poses: held, norms } = squaresOf(graph);
  // The town is laid over its true path; the pentagon's first pose stays where it is.
  const poses = place === "town" ? alignPoses(held, given.truth) : held;
  const steps = given.truth.length / 3 - 1;
  return {
    poses, norms, graph, joins, steps, given, closures: before.length - steps,
    heard: { graph, poses, map: place, first: place === "pentagon" ? 1 : 0 },
    changed: before.reduce((sum, norm, k) => sum + (Math.abs(norms[k] - norm) > CHANGED), 0),
    off: offBy(poses, given.truth),
  };
}

/** The distance (m) of each pose from where it was. */
function offBy(poses, truth) {
  return Array.from({ length: truth.length / 3 }, (_, k) => Math.hypot(
    poses[3 * k] - truth[3 * k], poses[3 * k + 1] - truth[3 * k + 1],
  ));
}

/** 0 for a residual of half a standard deviation or less, 1 from eight on. */
function heatOf(norm) {
  return Math.min(1, Math.max(0, Math.log(norm / 0.5) / Math.log(16)));
}

/** From blue through purple to orange: none of the colours between is grey. */
function heatStyle(norm) {
  const percent = Math.round(200 * heatOf(norm));
  const [colour, other] = percent > 100 ? ["outlier", "accent"] : ["accent", "estimate"];
  return `stroke:color-mix(in srgb,var(--rs-${colour}) ${percent > 100 ? percent - 100 : percent}%,var(--rs-${other}))`;
}

function drawCycles(scene, { state, result, shown, width, height, change }) {
  const { truth } = result.given;
  const [left, right] = twoPanels({ x: 0, y: 0, width, height }, [1.25, 1], 0.66);
  const box = { ...left, y: 22, height: left.height - 22 };
  const map = fitAround(scene, state.place, box, truth, result.poses, state.place === "town" ? 24 : 42);
  for (const layer of ["edges", "drive"]) scene.clip(layer, box);
  putDrive(scene, "ghost", "truth", map, truth, "is-ghost");
  putHeatedEdges(scene, map, shown, result);
  if (state.place === "pentagon") putPentagonNames(scene, map, shown, truth);
  result.joins.forEach((join, k) => {
    putEdge(scene, "wrong", `wrong-${k}`, map, truth, join, "is-outlier", 3);
  });
  scene.text("strip", "key", 2, 14, "dotted: true path; colour: u", "rs-tick");
  putStrip(scene, "strip", "norms", right, residualGroups(state, result), {
    domain: [0.1, 100], ticks: [0.1, 1, 10, 100], label: "whitened residual u",
    line: { value: CHI_99_SE2, text: "dashed: 99 % of inliers" },
  });
  putClosureHandles(scene, map, truth, result.joins, (joins) => change({ [state.place]: joins }), {
    gap: leastGap(state.place), noun: "Wrong closure", first: state.place === "pentagon" ? 1 : 0,
  });
}

function putHeatedEdges(scene, map, shown, { graph, norms, steps, closures }) {
  for (let k = 0; k < steps + closures; k += 1) {
    const ends = [graph.tail[k], graph.head[k]];
    const wide = (k < steps ? 2 : 1.2) * (1 + 1.5 * heatOf(norms[k]));
    const layer = k < steps ? "drive" : "edges";
    const edge = putEdge(scene, layer, `edge-${k}`, map, shown, ends, "is-estimate", wide.toFixed(1));
    setAttributes(edge, { style: heatStyle(norms[k]) });
  }
}

const ARROW = 26; // pixels

/** The poses' numbers beside their true places, and an arrow for each heading. */
function putPentagonNames(scene, map, shown, truth) {
  const count = truth.length / 3;
  let [mx, my] = [0, 0];
  for (let k = 0; k < count; k += 1) {
    const [x, y] = posePixels(map, truth, k);
    [mx, my] = [mx + x / count, my + y / count];
  }
  for (let k = 0; k < count; k += 1) {
    const [x, y] = posePixels(map, truth, k);
    const far = Math.hypot(x - mx, y - my);
    const beside = [x + (30 * (x - mx)) / far, y + 4 + (24 * (y - my)) / far];
    scene.text("ghost", `name-${k}`, ...beside, String(k + 1), "rs-head", "middle");
    const [px, py] = posePixels(map, shown, k);
    scene.path("ghost", `way-${k}`, "is-ghost", `M${x} ${y}L${px} ${py}`);
    const turn = (-shown[3 * k + 2] * 180) / Math.PI;
    scene.put("wrong", `heading-${k}`, "path", {
      class: "is-ink", d: `M0 0H${ARROW}m-6 -5l6 5l-6 5`, "stroke-width": 2,
      transform: `translate(${px.toFixed(1)} ${py.toFixed(1)}) rotate(${turn.toFixed(1)})`,
    });
  }
}

function residualGroups(state, { graph, norms, steps, closures }) {
  const few = state.place === "pentagon";
  const bars = (from, to) => Array.from({ length: to - from }, (_, offset) => {
    const k = from + offset;
    const join = k - steps - closures;
    const part = join < 0 ? `edge-${k}` : `wrong-${join}`;
    const bar = { value: norms[k], style: heatStyle(norms[k]), part };
    if (!few) return bar;
    const name = `${graph.tail[k] + 1}–${graph.head[k] + 1}`;
    return { ...bar, name, text: norms[k] < 0.05 ? "0" : norms[k].toFixed(norms[k] < 9.95 ? 1 : 0) };
  });
  const groups = [{ name: "odometry", share: few ? 4 : 6, bars: bars(0, steps) }];
  if (closures) groups.push({ name: "correct", share: few ? 1.3 : 2, bars: bars(steps, steps + closures) });
  const wrong = bars(steps + closures, norms.length);
  if (wrong.length) groups.push({ name: "wrong", share: few ? wrong.length + 0.3 : 1.5, bars: wrong });
  return groups;
}

function cyclesCaption({ state, result }) {
  const { joins, norms, steps, closures, changed, off } = result;
  const wrong = state.place === "town"
    ? `The map is wrong by ${Math.sqrt(off.reduce((sum, one) => sum + one ** 2, 0) / off.length).toFixed(2)}\u00a0m.`
    : `Poses 2 to 5 are off by ${off.slice(1).map((one) => one.toFixed(2)).join(", ")}\u00a0m.`;
  if (!joins.length) return `Least squares without a wrong closure. ${wrong}`;
  const others = steps + closures;
  const [own, have] = joins.length === 1 ? ["the wrong closure", "has"] : ["the wrong closures", "have at most"];
  const kept = others - changed;
  const cycle = kept
    ? `${changed} of the ${others} other edges share a cycle with ${own} and bend; ${kept} keep their residual.`
    : `All ${others} other edges share a cycle with ${own} and bend.`;
  const largest = Math.max(...norms.subarray(others));
  const worse = norms.subarray(0, others).reduce((sum, norm) => sum + (norm > largest), 0);
  const look = `${own[0].toUpperCase()}${own.slice(1)} ${have} u = ${largest.toFixed(1)}; `;
  const edges = worse > 1 ? `${worse} other edges look worse.` : `${worse ? "1" : "no"} other edge looks worse.`;
  return `${cycle} ${look}${edges} ${wrong}`;
}
