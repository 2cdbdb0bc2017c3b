import { certify, connectionMatrix, headingsRow, quadraticCost } from "../solve/certificate.js";
import { descend, roundedHeadings, staircase } from "../solve/staircase.js";
import { numberText, putAxes } from "../draw/axes.js";
import { putHandle } from "../draw/handle.js";
import { freePlace } from "../draw/labels.js";
import { livePicture } from "../draw/picture.js";
import { pathThrough } from "../draw/scene.js";
import { WIDE } from "../draw/stage.js";

/** Headings on a ring, the spectrum of their certificate, and the climb out of the plane. */
export function render(context) {
  const climbed = { key: null, frames: [] };
  return livePicture(context, {
    layers: ["areas", "grid", "lines", "marks"],
    controls: [
      { kind: "choice", name: "ring", label: "Headings", options: [["five", "five"], ["three", "three"]] },
      {
        kind: "slider", name: "alpha", label: "Turn α", min: 0, max: 90, step: 1,
        text: (alpha) => `${alpha}°`,
      },
      {
        kind: "player", name: "step", label: "Climb", count: (state, result) => result.last,
        text: (step, result) => `${result.step} of ${result.last}`,
      },
      ringButton("Twist the ring", (count) => (k) => wholeDegrees((360 * k) / count)),
      ringButton("Equal headings", () => () => 0),
    ],
    main: [context.model.get("data").main ?? "step"],
    clean: cleanCertificate,
    solve: (state) => solveCertificate(state, climbed),
    moving: (result) => [...result.arrows, result.tilt, ...result.eigenvalues, result.cost, result.cost - result.bound],
    draw: drawCertificate,
    caption: certificateCaption,
  });
}

const TILT = 1; // rad by which the plane is turned away once the headings have left it

function ringButton(label, headings) {
  const degrees = (state) => state.degrees.map((_, k) => headings(state.degrees.length)(k));
  return {
    kind: "button", label,
    does: (state) => ({ degrees: degrees(state), step: 0 }),
    when: (state) => state.step > 0 || String(degrees(state)) !== String(state.degrees),
  };
}

/** The nearest whole number of degrees in (−180, 180]. */
function wholeDegrees(value) {
  const turned = Math.round(value) % 360;
  if (turned > 180) return turned - 360;
  return turned <= -180 ? turned + 360 : turned + 0;
}

function cleanCertificate(state) {
  const count = state.ring === "three" ? 3 : 5;
  const twisted = (k) => wholeDegrees((360 * k) / count);
  const given = state.degrees.length === count ? state.degrees : Array(count).fill(null);
  return { ...state, degrees: given.map((value, k) => (Number.isFinite(value) ? wholeDegrees(value) : twisted(k))) };
}

function solveCertificate({ degrees, alpha, step }, climbed) {
  const n = degrees.length;
  const edges = degrees.map((_, k) => [k, (k + 1) % n]);
  const Q = connectionMatrix(n, edges, Array(n).fill(inRadians(alpha)));
  // While the climb plays, headings and measurements stay.
  const key = JSON.stringify([degrees, alpha]);
  if (climbed.key !== key) {
    climbed.frames = climbFrames(Q, headingsRow(degrees.map(inRadians)));
    climbed.key = key;
  }
  const { frames } = climbed;
  const now = Math.min(step, frames.length - 1);
  const { R, r } = frames[now];
  const proof = certify(Q, R, r);
  const best = frames.at(-1).cost;
  return {
    ...proof, R, r, best,
    step: now,
    last: frames.length - 1,
    arrows: arrowsOf(R, r),
    tilt: r > 2 ? TILT : 0,
    misfits: edges.map((edge) => quadraticCost(connectionMatrix(n, [edge], [inRadians(alpha)]), R, r)),
  };
}

function inRadians(degrees) {
  return (degrees * Math.PI) / 180;
}

/** All points from R (2, 2n) on: a descent in the plane, then one with each row that is added. */
function climbFrames(Q, R) {
  const plane = descend(Q, R, 2);
  const levels = staircase(Q, plane.at(-1).R);
  return [
    ...plane.map((point) => ({ ...point, r: 2 })),
    ...levels.slice(1).flatMap(({ r, history }) => history.map((point) => ({ ...point, r }))),
  ];
}

/** The first column of each block (n, 3): where a heading points; a fourth row is not shown. */
function arrowsOf(R, r) {
  const width = R.length / r;
  return Array.from({ length: width / 2 }, (_, i) => [0, 1, 2].map(
    (row) => (row < r ? R[row * width + 2 * i] : 0),
  )).flat();
}

