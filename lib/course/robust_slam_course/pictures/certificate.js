import { certify, connectionMatrix, headingsRow, quadraticCost } from "../canvas/js/solve/certificate.js";
import { pulledRing } from "../canvas/js/solve/ring.js";
import { putAxes, putPath } from "../canvas/js/draw/axes.js";
import { numberText } from "../canvas/js/draw/number.js";
import { putHandle } from "../canvas/js/draw/handle.js";
import { freePlace } from "../canvas/js/draw/labels.js";
import { boundedNumber } from "../canvas/js/draw/link.js";
import { livePicture } from "../canvas/js/draw/picture.js";
import { pathThrough } from "../canvas/js/draw/scene.js";
import { WIDE } from "../canvas/js/draw/stage.js";

/**
 * Headings on a ring of which the first is nailed. The reader pulls another one and the rest follow,
 * and the cost is drawn as far as it was pulled; beside it stands the spectrum of the certificate.
 */
export function render(context) {
  const { main } = context.model.get("data");
  const all = {
    alpha: {
      kind: "slider", name: "alpha", label: "Measured turn α", min: 0, max: 90, step: 1, text: (alpha) => `${alpha}°`,
    },
    ring: { kind: "choice", name: "ring", label: "Headings", options: [["five", "five"], ["three", "three"]] },
    go: {
      kind: "button", label: "Let go", when: ({ turn }) => turn !== 0,
      does: (state, { winding }) => ({ twisted: winding !== 0, turn: 0, far: 0 }),
    },
    twist: {
      kind: "button", label: "Twist the ring", when: ({ twisted, turn }) => !twisted || turn !== 0,
      does: () => ({ twisted: true, turn: 0, far: 0 }),
    },
  };
  return livePicture(context, {
    layers: ["areas", "grid", "lines", "marks"],
    controls: (main === "alpha" ? ["alpha", "ring"] : ["go", "twist"]).map((name) => all[name]),
    main: [main],
    seen: main === "alpha" ? null : (_, { cost, trace }) => cost < trace[0][1] - 0.005,
    clean: cleanCertificate,
    solve: solveCertificate,
    moving: ({ arrows, eigenvalues }) => [...arrows, ...eigenvalues],
    draw: drawCertificate,
    caption: certificateCaption,
  });
}

function cleanCertificate({ ring, alpha, twisted, held, turn, far }) {
  const last = ring === "three" ? 2 : 4;
  const turned = boundedNumber(turn, [-180, 180], 0, 0);
  const farthest = boundedNumber(far, [-180, 180], 0, 0);
  return {
    ring, twisted: Boolean(twisted), alpha: boundedNumber(alpha, [0, 90], 0, 0),
    held: boundedNumber(held, [1, last], 1, 0), turn: turned + 0,
    far: (Math.abs(turned) > Math.abs(farthest) ? turned : farthest) + 0,
  };
}

function solveCertificate({ ring, alpha, twisted, held, turn, far }) {
  const n = ring === "three" ? 3 : 5;
  const edges = Array.from({ length: n }, (_, k) => [k, (k + 1) % n]);
  const Q = connectionMatrix(n, edges, Array(n).fill(inRadians(alpha)));
  const rest = Array.from({ length: n }, (_, k) => (twisted ? inRadians(wholeDegrees((360 * k) / n)) : 0));
  const steps = pulledRing(rest, inRadians(alpha), held, [far, turn].map(inRadians));
  const { headings } = steps.at(-1);
  const row = headingsRow(headings);
  const around = edges.reduce((sum, [i, j]) => sum + wrapped(headings[j] - headings[i]), 0);
  return {
    ...certify(Q, row), headings, winding: Math.round(around / (2 * Math.PI)),
    trace: steps.map((step) => [(step.turn * 180) / Math.PI, quadraticCost(Q, headingsRow(step.headings))]),
    arrows: headings.flatMap((angle) => [Math.cos(angle), Math.sin(angle)]),
    misfits: edges.map((edge) => quadraticCost(connectionMatrix(n, [edge], [inRadians(alpha)]), row)),
  };
}

/** The nearest whole number of degrees in (−180, 180]. */
function wholeDegrees(value) {
  const turned = Math.round(value) % 360;
  if (turned > 180) return turned - 360;
  return turned <= -180 ? turned + 360 : turned + 0;
}

function inRadians(degrees) {
  return (degrees * Math.PI) / 180;
}

