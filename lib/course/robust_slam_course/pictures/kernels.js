import { KERNELS } from "../canvas/js/solve/kernels.js";
import { locationProblem } from "../canvas/js/solve/location.js";
import { irls } from "../canvas/js/solve/loop.js";
import { putAxes, putCurve, putPath } from "../canvas/js/draw/axes.js";
import { putHandle } from "../canvas/js/draw/handle.js";
import { putEndLabels } from "../canvas/js/draw/labels.js";
import { putMarker } from "../canvas/js/draw/marker.js";
import { boundedNumber } from "../canvas/js/draw/link.js";
import { livePicture } from "../canvas/js/draw/picture.js";
import { twoPanels } from "../canvas/js/draw/stage.js";

/**
 * One reading that the reader moves away from eight others, as four kernels see it. The curves are
 * drawn as far as it has been.
 */
export function render(context) {
  const drifts = new Map(); // by scale: a drag of the reading does not change them
  return livePicture(context, {
    layers: ["axes", "curves", "words", "markers"],
    controls: [
      { kind: "slider", name: "c", label: "Threshold c", min: 0.5, max: 5, step: 0.1, text: (c) => `c = ${c.toFixed(1)}` },
    ],
    main: ["c"],
    clean: cleanKernels,
    solve: (state, data) => solveKernels(state, data, drifts),
    moving: ({ estimates, residuals }) => [...estimates, ...residuals],
    draw: drawKernels,
    caption: kernelsCaption,
  });
}

const STRIP = 70; // pixels of the line of readings above the panels
const FARTHEST = 15;

/** Colours and lines are those of the book's figures. */
const KERNEL_LOOKS = [
  { name: "squared", text: "squared", colour: "ink", dash: "none", shape: "circle" },
  { name: "huber", text: "Huber", colour: "plum", dash: "8 4", shape: "square" },
  { name: "cauchy", text: "Cauchy", colour: "ochre", dash: "9 4 1.5 4", shape: "triangle" },
  { name: "tls", text: "TLS", colour: "accent", dash: "1 4.5", shape: "plus" },
];

function cleanKernels({ c, ...state }) {
  const [z, far] = [state.z, state.far].map((value) => boundedNumber(value, [0, FARTHEST], 0, 2));
  return { c, z, far: Math.max(z, far) };
}

function solveKernels({ z, c }, { inliers }, drifts) {
  const problem = locationProblem([...inliers, z]);
  const results = KERNEL_LOOKS.map(({ name }) => irls(problem, name, c, 0));
  if (!drifts.has(c)) drifts.set(c, driftsOf(c, inliers));
  return {
    estimates: results.map(({ x }) => x),
    residuals: results.map(({ x }) => z - x),
    kept: results[3].weights.slice(0, -1).reduce((sum, weight) => sum + weight, 0),
    drifts: drifts.get(c),
  };
}

/** For each kernel the estimates with the reading at 0, 1/8, 2/8, … */
function driftsOf(c, inliers) {
  const places = Array.from({ length: 8 * FARTHEST + 1 }, (_, k) => k / 8);
  return KERNEL_LOOKS.map(({ name }) => places.map((z) => {
    const problem = locationProblem([...inliers, z]);
    return [z, irls(problem, name, c, 0, { tol: 1e-5 }).x];
  }));
}

