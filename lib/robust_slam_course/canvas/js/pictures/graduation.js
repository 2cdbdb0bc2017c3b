import { numberText, putTurned } from "../draw/axes.js";
import { putHandle } from "../draw/handle.js";
import { livePicture } from "../draw/picture.js";
import { sideBySide, WIDE } from "../draw/stage.js";

/**
 * Counts of good maps over two axes, odometry noise and claimed σ: a heat map for IRLS and one for
 * GNC. The reader moves a point in that plane, and each heat map tells its count there.
 */
export function render(context) {
  return livePicture(context, {
    layers: ["squares", "frames", "words"],
    controls: [
      {
        kind: "choice", name: "start", label: "Start at",
        options: context.model.get("data").starts.map((start) => [start, start]),
      },
      { kind: "choice", name: "kernel", label: "Kernel", options: [["TLS", "TLS"], ["GM", "Geman–McClure"]] },
      {
        kind: "choice", name: "kind", label: "Outliers",
        options: [["random", "random"], ["consistent", "consistent in groups of 5"]],
      },
      {
        kind: "choice", name: "percent", label: "of all closures",
        options: [["50", "50 %"], ["75", "75 %"]],
      },
    ],
    main: ["start"],
    clean: cleanGraduation,
    solve: countsAtPoint,
    draw: drawGraduation,
    caption: graduationCaption,
  });
}

function cleanGraduation(state, { noises, claims }) {
  const within = (value, values) => (Number.isInteger(value)
    ? Math.min(values.length - 1, Math.max(0, value)) : 2);
  return { ...state, noise: within(state.noise, noises), claim: within(state.claim, claims) };
}

/**
 * The table of the chosen outliers, `good[start][method][claim][noise]`, its counts at the point,
 * and the largest of them.
 */
function countsAtPoint({ kind, percent, noise, claim }, { good }) {
  const table = good[`${kind} ${percent}`];
  const here = table.map((methods) => methods.map((grid) => grid[claim][noise]));
  return { table, here, best: Math.max(...here.flat()) };
}

const [TITLE, AXIS_LEFT, AXIS_BOTTOM] = [24, 48, 42]; // pixels

function drawGraduation(scene, { state, result, width, height, data, change }) {
  const all = { x: AXIS_LEFT, y: TITLE, width: width - AXIS_LEFT - 2, height: height - TITLE - AXIS_BOTTOM };
  const s = data.starts.indexOf(state.start);
  const chosen = data.methods.flatMap((method, m) => (method.endsWith(state.kernel) ? [m] : []));
  sideBySide(all, [1, 1]).forEach((box, k) => {
    const m = chosen[k];
    const cell = [box.width / data.noises.length, box.height / data.claims.length];
    const count = result.here[s][m];
    scene.text("words", `${k}-title`, box.x, box.y - 8, `${data.methods[m]}: ${count} of ${data.runs}`, "rs-head");
    putSquares(scene, String(k), box, cell, result.table[s][m], data.runs);
    const frame = `M${box.x} ${box.y}h${box.width}v${box.height}h${-box.width}Z`;
    scene.path("frames", `${k}-frame`, "is-muted", frame, 1);
    putPanelAxes(scene, k, box, cell, data, width);
    const x = box.x + (state.noise + 0.5) * cell[0];
    const y = box.y + box.height - (state.claim + 0.5) * cell[1];
    if (k) scene.put("words", "there", "circle", { class: "rs-ring is-ink", cx: x, cy: y, r: 8 });
    else putPoint(scene, { x, y }, box, cell, state, data, change);
  });
}

/** A square for each place of the plane; its area and its colour tell the share of good maps. */
function putSquares(scene, key, { x, y }, [wide, tall], counts, runs) {
  const paths = new Map();
  const rows = counts.length;
  counts.forEach((row, claim) => row.forEach((count, noise) => {
    if (!count) return;
    const [w, h] = [wide, tall].map((size) => 0.94 * size * Math.sqrt(count / runs));
    const left = x + (noise + 0.5) * wide - w / 2;
    const top = y + (rows - claim - 0.5) * tall - h / 2;
    const square = `M${left.toFixed(1)} ${top.toFixed(1)}h${w.toFixed(1)}v${h.toFixed(1)}h${(-w).toFixed(1)}Z`;
    paths.set(count, (paths.get(count) ?? "") + square);
  }));
  for (const [count, d] of paths) {
    const percent = Math.round(25 + (75 * count) / runs);
    const style = `fill:color-mix(in srgb,var(--rs-estimate) ${percent}%,var(--rs-card));stroke:none`;
    scene.put("squares", `${key}-${count}`, "path", { d, style });
  }
}

function putPanelAxes(scene, key, { x, y, width, height }, cell, { noises, claims }, all) {
  if (!key) {
    claims.forEach((claim, k) => {
      scene.text("words", `y-${k}`, x - 6, y + height - (k + 0.5) * cell[1] + 5, claimText(claim), "rs-tick", "end");
    });
    putTurned(scene, "words", "yl", 13, y + height / 2, "claimed / true σ");
  }
  noises.forEach((noise, k) => {
    const across = x + (k + 0.5) * cell[0];
    scene.text("words", `${key}-x-${k}`, across, y + height + 17, numberText(100 * noise), "rs-tick", "middle");
  });
  const label = all < WIDE ? "noise (0.01 rad)" : "odometry noise (0.01 rad a step)";
  scene.text("words", `${key}-xl`, x + width / 2, y + height + 36, label, "", "middle");
}

function putPoint(scene, { x, y }, box, [wide, tall], state, { noises, claims }, change) {
  const clamp = (value, values) => Math.min(values.length - 1, Math.max(0, value));
  const move = (noise, claim) => change({ noise: clamp(noise, noises), claim: clamp(claim, claims) });
  putHandle(scene, "point", {
    x, y, label: "Odometry noise and claimed σ",
    text: `noise ${noises[state.noise]} rad a step, claimed σ ${claimText(claims[state.claim])} times the true one`,
    now: state.noise + noises.length * state.claim, least: 0, most: noises.length * claims.length - 1,
    drag: (px, py) => move(Math.floor((px - box.x) / wide), Math.floor((box.y + box.height - py) / tall)),
    step: (right, above) => move(state.noise + Math.sign(right), state.claim + Math.sign(above)),
  });
}

function claimText(claim) {
  return { 0.25: "¼", 0.5: "½" }[claim] ?? String(claim);
}

function graduationCaption({ state, result, data }) {
  const { here, best } = result;
  const from = data.starts.map((start, s) => {
    const most = Math.max(...here[s]);
    const names = data.methods.filter((_, m) => here[s][m] === most);
    if (!most) return `from ${start} none has any`;
    const who = names.length === data.methods.length ? "all four methods have" : `${listed(names)} ${names.length > 1 ? "have" : "has"}`;
    return `from ${start} ${who} ${most}`;
  });
  const claim = data.claims[state.claim];
  const claimed = claim === 1 ? "the true σ is claimed" : `${claimText(claim)} of the true σ is claimed`;
  const where = `Noise ${numberText(data.noises[state.noise])} rad a step, ${claim > 1 ? `${claim} times the true σ is claimed` : claimed}.`;
  const what = `${state.percent} % of the closures are ${state.kind} outliers.`;
  if (!best) return `${where} ${what} No method, from either start, has a good map among ${data.runs}.`;
  return `${where} ${what} Good maps of ${data.runs}: ${from.join("; ")}.`;
}

function listed(names) {
  return names.length < 2 ? names.join("") : `${names.slice(0, -1).join(", ")} and ${names.at(-1)}`;
}
