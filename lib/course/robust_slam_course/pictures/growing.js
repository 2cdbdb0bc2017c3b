import { MAP_LEGEND, putLegend } from "../canvas/js/draw/legend.js";
import { fitAround, posePixels, putDrive, putEdge } from "../canvas/js/draw/map.js";
import { putMarker } from "../canvas/js/draw/marker.js";
import { livePicture } from "../canvas/js/draw/picture.js";
import { pathThrough } from "../canvas/js/draw/scene.js";
import { sideBySide } from "../canvas/js/draw/stage.js";
import { poseCovariances } from "../canvas/js/solve/covariance.js";
import { graphWithWrong, leastSquares, poseGraphProblem } from "../canvas/js/solve/pose_graph.js";

/**
 * A map that grows, and withdraws an outlier. Which closures it keeps was decided by the library,
 * see `tools/data/labs.py`; the map and the ellipses that follow from them are computed here.
 */
export function render(context) {
  const data = context.model.get("data");
  return livePicture(context, {
    layers: ["ghost", "edges", "drive", "ellipses", "axis", "bars", "words"],
    controls: [
      { kind: "player", name: "pose", label: "Time", count: () => data.last, text: (pose) => `pose ${pose}` },
      {
        kind: "slider", name: "arrives", label: "The outlier arrives", min: data.arrivals[0],
        max: data.arrivals.at(-1), step: 1, text: (pose) => `at pose ${pose}`,
      },
    ],
    main: ["pose"],
    clean: (state) => ({ ...state, pose: Math.min(data.last, Math.max(2, state.pose)) }),
    solve: solveGrowing,
    moving: ({ poses, ellipses }) => Float64Array.from([...poses, ...ellipses.flatMap(({ shape }) => shape)]),
    draw: drawGrowing,
    caption: growingCaption,
  });
}

const EVERY = 3; // poses from one ellipse to the next

function solveGrowing(state, data) {
  const { minds, edges, trusted, arrivals, truth } = data;
  const changes = minds[state.arrives - arrivals[0]];
  const first = trusted.reduce((sum, value) => sum + value, 0);
  const closures = edges.slice(first).map((ends, k) => {
    const isOutlier = first + k === edges.length - 1;
    const told = isOutlier ? state.arrives : Math.max(...ends);
    return { ends, isOutlier, told, spans: spansOf(changes, k, data.last) };
  });
  const isKept = ({ told, spans }) => told <= state.pose && spans.some(([from, to]) => from <= state.pose && state.pose < to);
  const taken = [...edges.keys()].filter((k) => k < first || isKept(closures[k - first]));
  const graph = graphWithWrong(data, { edges: [] }, taken);
  const { poses } = leastSquares(poseGraphProblem(graph));
  const numbers = Array.from({ length: Math.floor(data.last / EVERY) }, (_, k) => EVERY * (k + 1));
  const found = poseCovariances(graph, poses, new Float64Array(graph.m).fill(1), numbers);
  const ellipses = numbers.map((pose, k) => ellipseOf(pose, found[k], poses, truth));
  const seen = ellipses.filter(({ pose }) => pose <= state.pose);
  return {
    poses, ellipses, closures, isKept, outlier: closures.at(-1),
    seen: seen.length, outside: seen.filter(({ holds }) => !holds).length,
  };
}

/** From when to when closure `k` is kept, `[from, to]` in poses. */
function spansOf(changes, k, last) {
  const spans = [];
  for (let at = 0; at < changes.length; at += 2) {
    const [pose, kept] = [changes[at], changes[at + 1] >> k & 1];
    const open = spans.length && spans.at(-1)[1] > last;
    if (kept && !open) spans.push([pose, last + 1]);
    if (!kept && open) spans.at(-1)[1] = pose;
  }
  return spans;
}

const LIMIT = 5.991464547107979; // the 95 % quantile of χ² with 2 degrees of freedom

/** The 95 % ellipse of a position: `shape` maps the unit circle to it, in m. */
function ellipseOf(pose, covariance, poses, truth) {
  const [a, b, , , d] = covariance;
  const root = Math.sqrt(a);
  const low = [root, 0, b / root, Math.sqrt(d - (b * b) / a)];
  const [c, s] = [Math.cos(poses[3 * pose + 2]), Math.sin(poses[3 * pose + 2])];
  const shape = [c * low[0] - s * low[2], -s * low[3], s * low[0] + c * low[2], c * low[3]]
    .map((entry) => Math.sqrt(LIMIT) * entry);
  const [x, y] = [truth[3 * pose] - poses[3 * pose], truth[3 * pose + 1] - poses[3 * pose + 1]];
  const determinant = shape[0] * shape[3] - shape[1] * shape[2];
  const inside = Math.hypot(shape[3] * x - shape[1] * y, shape[0] * y - shape[2] * x) / determinant;
  return { pose, shape, holds: inside <= 1 };
}