/** Where the panels are; a narrow page has no room for the bar, whose numbers the readout tells. */
function certificatePanels(width, height) {
  const all = { x: 0, y: 0, width, height };
  if (width < WIDE) {
    const size = 0.6 * height;
    return { ring: { x: (width - size) / 2, y: 0, size }, spectrum: { ...all, y: size + 22, height: height - size - 22 } };
  }
  const size = Math.min(height, 0.54 * width);
  const right = { ...all, x: size + 10, width: width - size - 10 };
  const half = height / 2;
  return {
    ring: { x: 0, y: (height - size) / 2, size },
    spectrum: { ...right, y: 22, height: half - 22 }, cost: { ...right, y: half + 26, height: half - 26 },
  };
}

function drawCertificate(scene, { state, result, shown, width, height, change }) {
  const panels = certificatePanels(width, height);
  const n = state.degrees.length;
  const arrows = shown.subarray(0, 3 * n);
  drawRing(scene, panels.ring, state, result, arrows, shown[3 * n], change);
  drawSpectrum(scene, panels.spectrum, result, shown.subarray(3 * n + 1, 5 * n + 1));
  if (panels.cost) drawCosts(scene, panels.cost, n, result, shown[5 * n + 1], shown[5 * n + 2]);
}

function drawRing(scene, { x, y, size }, state, result, arrows, tilt, change) {
  const n = state.degrees.length;
  const [radius, length] = [0.27 * size, 0.19 * size];
  const [ct, st] = [Math.cos(tilt), Math.sin(tilt)];
  const project = ([east, north, up]) => [
    x + size / 2 + east, y + size / 2 - north * ct - up * st,
  ];
  const spots = state.degrees.map((_, k) => {
    const around = (2 * Math.PI * k) / n;
    return [radius * Math.cos(around), radius * Math.sin(around), 0];
  });
  const draw = (layer, key, from, to, look, thick) => {
    scene.path(layer, key, `rs-edge ${look}`, pathThrough([project(from), project(to)]), thick);
  };
  const tips = spots.map((spot, k) => {
    const [east, north, up] = arrows.subarray(3 * k, 3 * k + 3);
    return [spot[0] + length * east, spot[1] + length * north, length * up];
  });
  spots.forEach((spot, k) => {
    const next = spots[(k + 1) % n];
    const misfit = result.misfits[k];
    draw("grid", `edge-${k}`, spot, next, misfit > 0.01 ? "is-outlier" : "is-inlier", 1.5 + 0.6 * misfit);
    const along = (share) => project([0, 1].map((axis) => spot[axis] + share * (next[axis] - spot[axis])).concat(0));
    const middle = freePlace([0.5, 0.36, 0.64, 0.24, 0.76].map(along), tips.map(project), 28);
    const words = misfit.toFixed(misfit < 9.95 ? 2 : 1);
    scene.text("marks", `misfit-${k}`, middle[0], middle[1] + 5, words, "rs-halo", "middle");
    const tip = tips[k];
    draw("lines", `shadow-${k}`, spot, [tip[0], tip[1], 0], "is-ghost", 2);
    draw("lines", `rise-${k}`, [tip[0], tip[1], 0], tip, "is-ghost", 2);
    draw("lines", `arrow-${k}`, spot, tip, "is-estimate", 3);
    const [px, py] = project(spot);
    scene.put("lines", `pose-${k}`, "circle", { class: "rs-open is-estimate", cx: px, cy: py, r: 4.5 });
    putHeading(scene, k, project(tip), project(spot), state, result, change);
  });
}

/** The tip of a heading; taking it brings the headings back into the plane. */
function putHeading(scene, k, [x, y], [px, py], state, result, change) {
  const plane = () => {
    if (result.r === 2 && result.step === 0) return state.degrees;
    const first = inRadians(state.degrees[0]);
    return Array.from(roundedHeadings(result.R, result.r, first), (a) => wholeDegrees((180 * a) / Math.PI));
  };
  const turn = (to) => change({
    step: 0, degrees: plane().map((value, j) => (j === k ? wholeDegrees(to) : value)),
  });
  const now = plane()[k];
  putHandle(scene, `heading-${k}`, {
    x, y, label: `Heading ${k + 1}`, text: `${numberText(now)} degrees, cost ${result.cost.toFixed(2)}`,
    now, least: -180, most: 180,
    drag: (toX, toY) => turn((180 * Math.atan2(py - toY, toX - px)) / Math.PI),
    step: (right, up) => turn(now + (right || up)),
  });
}

