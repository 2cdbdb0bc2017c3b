import { numberText } from "../canvas/js/draw/number.js";
import { putHandle } from "../canvas/js/draw/handle.js";
import { boundedNumber } from "../canvas/js/draw/link.js";
import { fitMap, putDrive, putEdge } from "../canvas/js/draw/map.js";
import { livePicture } from "../canvas/js/draw/picture.js";
import { posesOf } from "../canvas/js/draw/steps.js";
import { twoPanels, WIDE } from "../canvas/js/draw/stage.js";

/**
 * Closures run as beads through a pipe of stages, and those that a stage rejects fall out below it.
 * The reader turns a dial by which one stage fails, and sees the map bend and which lamp lights.
 * Every outcome is the library's, see `robust_slam_course.failures`.
 */
export function render(context) {
  return livePicture(context, {
    layers: ["pipe", "beads", "ghost", "edges", "drive", "dials", "words"],
    controls: [{
      kind: "button", label: "All dials to 0", when: ({ value }) => value > 0, does: () => ({ value: 0 }),
    }],
    main: ["All dials to 0"],
    seen: ({ dial }, { off }) => !dial && off > LOST_AT,
    clean: cleanMachine,
    solve: solveMachine,
    moving: ({ poses, beads }) => Float64Array.from([...poses, ...beads.flat()]),
    height: (width) => (width < WIDE ? 396 : 380),
    draw: drawMachine,
    caption: machineCaption,
  });
}

const PIPE_STAGES = ["Odometry", "Places", "PCM", "GNC", "Certificate", "map"];
const SHORT = ["Odom.", "Places", "PCM", "GNC", "Cert.", "map"];
const [PIPE_TOP, PIPE_HEIGHT, FALL_HEIGHT] = [42, 22, 40]; // pixels
const BEAD = 9; // pixels from one bead to the next
const ENDS = { p: 2, g: 3, m: 5 }; // the stage at which a closure ends
const FAILS = [0, 1, 4]; // the stage of each dial
const LOST_AT = 1; // m off the true path

function cleanMachine({ dial, value, tried }, { dials }) {
  const one = boundedNumber(dial, [0, dials.length - 1], 0, 0);
  const last = (k) => dials[k].values.length - 1;
  const now = boundedNumber(value, [0, last(one)], 0, 0);
  const farthest = dials.map((_, k) => Math.max(boundedNumber(tried[k], [0, last(k)], 0, 0), k === one ? now : 0));
  return { dial: one, value: now, tried: farthest };
}

function solveMachine({ dial, value }, { dials, unit, inliers }) {
  const run = dials[dial].runs[value];
  const ended = {};
  const beads = [...run.fates].map((fate) => {
    ended[fate] = (ended[fate] ?? -1) + 1;
    return [ENDS[fate], ended[fate]];
  });
  // Those that this dial does not make wait before the pipe.
  const most = Math.max(...dials.flatMap(({ runs }) => runs.map(({ fates }) => fates.length)));
  while (beads.length < most) beads.push([0, 0]);
  const of = (fate, from, to) => [...run.fates].slice(from, to).filter((one) => one === fate).length;
  const through = [of("m", 0, inliers), of("m", inliers)];
  return { ...run, beads, through, poses: posesOf(run.steps, unit) };
}

function drawMachine(scene, view) {
  const { width, height, data, shown } = view;
  const top = PIPE_TOP + PIPE_HEIGHT + FALL_HEIGHT + 4;
  const [dials, map] = twoPanels({ x: 0, y: top, width, height: height - top }, [1.2, 1], 0.52, 16);
  drawPipe(scene, view);
  drawBeads(scene, view, shown.subarray(data.truth.length));
  drawMachineMap(scene, view, width < WIDE ? dials : map);
  data.dials.forEach((_, k) => drawDial(scene, view, width < WIDE ? map : dials, k));
}

/** The middle of a stage, across. */
function stageAt(width, k) {
  return ((k + 0.5) * width) / PIPE_STAGES.length;
}

function drawPipe(scene, { width, state, result }) {
  const floor = PIPE_TOP + PIPE_HEIGHT;
  const failing = state.value ? FAILS[state.dial] : -1;
  const half = 0.42 * (width / PIPE_STAGES.length);
  scene.path("pipe", "walls", "is-muted", `M0 ${PIPE_TOP}H${width}M0 ${floor}H${stageAt(width, 4.5)}`, 1.5);
  PIPE_STAGES.forEach((name, k) => {
    const x = stageAt(width, k);
    scene.text("words", `stage-${k}`, x, 14, width < WIDE ? SHORT[k] : name, k === failing ? "rs-head" : "", "middle");
    if (k === 5) return;
    const lit = k === 4 && !result.certified;
    if (k === 2 || k === 3) scene.path("pipe", `hole-${k}`, "is-grid", `M${x - half} ${floor}H${x + half}`, 3);
    scene.put("pipe", `lamp-${k}`, "circle", {
      class: `rs-lamp ${lit ? "is-outlier" : "is-muted"}`, cx: x, cy: 28, r: lit ? 7 : 5,
      style: `fill:var(--rs-${lit ? "outlier" : "card"});stroke-dasharray:none;stroke-width:1.5`,
    });
    if (lit) scene.path("pipe", "rays", "is-outlier", `M${x - 17} 28h6m22 0h6M${x - 14} 18l4 4m20 0l4 -4`, 2);
  });
}

