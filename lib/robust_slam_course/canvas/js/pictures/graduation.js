import { numberText } from "../draw/axes.js";
import { putHandle } from "../draw/handle.js";
import { livePicture } from "../draw/picture.js";

/**
 * Counts of good maps over two axes, odometry noise and claimed σ: a heat map for each start and
 * method. The reader moves a point in that plane, and each heat map tells its count there.
 */
export function render(context) {
  return livePicture(context, {
    layers: ["squares", "frames", "words"],
    controls: [
      {
        kind: "choice", name: "kind", label: "Outliers",
        options: [["random", "random"], ["consistent", "consistent in groups of 5"]],
      },
      {
        kind: "choice", name: "percent", label: "of all closures",
        options: [["50", "50 %"], ["75", "75 %"]],
      },
    ],
    clean: cleanGraduation,
    solve: countsAtPoint,
    height: (width) => panelGrid(width).height,
    draw: drawGraduation,
    caption: graduationCaption,
  });
}

function cleanGraduation(state, { noises, claims }) {
  const within = (value, values) => (Number.isInteger(value)
    ? Math.min(values.length - 1, Math.max(0, value)) : 2);
  return {
    kind: state.kind === "random" ? "random" : "consistent",
    percent: String(state.percent) === "75" ? "75" : "50",
    noise: within(state.noise, noises),
    claim: within(state.claim, claims),
  };
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

const [GAP, TITLE, AXIS_LEFT, AXIS_BOTTOM, START] = [10, 20, 44, 40, 24]; // pixels

/** Where the heat maps stand: starts in rows, or in columns where the page is narrow. */
function panelGrid(width) {
  const wide = width >= 600;
  const [columns, rows] = wide ? [4, 2] : [2, 4];
  const across = (width - AXIS_LEFT - GAP * (columns - 1) - 2) / columns;
  const up = wide ? 0.78 * across : 0.66 * across;
  const heading = wide ? START : 0;
  const step = up + TITLE + heading + GAP;
  const top = wide ? 0 : START;
  return {
    wide, across, up, height: Math.ceil(top + rows * step + AXIS_BOTTOM),
    place(start, method) {
      const [column, row] = wide ? [method, start] : [start, method];
      return {
        x: AXIS_LEFT + column * (across + GAP), y: top + row * step + heading + TITLE,
        isLeft: column === 0, isLow: row === rows - 1, isFirst: wide ? column === 0 : row === 0,
      };
    },
  };
}

function drawGraduation(scene, { state, result, width, data, change }) {
  const grid = panelGrid(width);
  data.starts.forEach((start, s) => data.methods.forEach((method, m) => {
    const place = grid.place(s, m);
    const key = `${s}-${m}`;
    const cell = [grid.across / data.noises.length, grid.up / data.claims.length];
    if (place.isFirst) putStartName(scene, key, place, start, grid);
    putPanelTitle(scene, key, place, method, result, [s, m], data.runs);
    putSquares(scene, key, place, cell, result.table[s][m], data.runs);
    putPanelFrame(scene, key, place, grid, result.here[s][m] === result.best);
    putPanelAxes(scene, key, place, grid, cell, data);
    const x = place.x + (state.noise + 0.5) * cell[0];
    const y = place.y + grid.up - (state.claim + 0.5) * cell[1];
    if (s || m) scene.put("words", `${key}-point`, "circle", { class: "rs-ring is-ink", cx: x, cy: y, r: 6 });
    else putPoint(scene, { x, y }, place, grid, cell, state, data, change);
  }));
}

function putStartName(scene, key, { x, y }, start, { wide }) {
  const at = { class: "rs-head", x, y: y - TITLE - (wide ? 7 : 10) };
  scene.put("words", `${key}-start`, "text", at, wide ? `Start: ${start}` : `From ${start}`);
}

function putPanelTitle(scene, key, { x, y }, method, { here, best }, [s, m], runs) {
  const count = here[s][m];
  const look = count === best ? "rs-head" : "";
  const text = `${method}: ${count} of ${runs}${count === best && best > 0 ? " ★" : ""}`;
  scene.put("words", `${key}-title`, "text", { class: look, x, y: y - 6 }, text);
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

function putPanelFrame(scene, key, { x, y }, { across, up }, isBest) {
  scene.put("frames", `${key}-frame`, "path", {
    class: isBest ? "is-ink" : "is-grid", "stroke-width": isBest ? 2.5 : 1,
    d: `M${x} ${y}h${across}v${up}h${-across}Z`,
  });
}

function putPanelAxes(scene, key, { x, y, isLeft, isLow }, { across, up, wide }, cell, { noises, claims }) {
  if (isLeft) {
    claims.forEach((claim, k) => {
      const at = { class: "rs-tick", x: x - 5, y: y + up - (k + 0.5) * cell[1] + 4, "text-anchor": "end" };
      scene.put("words", `${key}-y-${k}`, "text", at, claimText(claim));
    });
    const [cx, cy] = [12, y + up / 2];
    const turned = { class: "rs-label", x: cx, y: cy, "text-anchor": "middle", transform: `rotate(-90 ${cx} ${cy})` };
    scene.put("words", `${key}-yl`, "text", turned, "claimed / true σ");
  }
  if (!isLow) return;
  noises.forEach((noise, k) => {
    const at = { class: "rs-tick", x: x + (k + 0.5) * cell[0], y: y + up + 15, "text-anchor": "middle" };
    scene.put("words", `${key}-x-${k}`, "text", at, numberText(100 * noise));
  });
  const below = { class: "rs-label", x: x + across / 2, y: y + up + 32, "text-anchor": "middle" };
  scene.put("words", `${key}-xl`, "text", below, wide ? "noise (0.01 rad a step)" : "noise (0.01 rad)");
}

function putPoint(scene, { x, y }, place, { up }, [wide, tall], state, { noises, claims }, change) {
  const clamp = (value, values) => Math.min(values.length - 1, Math.max(0, value));
  const move = (noise, claim) => change({ noise: clamp(noise, noises), claim: clamp(claim, claims) });
  putHandle(scene, "point", {
    x, y, label: "Odometry noise and claimed σ",
    text: `noise ${noises[state.noise]} rad a step, claimed σ ${claimText(claims[state.claim])} times the true one`,
    now: state.noise + noises.length * state.claim, least: 0, most: noises.length * claims.length - 1,
    drag: (px, py) => move(Math.floor((px - place.x) / wide), Math.floor((place.y + up - py) / tall)),
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