function wrapped(angle) {
  return Math.atan2(Math.sin(angle), Math.cos(angle));
}

function drawCertificate(scene, { state, result, shown, width, height, data, change }) {
  const [wide, pulls] = [width >= WIDE, data.main !== "alpha"];
  const size = wide ? Math.min(height, 0.52 * width) : (pulls ? 0.42 : 0.56) * height;
  const n = result.headings.length;
  const corner = wide ? { x: 0, y: (height - size) / 2 } : { x: (width - size) / 2, y: 0 };
  drawRing(scene, { ...corner, size }, state, result, shown.subarray(0, 2 * n), change);
  const side = wide ? { x: size + 10, y: 0, width: width - size - 10, height }
    : { x: 0, y: size, width, height: height - size };
  const upper = pulls ? (wide ? 0.56 : 0.5) * side.height : 0;
  if (pulls) drawTrace(scene, { ...side, height: upper }, result);
  drawSpectrum(scene, { ...side, y: side.y + upper, height: side.height - upper }, result, shown.subarray(2 * n));
}

function drawRing(scene, { x, y, size }, state, result, arrows, change) {
  const n = result.headings.length;
  const [radius, length] = [0.27 * size, 0.19 * size];
  const spots = result.headings.map((_, k) => [
    x + size / 2 + radius * Math.cos((2 * Math.PI * k) / n), y + size / 2 - radius * Math.sin((2 * Math.PI * k) / n),
  ]);
  const tips = spots.map(([px, py], k) => [px + length * arrows[2 * k], py - length * arrows[2 * k + 1]]);
  spots.forEach((spot, k) => {
    const next = spots[(k + 1) % n];
    const misfit = result.misfits[k];
    scene.path("lines", `edge-${k}`, "rs-edge is-muted", pathThrough([spot, next]), 1 + 0.7 * misfit);
    scene.path("lines", `arrow-${k}`, "rs-edge is-estimate", pathThrough([spot, tips[k]]), 3);
    const look = k ? "rs-open is-estimate" : "rs-open is-ink";
    scene.put("lines", `pose-${k}`, "circle", { class: look, cx: spot[0], cy: spot[1], r: 4.5 });
    if (k) putHeading(scene, k, tips[k], spot, state, result, change);
    else scene.path("lines", "nail", "is-ink", `M${tips[0][0]} ${tips[0][1]}m-5 -5l10 10m0 -10l-10 10`, 2.5);
    if (state.alpha) putTurn(scene, k, spot, length, result.headings[(k + n - 1) % n], inRadians(state.alpha));
    if (size < 250) return; // a phone has no room for words
    if (!k) scene.text("marks", "nailed", tips[0][0], tips[0][1] + 24, "nailed", "rs-tick", "middle");
    const along = (share) => [0, 1].map((axis) => spot[axis] + share * (next[axis] - spot[axis]));
    const middle = freePlace([0.5, 0.36, 0.64, 0.24, 0.76].map(along), tips, 28);
    const words = misfit.toFixed(misfit < 9.95 ? 2 : 1);
    scene.text("marks", `misfit-${k}`, middle[0], middle[1] + 5, words, "rs-halo", "middle");
  });
}

/** Where the heading before measures this one to be, turned by `alpha` (rad) from its own direction. */
function putTurn(scene, k, [x, y], length, before, alpha) {
  const [from, to, name] = [[before, 1], [before + alpha, 1], [before + alpha + 0.4, 0.8]].map(([angle, share]) => [
    x + share * length * Math.cos(angle), y - share * length * Math.sin(angle),
  ]);
  scene.path("areas", `turn-${k}`, "rs-area is-muted", `M${x} ${y}L${from}A${length} ${length} 0 0 0 ${to}Z`);
  scene.path("areas", `measured-${k}`, "is-ghost", pathThrough([[x, y], to]), 2);
  if (k === 1) scene.text("marks", "alpha", name[0], name[1] + 5, "α", "rs-head", "middle");
}

/** The tip of a heading; another one than before is pulled from where the ring rests. */
function putHeading(scene, k, [x, y], [px, py], state, result, change) {
  const mine = state.held === k;
  const angle = (180 * wrapped(result.headings[k])) / Math.PI;
  const pull = (by) => change({ held: k, turn: (mine ? state.turn : 0) + by, far: mine ? state.far : 0 });
  putHandle(scene, `heading-${k}`, {
    x, y, label: `Heading ${k + 1}`, text: `${numberText(Math.round(angle))} degrees, cost ${result.cost.toFixed(2)}`,
    now: Math.round(angle), least: -180, most: 180, unit: 3,
    drag: (toX, toY) => pull((180 * wrapped(Math.atan2(py - toY, toX - px) - result.headings[k])) / Math.PI),
    step: (right, up) => pull(3 * (right || up)),
  });
}