function drawBeads(scene, { width, result, data }, beads) {
  const across = Math.floor((0.86 * width) / PIPE_STAGES.length / BEAD);
  result.fates.split("").forEach((_, k) => {
    const [stage, place] = beads.subarray(2 * k, 2 * k + 2);
    const [row, column] = [Math.floor((place + 0.5) / across), (place + 0.5) % across];
    const x = stageAt(width, stage) + (column - 0.5 * across) * BEAD;
    const fallen = stage < 4.5 && stage > 0.5;
    const y = fallen ? PIPE_TOP + PIPE_HEIGHT + 8 + row * BEAD : PIPE_TOP + 5 + row * BEAD * 0.8;
    const inlier = k < data.inliers;
    const shape = inlier ? "m-3.6 0a3.6 3.6 0 1 0 7.2 0a3.6 3.6 0 1 0 -7.2 0Z" : "m0 -4.5l4.5 4.5l-4.5 4.5l-4.5 -4.5Z";
    scene.put("beads", `bead-${k}`, "path", {
      class: `rs-full ${inlier ? "is-inlier" : "is-outlier"}`, d: `M${x} ${y}${shape}`,
      style: "stroke-width:0;stroke-dasharray:none",
    });
  });
}

function drawMachineMap(scene, { result, shown, data }, box) {
  const map = fitOfAll(scene, box, data);
  const poses = shown.subarray(0, data.truth.length);
  putDrive(scene, "ghost", "truth", map, data.truth, "is-ghost");
  putDrive(scene, "drive", "map", map, poses, "is-estimate");
  [...result.fates].forEach((fate, k) => {
    if (fate !== "m") return;
    putEdge(scene, "edges", `edge-${k}`, map, poses, data.closures[k], k < data.inliers ? "is-inlier" : "is-outlier");
  });
}

/** One scale for every outcome, so that a map that bends is seen to grow. */
function fitOfAll(scene, box, { dials, unit }) {
  const size = `${box.width} ${box.height}`;
  if (!scene.fits.has(size)) {
    const all = dials.flatMap(({ runs }) => runs.flatMap(({ steps }) => posesOf(steps, unit)));
    scene.fits.set(size, fitMap(box, all, 6));
  }
  return scene.fits.get(size);
}

/** A dial, and above it from where on the map was lost and a lamp lit, as far as it was turned. */
function drawDial(scene, { state, data, change }, { x, y, width, height }, k) {
  const { label, unit, values, runs } = data.dials[k];
  const [each, last] = [height / data.dials.length, values.length - 1];
  const now = state.dial === k ? state.value : 0;
  const [left, right, line] = [x + 12, x + width - 14, y + k * each + 0.5 * each + 8];
  const toX = (value) => left + (value / last) * (right - left);
  const valueText = `${numberText(values[now])} ${unit}`;
  scene.text("words", `name-${k}`, x, line - 17, `${label} ${numberText(values[now])}`, now ? "rs-head" : "");
  scene.path("dials", `track-${k}`, "is-muted", `M${left} ${line}H${right}`, 2);
  scene.path("dials", `turned-${k}`, "is-ink", `M${left} ${line}H${toX(state.tried[k])}`, 4);
  const first = (is) => runs.findIndex((run, at) => at <= state.tried[k] && is(run));
  const [lost, lit] = [first(({ off }) => off > LOST_AT), first(({ certified }) => !certified)];
  if (lost >= 0) {
    scene.path("dials", `lost-${k}`, "is-outlier", `M${toX(lost)} ${line - 9}v18`, 3);
    const lamp = lit < 0 ? "no lamp" : "lamp lit";
    scene.text("words", `found-${k}`, right + 12, line - 17, `lost, ${lamp}`, "rs-tick", "end");
  }
  const turn = (value) => change({ dial: k, value: Math.min(last, Math.max(0, Math.round(value))) });
  putHandle(scene, `dial-${k}`, {
    x: toX(now), y: line, label, text: valueText, now: values[now], least: values[0], most: values[last],
    unit: (values[last] - values[0]) / last,
    drag: (px) => turn(((px - left) / (right - left)) * last),
    step: (rightwards, up) => turn(now + (rightwards || up)),
  });
}

function machineCaption({ state, result: { off, certified, through, fates }, data }) {
  const { unit, values } = data.dials[state.dial];
  const [amount, how] = [numberText(values[state.value]), `${off.toFixed(2)}\u00a0m`];
  const fallen = data.inliers - through[0];
  if (!state.value) {
    return `Nothing fails: the map stays ${how} off, all ${data.inliers} inliers reach it, and PCM drops`
      + ` the ${fates.length - data.inliers} outliers.`;
  }
  const cause = [
    `A bias of ${amount} ${unit} a step`, `${amount} mistaken ${unit} in a row`, `A start of ${amount} ${unit} too many`,
  ][state.dial];
  const many = state.dial === 1 ? "" : "s";
  const harm = off > LOST_AT ? `bend${many} the map by ${how}` : `leave${many} the map ${how} off`;
  const lamp = certified ? "no lamp lights" : "the certificate’s lamp lights";
  const misled = through[1] ? `, and ${through[1]} outliers get through` : "";
  const which = fallen < data.inliers ? `${fallen} of the` : "All";
  const gone = fallen ? ` ${which} ${data.inliers} inliers fall${fallen === 1 ? "s" : ""} out${misled}.` : "";
  return `${cause} ${harm}, and ${lamp}.${gone}`;
}