function drawKernels(scene, view) {
  const { width, height, state: { c, z, far }, result, shown, data, change } = view;
  const [left, right] = twoPanels({ x: 0, y: STRIP, width, height: height - STRIP }, [1, 1], 0.5, 8);
  putLine(scene, width, z, data.inliers, change);
  const [estimates, residuals] = [shown.slice(0, 4), shown.slice(4)];
  const over = putPanel(scene, "curve", left, "whitened residual u", "influence ψ(u)", [0, 1.6 * c]);
  const panel = putPanel(scene, "drift", right, "place z of the reading", "estimate", [-0.15, 1.75]);
  KERNEL_LOOKS.forEach((look, j) => {
    const f = (u) => KERNELS[look.name].psi(u, c);
    const seen = result.drifts[j].filter(([at]) => at <= far);
    const [last, x] = seen.at(-1);
    putCurve(scene, "curves", `curve-${look.name}`, over, [0, last - x], f, lineLook(look), 300);
    putOnCurve(scene, "curve", over, residuals[j], f(residuals[j]), look);
    const points = seen.map(([at, estimate]) => [panel.toX(at), panel.toY(estimate)]);
    putPath(scene, "curves", `drift-${look.name}`, panel, points, lineLook(look));
    putOnCurve(scene, "drift", panel, z, estimates[j], look);
  });
  putNames(scene, "curve", over, KERNEL_LOOKS.map(({ name }, j) => KERNELS[name].psi(residuals[j], c)));
  putNames(scene, "drift", panel, estimates);
}

function lineLook({ colour, dash }) {
  return { class: "rs-line", style: `stroke: var(--rs-${colour}); stroke-dasharray: ${dash}` };
}

/** Axes with room for the kernels' names to the right of them. */
function putPanel(scene, key, box, across, up, domain) {
  return putAxes(
    scene, "axes", key, { ...box, width: box.width - 56 },
    { domain: [0, FARTHEST], label: across, ticks: [0, 5, 10, 15] }, { domain, label: up },
  );
}

function putOnCurve(scene, key, panel, across, up, { name, shape, colour }) {
  const [x, y] = [panel.toX(across), panel.toY(up)];
  if (y < panel.inner.y - 1) return;
  putMarker(scene, "markers", `${key}-at-${name}`, x, y, shape, colour);
}

function putNames(scene, key, { inner, toY }, ends) {
  const labels = KERNEL_LOOKS.map(({ text, colour }, k) => ({ text, colour, y: toY(ends[k]) }));
  putEndLabels(scene, "words", `${key}-name`, inner.x + inner.width + 5, labels, inner.y + 2, inner.y + inner.height);
}

/** The readings on a line: eight inliers, and the one to move. */
function putLine(scene, width, z, inliers, change) {
  const [left, right] = [30, width - 30];
  const [low, high] = [-2, FARTHEST];
  const toX = (value) => left + ((value - low) / (high - low)) * (right - left);
  const y = 30;
  scene.path("axes", "line", "rs-edge is-muted", `M${left} ${y}H${right}`);
  for (const value of [0, 5, 10, 15]) {
    scene.path("axes", `line-${value}`, "rs-edge is-muted", `M${toX(value)} ${y}v6`);
    scene.text("axes", `line-text-${value}`, toX(value), y + 20, String(value), "rs-tick", "middle");
  }
  inliers.forEach((value, k) => {
    scene.path("axes", `inlier-${k}`, "rs-edge is-inlier", `M${toX(value)} ${y - 11}v11`, 3);
  });
  scene.text("words", "inliers", toX(0), y - 17, "8 inliers", "", "middle");
  putHandle(scene, "reading", {
    x: toX(z), y, shape: "diamond", look: "rs-wrong",
    label: "Ninth reading", text: z.toFixed(2), now: z, least: 0, most: FARTHEST, unit: 0.1,
    drag: (px) => change({ z: low + ((px - left) / (right - left)) * (high - low) }),
    step: (rightwards, up) => change({ z: z + 0.1 * (rightwards || up) }),
  });
}

function kernelsCaption({ state: { z }, result: { estimates, kept }, data }) {
  const lost = data.inliers.length - kept;
  if (!z) return "The ninth reading stands among the inliers, and the four estimates agree with them.";
  const [mean, huber, cauchy, tls] = estimates.map((x) => Math.abs(x).toFixed(2));
  return `The reading at ${z.toFixed(1)} draws the mean to ${mean}, Huber’s estimate to ${huber},`
    + ` Cauchy’s to ${cauchy} and that of TLS to ${tls}${lost > 0 ? `, which rejects ${lost} of the 8 inliers` : ""}.`;
}