/** The cost over the turn of the heading that is pulled, as far as it was pulled. */
function drawTrace(scene, box, { trace, cost }) {
  const maps = putAxes(scene, "grid", "trace", box,
    { domain: [-185, 185], label: "turn of the heading that you pull (°)", ticks: [-180, -90, 0, 90, 180] },
    { domain: [0, 20], label: "cost", ticks: [0, 10, 20] });
  const points = trace.map(([turn, value]) => [maps.toX(turn), maps.toY(value)]);
  const start = maps.toY(trace[0][1]);
  scene.path("grid", "start", "is-ghost", `M${maps.inner.x} ${start}h${maps.inner.width}`, 2);
  putPath(scene, "lines", "trace-line", maps, points, { class: "is-ink", "stroke-width": 2.5 });
  const [x, y] = points.at(-1);
  scene.path("marks", "cost", "rs-full is-ink", `M${x} ${y - 7}l7 7l-7 7l-7 -7Z`);
  const words = `cost ${cost.toFixed(2)}`;
  const left = x > maps.inner.x + 0.75 * maps.inner.width;
  const [aside, anchor] = left ? [-12, "end"] : [12, "start"];
  scene.text("marks", "cost-text", x + aside, Math.max(y - 10, maps.inner.y + 14), words, "rs-halo", anchor);
}

function drawSpectrum(scene, { x: left, y: head, width, height }, result, eigenvalues) {
  const box = { x: left, y: head + 22, width, height: height - 22 };
  const maps = putAxes(scene, "grid", "spectrum", box,
    { domain: [-4.4, 4.4], label: height < 140 ? null : "eigenvalue", ticks: [-4, -2, 0, 2, 4] }, { domain: [0, 1], label: "", ticks: [] });
  const { inner } = maps;
  const rise = Math.min(15, (inner.height - 14) / 3);
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
    const y = inner.y + inner.height - Math.min(12, 0.5 * rise) - rise * above;
    const exact = result.eigenvalues[k];
    const kind = Math.abs(exact) <= nought ? "zero" : exact < 0 ? "below" : "above";
    const d = kind === "below" ? `M${x - 6} ${y - 5}H${x + 6}L${x} ${y + 6}Z`
      : `M${x - 5} ${y}a5 5 0 1 0 10 0a5 5 0 1 0 -10 0Z`;
    const looks = { zero: "rs-open is-ink", above: "rs-full is-muted", below: "rs-full is-outlier" };
    scene.path("marks", `value-${k}`, `rs-eigen ${looks[kind]}`, d);
  });
  const negative = result.lambdaMin < 0;
  if (rise === 15) scene.text(
    "marks", "lowest", maps.toX(0) + (negative ? -8 : 8), inner.y + 14,
    `smallest ${result.lambdaMin.toFixed(2).replace("-", "−")}`, "", negative ? "end" : "start",
  );
}

function certificateCaption({ state, result }) {
  const number = (value) => (Math.abs(value) < 0.005 ? 0 : value).toFixed(2).replace("-", "−");
  const [cost, n] = [result.trace[0][1], result.headings.length];
  const now = `the cost is ${number(result.cost)} and the smallest eigenvalue is ${number(result.lambdaMin)}`;
  if (!state.turn) {
    const ring = state.twisted ? `The ring of ${n} is twisted once and rests` : `The ${n} headings rest`;
    const proof = result.verdict === "certified" ? "certified, no headings cost less" : "not certified";
    return `${ring}: ${now}: ${proof}.`;
  }
  const pulled = `Heading ${state.held + 1}, turned by ${numberText(state.turn)}°,`;
  const fromTo = `from ${number(cost)} to ${number(result.cost)}`;
  if (state.twisted && !result.winding) return `${pulled} has untwisted the ring, and the cost falls ${fromTo}.`;
  const way = result.cost > cost + 0.005 ? "raises" : result.cost < cost - 0.005 ? "lowers" : "keeps";
  const others = state.twisted ? "and the ring stays twisted" : "and the others follow";
  return `${pulled} ${way} the cost ${fromTo}, ${others}.`;
}
