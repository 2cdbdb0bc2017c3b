import { putHandle } from "../draw/handle.js";
import { putLegend } from "../draw/legend.js";
import { fitMap, posePixels, putDrive, putEdge } from "../draw/map.js";
import { putMarker } from "../draw/marker.js";
import { livePicture } from "../draw/picture.js";

/**
 * The stages from the camera to the map, and the map of one drive. The reader lets one stage fail
 * and sees what the later stages report. Outcomes were computed before: see `tools/data/machine.py`.
 */
export function render(context) {
  const { stages } = context.model.get("data");
  return livePicture(context, {
    layers: ["ghost", "edges", "drive", "marks", "arrows", "boxes", "words"],
    controls: [{
      kind: "choice", name: "broken", label: "What fails",
      options: stages.map(({ key, name }) => [key, name]),
    }],
    clean: ({ broken }, { outcomes }) => ({
      broken: Object.hasOwn(outcomes, broken) ? broken : "nothing",
    }),
    solve: ({ broken }, { outcomes }) => outcomes[broken],
    moving: ({ poses }) => Float64Array.from(poses),
    height: (width) => machineLayout(width).height,
    draw: drawMachine,
    caption: machineCaption,
  });
}

const [ROW, BOX_HEIGHT] = [48, 36]; // pixels
const BOX_CENTRES = { left: 0.25, right: 0.775, middle: 0.51, across: 0.51 }; // of the diagram's width
const BOX_WIDTHS = { left: 0.44, right: 0.44, middle: 0.44, across: 0.96 };
/** Of a closure by its number: an inlier, kept or rejected, or an outlier, kept or rejected. */
const CLOSURE_LOOKS = [
  { look: "is-inlier", name: "inlier, kept", mark: ["circle", "inlier"] },
  { look: "is-accent", name: "inlier, rejected", mark: ["square", "accent"] },
  { look: "is-outlier", name: "outlier, kept", mark: ["diamond", "outlier"] },
  { look: "is-rejected", name: "outlier, rejected" },
];

/** The stages beside the map, or above it where the page is narrow. */
function machineLayout(width) {
  const [rows, wide] = [9, width >= 600];
  const across = wide ? 0.53 * width : width;
  const tall = rows * ROW;
  const map = wide
    ? { x: across + 14, y: 0, width: width - across - 14, height: tall }
    : { x: 0, y: tall + 8, width, height: 340 };
  return { across, map, height: wide ? tall : tall + 348 };
}

function stageBox({ row, place }, across) {
  const width = BOX_WIDTHS[place] * across;
  const middle = BOX_CENTRES[place] * across;
  return { x: middle - width / 2, y: 4 + row * ROW, width, middle, centre: 4 + row * ROW + BOX_HEIGHT / 2 };
}

function drawMachine(scene, view) {
  const layout = machineLayout(view.width);
  drawStageArrows(scene, view.data, layout.across);
  view.data.stages.forEach((stage) => drawStage(scene, stage, view, layout.across));
  drawOutcome(scene, view, layout.map);
  putBreakHandle(scene, view, layout.across);
}

function drawStageArrows(scene, { stages, arrows }, across) {
  const named = new Map(stages.map((stage) => [stage.key, stage]));
  arrows.forEach(([source, target, share]) => {
    const x = share * across;
    const top = stageBox(named.get(source), across).y + BOX_HEIGHT;
    const low = stageBox(named.get(target), across).y;
    scene.put("arrows", `${source}-${target}`, "path", {
      class: "is-muted", d: `M${x} ${top}V${low}M${x - 3.5} ${low - 5}L${x} ${low}L${x + 3.5} ${low - 5}`,
    });
  });
}