function drawGrowing(scene, view) {
  const { state, result, shown, data, width, height } = view;
  const [left, right] = sideBySide({ x: 0, y: 0, width, height }, [1.35, 1]);
  const top = putLegend(scene, "words", "legend", left.x, left.y, left.width, [...MAP_LEGEND, ["is-rejected", "rejected"]]);
  const box = { ...left, y: top + 4, height: height - top - 4 };
  const count = 3 * (data.last + 1);
  const until = 3 * (state.pose + 1);
  const map = fitAround(scene, "map", box, data.truth, cornersOf(result, state.pose), 20);
  putDrive(scene, "ghost", "truth", map, data.truth, "is-ghost");
  putDrive(scene, "drive", "map", map, shown.subarray(0, until), "is-estimate");
  result.closures.forEach((closure, k) => {
    if (closure.told > state.pose) return;
    const look = closure.isOutlier ? "is-outlier" : "is-inlier";
    putEdge(scene, "edges", `edge-${k}`, map, shown, closure.ends, result.isKept(closure) ? look : "is-rejected", closure.isOutlier ? 3 : 2);
  });
  result.ellipses.forEach(({ pose, holds }, k) => {
    if (pose > state.pose) return;
    const shape = shown.subarray(count + 4 * k, count + 4 * k + 4);
    putEllipse(scene, `ellipse-${pose}`, map, posePixels(map, shown, pose), shape, holds);
    if (!holds) putMarker(scene, "ellipses", `true-${pose}`, ...posePixels(map, data.truth, pose), "diamond", "outlier");
  });
  drawTimes(scene, right, view);
}

/** The corners of the boxes around the ellipses until a pose, as poses. */
function cornersOf({ poses, ellipses }, last) {
  return ellipses.filter(({ pose }) => pose <= last).flatMap(({ pose, shape }) => {
    const [x, y] = [poses[3 * pose], poses[3 * pose + 1]];
    const [right, up] = [Math.hypot(shape[0], shape[1]), Math.hypot(shape[2], shape[3])];
    return [x - right, y - up, 0, x + right, y + up, 0];
  });
}

function putEllipse(scene, key, map, [x, y], shape, holds) {
  const points = Array.from({ length: 33 }, (_, k) => {
    const [c, s] = [Math.cos((k * Math.PI) / 16), Math.sin((k * Math.PI) / 16)];
    return [x + map.scale * (shape[0] * c + shape[1] * s), y - map.scale * (shape[2] * c + shape[3] * s)];
  });
  const look = holds ? "is-muted" : "is-outlier";
  scene.path("ellipses", key, `rs-edge ${look}`, `${pathThrough(points)}Z`, holds ? 1 : 2);
}

/** Until the pose that is shown: when each closure arrived and while it was kept, in their order. */
function drawTimes(scene, { x, y, width, height }, { state, result, data }) {
  const order = result.closures.filter(({ told }) => told <= data.last).sort((a, b) => a.told - b.told);
  const until = state.pose + 1;
  const name = 50;
  const toX = (pose) => x + name + ((width - name - 6) * pose) / (data.last + 1);
  const step = Math.min(30, (height - 60) / Math.max(order.length, 1));
  const low = y + 26 + step * order.length;
  scene.text("words", "times", x, y + 15, "Kept, over time", "rs-head");
  order.forEach((closure, k) => {
    const { ends, isOutlier, told, spans } = closure;
    if (told > state.pose) return;
    const line = y + 30 + (k + 0.3) * step;
    const key = `time-${ends.join("-")}`;
    scene.text("words", `${key}-name`, x, line + 5, ends.join("–"), isOutlier ? "rs-head" : "");
    scene.path("bars", `${key}-told`, "rs-edge is-rejected", `M${toX(told)} ${line}H${toX(until)}`, 1.5);
    spans.filter(([from]) => from <= state.pose).forEach(([from, to], n) => scene.put("bars", `${key}-${n}`, "path", {
      class: `rs-edge ${isOutlier ? "is-outlier" : "is-inlier"}`, "stroke-width": 6,
      style: "stroke-dasharray:none", d: `M${toX(Math.max(from, told))} ${line}H${toX(Math.min(to, until))}`,
    }));
  });
  const now = toX(state.pose + 0.5);
  scene.path("axis", "now", "is-muted", `M${now} ${y + 24}V${low}`, 1.5);
  scene.text("words", "now-text", Math.min(now, x + width - 24), low + 16, `pose ${state.pose}`, "rs-tick", "middle");
}

function growingCaption({ state, result, data }) {
  const { outlier, outside, seen } = result;
  const spans = outlier.spans.filter(([from]) => from <= state.pose);
  const end = spans.at(-1)?.[1];
  const fate = state.pose < outlier.told ? `has not met the outlier yet, which arrives at pose ${outlier.told}`
    : !spans.length ? "rejected the outlier on arrival"
      : end > state.pose ? `has trusted the outlier since pose ${Math.max(spans.at(-1)[0], outlier.told)}`
        : `withdrew the outlier at pose ${end}`;
  const off = Math.hypot(...[0, 1].map((axis) => result.poses[3 * state.pose + axis] - data.truth[3 * state.pose + axis]));
  return `At pose ${state.pose} the map ${fate}. It puts the robot ${off.toFixed(2)}\u00a0m off, and ${outside} of ${seen} ellipses miss the true position.`;
}
