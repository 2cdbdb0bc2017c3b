import { putHandle } from "../draw/handle.js";
import { putLegend } from "../draw/legend.js";
import { fitAround, posePixels, putDrive, putEdge } from "../draw/map.js";
import { putMarker } from "../draw/marker.js";
import { livePicture } from "../draw/picture.js";
import { sideBySide, stageHeight, WIDE } from "../draw/stage.js";

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
    main: ["broken"],
    solve: ({ broken }, { outcomes }) => outcomes[broken],
    moving: ({ poses }) => Float64Array.from(poses),
    height: (width) => (width < WIDE ? 405 : stageHeight(width)),
    draw: drawMachine,
    caption: machineCaption,
  });
}

const BOX_HEIGHT = 34; // pixels
const BOX_CENTRES = { left: 0.24, right: 0.76, middle: 0.5, across: 0.5 }; // of the diagram's width
const BOX_WIDTHS = { left: 0.48, right: 0.48, middle: 0.48, across: 1 };
/** Of a closure by its number: an inlier, kept or rejected, or an outlier, kept or rejected. */
const CLOSURE_LOOKS = [
  { look: "is-inlier", name: "inlier, kept", mark: ["circle", "inlier"] },
  { look: "is-accent", name: "inlier, rejected", mark: ["square", "accent"] },
  { look: "is-outlier", name: "outlier, kept", mark: ["diamond", "outlier"] },
  { look: "is-rejected", name: "outlier, rejected" },
];

/** The box of each stage, or where the page is narrow its line in a list; beside them the map. */
function machineLayout(width, height, stages) {
  const wide = width >= WIDE;
  const [left, map] = sideBySide({ x: 2, y: 0, width: width - 2, height }, wide ? [1.13, 1] : [0.8, 1]);
  const step = wide ? height / 9 : (height - 34) / (stages.length - 1);
  const boxes = stages.map(({ key, name, row, place }, k) => {
    if (!wide) return { key, name: name.split(/[,(]/)[0], x: 12, middle: 30, centre: 14 + k * step };
    const across = BOX_WIDTHS[place] * left.width;
    const middle = left.x + BOX_CENTRES[place] * left.width;
    const y = row * step + 3;
    return { key, name, x: middle - across / 2, y, width: across, middle, centre: y + BOX_HEIGHT / 2 };
  });
  return { wide, left, map, boxes };
}

function drawMachine(scene, view) {
  const layout = machineLayout(view.width, view.height, view.data.stages);
  if (layout.wide) drawStageArrows(scene, view.data, layout);
  else scene.path("arrows", "rail", "is-muted", `M12 ${layout.boxes[0].centre}V${layout.boxes.at(-1).centre}`);
  layout.boxes.forEach((box) => drawStage(scene, box, view, layout));
  drawOutcome(scene, view, layout.map);
  putBreakHandle(scene, view, layout.boxes);
}

function drawStageArrows(scene, { arrows }, { boxes, left }) {
  const named = new Map(boxes.map((box) => [box.key, box]));
  arrows.forEach(([source, target, share]) => {
    const x = left.x + share * left.width;
    const top = named.get(source).y + BOX_HEIGHT;
    const low = named.get(target).y;
    scene.put("arrows", `${source}-${target}`, "path", {
      class: "is-muted", d: `M${x} ${top}V${low}M${x - 3.5} ${low - 5}L${x} ${low}L${x + 3.5} ${low - 5}`,
    });
  });
}

function drawStage(scene, { key, name, x, y, width, middle, centre }, { state, result }, { wide }) {
  const { text, alarm } = stageReport(key, state, result, wide);
  const broken = state.broken === key;
  const words = { x: middle, "text-anchor": wide ? "middle" : "start", class: alarm || broken ? "rs-head" : "" };
  if (!wide) {
    const colour = broken ? "outlier" : alarm ? "estimate" : "ink";
    const style = `fill:var(--rs-${colour})`;
    scene.put("words", `${key}-name`, "text", { ...words, y: centre + 5, style }, name);
    if (text) scene.put("words", `${key}-report`, "text", { ...words, y: centre + 20, class: "rs-tick" }, text);
    return;
  }
  const [look, stroke] = broken ? ["is-outlier", 3] : alarm ? ["is-estimate", 3] : ["is-muted", 1];
  scene.path("boxes", `${key}-box`, look, `M${x} ${y}h${width}v${BOX_HEIGHT}h${-width}Z`, stroke);
  scene.put("words", `${key}-name`, "text", { ...words, y: text ? y + 14 : centre + 5 }, name);
  if (text) scene.put("words", `${key}-report`, "text", { ...words, y: y + 29, class: "rs-tick" }, text);
}

/** What a stage reports, and whether that is a sign that something is wrong. */
function stageReport(key, { broken }, { told, passed, left, certified }, wide) {
  const shown = (counts) => ({
    text: wide ? `${counts[0]} inliers, ${counts[1]} outliers` : `keeps ${counts.join(" and ")}`, alarm: counts[0] < told[0] && broken !== "plan",
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
  const box = { x, y: y + top, width, height: height - top };
  const map = fitAround(scene, "map", box, data.truth, result.poses, 12);
  for (const layer of ["ghost", "edges", "drive", "marks"]) scene.clip(layer, box);
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

function putBreakHandle(scene, { state, data, change }, boxes) {
  const now = data.stages.findIndex(({ key }) => key === state.broken);
  const choose = (k) => change({ broken: data.stages[Math.min(boxes.length - 1, Math.max(0, k))].key });
  const at = (box) => [box.x, box.centre];
  putHandle(scene, "broken", {
    x: at(boxes[now])[0], y: at(boxes[now])[1], look: "rs-wrong",
    label: "The stage that fails", text: data.stages[now].name, now: boxes.length - 1 - now, least: 0, most: boxes.length - 1,
    drag: (px, py) => {
      const far = boxes.map(({ x, width = 0, centre }) => Math.hypot( // from the box, or 0 within it
        Math.max(x - px, px - x - width, 0), Math.max(Math.abs(py - centre) - (width && BOX_HEIGHT / 2), 0),
      ));
      choose(far.indexOf(Math.min(...far)));
    },
    step: (right, up) => choose(now - Math.sign(right || up)), // up is nearer to the camera
  });
}

function machineCaption({ state, result, data }) {
  const { told, passed, left, kept, certified, off } = result;
  const stage = data.stages.find(({ key }) => key === state.broken);
  const number = (counts) => counts.join(" and ");
  const chain = [["PCM", passed], ["GNC", left], ["the map", kept]].filter(([, counts]) => counts)
    .map(([name, counts], k) => `${name} ${k ? "" : "keeps "}${number(counts)}`).join(", ");
  return `${stage.fault} Of ${told[0]} inliers and ${told[1]} outliers ${chain}. The map is ${off.toFixed(2)}\u00a0m off and ${certified ? "" : "not "}certified.`;
}