function drawStage(scene, stage, { state, result }, across) {
  const box = stageBox(stage, across);
  const report = stageReport(stage.key, state, result);
  const [look, stroke] = state.broken === stage.key ? ["is-outlier", 3] : report.alarm ? ["is-estimate", 3] : ["is-muted", 1];
  scene.put("boxes", `${stage.key}-box`, "path", {
    class: look, "stroke-width": stroke, d: `M${box.x} ${box.y}h${box.width}v${BOX_HEIGHT}h${-box.width}Z`,
  });
  const at = { x: box.middle, "text-anchor": "middle" };
  const y = report.text ? box.y + 15 : box.centre + 4;
  scene.put("words", `${stage.key}-name`, "text", { ...at, y, class: report.alarm || state.broken === stage.key ? "rs-head" : "" }, stage.name);
  if (report.text) scene.put("words", `${stage.key}-report`, "text", { ...at, y: box.y + 30, class: "rs-tick" }, report.text);
}

/** What a stage reports, and whether that is a sign that something is wrong. */
function stageReport(key, { broken }, { told, passed, left, certified }) {
  const shown = (counts) => ({
    text: `${counts[0]} inliers, ${counts[1]} outliers`, alarm: counts[0] < told[0] && broken !== "plan",
  });
  if (broken === key) return { text: key === "nothing" ? "" : "fails", alarm: false };
  if (key === "pcm" && passed) return shown(passed);
  if (key === "solve" && left) return shown(left);
  if (key === "certificate") return { text: certified ? "certified" : "not certified", alarm: !certified };
  return { text: "", alarm: false };
}

function drawOutcome(scene, { result, shown, data }, { x, y, width, height }) {
  const top = putLegend(scene, "words", "legend", x, y, width, [
    ["is-ghost", "true path"], ["is-estimate", "map"], ...CLOSURE_LOOKS.map(({ look, name }) => [look, name]),
  ]);
  const map = fitMap({ x, y: y + top, width, height: height - top }, data.extent, 12);
  putDrive(scene, "ghost", "truth", map, data.truth, "is-ghost");
  putDrive(scene, "drive", "map", map, shown, "is-estimate");
  result.closures.forEach(([i, j, kind], k) => {
    const { look, mark } = CLOSURE_LOOKS[kind];
    putEdge(scene, "edges", `edge-${k}`, map, shown, [i, j], look);
    if (!mark) return;
    // A kept closure joins two poses at one place: its line has hardly a length.
    const [one, two] = [posePixels(map, shown, i), posePixels(map, shown, j)];
    putMarker(scene, "marks", `mark-${k}`, (one[0] + two[0]) / 2, (one[1] + two[1]) / 2, ...mark);
  });
}

function putBreakHandle(scene, { state, data, change }, across) {
  const boxes = data.stages.map((stage) => stageBox(stage, across));
  const now = data.stages.findIndex(({ key }) => key === state.broken);
  const choose = (k) => change({ broken: data.stages[Math.min(boxes.length - 1, Math.max(0, k))].key });
  const at = (box) => [box.x, box.centre];
  putHandle(scene, "broken", {
    x: at(boxes[now])[0], y: at(boxes[now])[1], look: "rs-wrong",
    label: "The stage that fails", text: data.stages[now].name, now: boxes.length - 1 - now, least: 0, most: boxes.length - 1,
    drag: (px, py) => {
      const far = boxes.map((box) => Math.hypot(at(box)[0] - px, at(box)[1] - py));
      choose(far.indexOf(Math.min(...far)));
    },
    step: (right, up) => choose(now - Math.sign(right || up)), // up is nearer to the camera
  });
}

function machineCaption({ state, result, data }) {
  const { told, passed, left, kept, certified, off } = result;
  const stage = data.stages.find(({ key }) => key === state.broken);
  const number = (counts) => counts.join(" and ");
  const steps = [passed && `PCM keeps ${number(passed)}`, left && `GNC ${number(left)}`, `the map ${number(kept)}`];
  const chain = steps.filter(Boolean).join(", ");
  return `${stage.fault} Of ${told[0]} inliers and ${told[1]} outliers ${chain}. The map is ${off.toFixed(2)} m off and ${certified ? "" : "not "}certified.`;
}