function drawSpectrum(scene, box, result, eigenvalues) {
  const maps = putAxes(scene, "grid", "spectrum", box,
    { domain: [-4.4, 4.4], label: "eigenvalue", ticks: [-4, -2, 0, 2, 4] }, { domain: [0, 1], label: "", ticks: [] });
  const { inner } = maps;
  scene.text("marks", "spectrum-head", box.x + 4, box.y - 6, `Eigenvalues of S: ${result.verdict}`, "rs-head");
  const floor = inner.y + inner.height;
  scene.path("areas", "refused", "rs-area is-outlier", `M${inner.x} ${inner.y}H${maps.toX(0)}V${floor}H${inner.x}Z`);
  scene.path("grid", "zero", "rs-edge is-ink", `M${maps.toX(0)} ${inner.y}V${floor}`, 1.5);
  const nought = 1e-5 * Math.max(...result.eigenvalues.map(Math.abs), 1);
  const stacks = [];
  eigenvalues.forEach((value, k) => {
    const x = Math.min(inner.x + inner.width, Math.max(inner.x, maps.toX(value)));
    const above = stacks.filter((other) => Math.abs(other - x) < 11).length;
    stacks.push(x);
    const y = inner.y + inner.height - 12 - 15 * above;
    const exact = result.eigenvalues[k];
    const kind = Math.abs(exact) <= nought ? "zero" : exact < 0 ? "below" : "above";
    const d = kind === "below" ? `M${x - 6} ${y - 5}H${x + 6}L${x} ${y + 6}Z`
      : `M${x - 5} ${y}a5 5 0 1 0 10 0a5 5 0 1 0 -10 0Z`;
    const looks = { zero: "rs-open is-ink", above: "rs-full is-estimate", below: "rs-full is-outlier" };
    scene.path("marks", `value-${k}`, `rs-eigen ${looks[kind]}`, d);
  });
  const negative = result.lambdaMin < 0;
  scene.text(
    "marks", "lowest", maps.toX(0) + (negative ? -8 : 8), inner.y + 14,
    `smallest ${result.lambdaMin.toFixed(2).replace("-", "−")}`, "", negative ? "end" : "start",
  );
}

/** The cost, what it is at least, and between them the most that can be gained. */
function drawCosts(scene, box, n, result, cost, lower) {
  const maps = putAxes(scene, "grid", "costs", box,
    { domain: [-1, 8 * n + 2], label: "cost" }, { domain: [0, 1], label: "", ticks: [] });
  const { inner } = maps;
  const y = inner.y + 0.5 * inner.height - 2;
  scene.text("marks", "costs-head", box.x + 4, box.y - 2, "Bar: at most to gain", "rs-head");
  const [left, right] = [maps.toX(lower), maps.toX(cost)];
  scene.path("areas", "gap", "rs-area rs-bound is-accent", `M${left} ${y - 11}H${right}V${y + 11}H${left}Z`);
  scene.path("lines", "lower", "rs-edge rs-bound is-accent", `M${left} ${y - 14}V${y + 14}`, 2.5);
  const best = maps.toX(result.best);
  scene.path("lines", "best", "rs-edge is-inlier", `M${best} ${y - 16}V${y + 22}`, 2.5);
  scene.text("marks", "best-text", best + 8, y + 26, `lowest ${result.best.toFixed(2)}`, "rs-halo");
  scene.path("marks", "cost", "rs-full is-estimate", `M${right} ${y - 9}l9 9l-9 9l-9 -9Z`);
  const atRight = right > inner.x + inner.width - 90;
  const [aside, anchor] = atRight ? [-14, "end"] : [14, "start"];
  scene.text("marks", "cost-text", right + aside, y - 14, `cost ${result.cost.toFixed(2)}`, "rs-halo", anchor);
}

function certificateCaption({ state, result }) {
  const number = (value) => (Math.abs(value) < 0.005 ? 0 : value).toFixed(2).replace("-", "−");
  const where = result.r === 2 ? "In the plane" : `With ${result.r} rows`;
  const step = result.step ? `Step ${result.step} of ${result.last}. ` : "";
  const values = `${step}${where} the cost is ${number(result.cost)} and the smallest eigenvalue is ${number(result.lambdaMin)}`;
  const gain = `at most ${number(result.bound)} can be gained`;
  if (result.verdict === "certified") return `${values}: certified, no headings cost less.`;
  if (result.verdict === "not stationary") {
    return `${values}. The headings are not stationary: a descent has to finish first. Still, ${gain}.`;
  }
  const way = result.step < result.last ? " One more row opens a way out." : "";
  return `${values}: not certified, but ${gain}.${way}`;
}
