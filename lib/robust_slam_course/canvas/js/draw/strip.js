import { numberText } from "./axes.js";
import { sideBySide } from "./stage.js";

const [LEFT, TOP, BOTTOM, RIGHT, APART, WIDEST] = [46, 28, 40, 4, 14, 34];
const [LINE, LETTER] = [15, 8.5]; // pixels of a row of names, and of a letter

/**
 * A strip of bars over a logarithmic or, with `axis.linear`, a linear axis, in the box `{x, y, width, height}` (pixels). Each of
 * `groups` is `{name, share, bars}`: the share of the width that it takes, and its bars
 * `{value, look?, style?, name?, text?, part?}`, with `text` above a bar and `name` below it;
 * `part` is the key of the edge that it measures. `axis` is
 * `{domain: [low, high], ticks, label, line?: {value, text}, linear?, dots?}`. A value at or below `low`
 * has no bar; with `axis.dots`, as on an axis without a zero, it is a dot, at `low` at least. Returns `toY` from a value to pixels.
 */
export function putStrip(scene, layer, key, box, groups, axis) {
  const top = TOP + (groups.some(({ bars }) => bars.some(({ text }) => text)) ? LINE : 0);
  const inner = { x: box.x + LEFT, y: box.y + top, width: box.width - LEFT - RIGHT, title: box.y + 15 };
  const parts = sideBySide(inner, groups.map(({ share }) => share), APART);
  // Names that are wider than their bars take turns in two rows.
  const rows = groups.some(({ bars }, k) => bars.some(
    ({ name = "" }) => LETTER * name.length > parts[k].width / bars.length,
  )) ? 2 : 1;
  inner.height = box.height - top - BOTTOM - LINE * (rows - 1);
  const toY = stripScale(inner, axis);
  putStripAxis(scene, layer, key, inner, toY, axis);
  groups.forEach((group, k) => {
    const part = { ...parts[k], y: inner.y, height: inner.height };
    putGroup(scene, layer, `${key}-${k}`, part, toY, group, rows, axis.dots);
  });
  return toY;
}

/** From a value to pixels over the height of `inner`. */
function stripScale(inner, { domain: [low, high], linear }) {
  const floor = inner.y + inner.height;
  const share = linear
    ? (value) => (value - low) / (high - low)
    : (value) => Math.log(value / low) / Math.log(high / low);
  return (value) => floor - inner.height * Math.min(1, Math.max(0, share(Math.max(value, low))));
}

function putStripAxis(scene, layer, key, inner, toY, { ticks, label, line }) {
  for (const value of ticks) {
    const y = toY(value);
    scene.path(layer, `${key}-y-${value}`, "rs-grid", `M${inner.x} ${y}h${inner.width}`);
    scene.text(layer, `${key}-yt-${value}`, inner.x - 6, y + 5, numberText(value), "rs-tick", "end");
  }
  scene.text(layer, `${key}-yl`, inner.x - LEFT + 2, inner.title, label);
  if (!line) return;
  const y = toY(line.value);
  scene.put(layer, `${key}-line`, "path", {
    class: "is-muted", d: `M${inner.x} ${y}h${inner.width}`, "stroke-dasharray": "5 4",
  });
  scene.text(layer, `${key}-line-text`, inner.x + inner.width, inner.title, line.text, "rs-tick", "end");
}

function putGroup(scene, layer, key, inner, toY, { name, bars }, rows, dots) {
  const floor = inner.y + inner.height;
  const slot = Math.min(WIDEST, inner.width / Math.max(bars.length, 1));
  const first = inner.x + 0.5 * (inner.width - slot * bars.length);
  const named = bars.some((bar) => bar.name);
  bars.forEach((bar, number) => {
    const x = first + (number + 0.5) * slot;
    const tall = floor - toY(bar.value);
    if (dots) {
      const d = `M${x.toFixed(1)} ${toY(bar.value).toFixed(1)}h0`;
      scene.put(layer, `${key}-${number}`, "path", { class: "rs-dots", "data-part": bar.part, d, style: bar.style });
    } else if (tall > 0.5) {
      scene.put(layer, `${key}-${number}`, "path", {
        class: bar.look ?? "is-muted", "data-part": bar.part, d: `M${x.toFixed(1)} ${floor}v${(-tall).toFixed(1)}`,
        "stroke-width": ((slot > 8 ? 0.6 : 0.8) * slot).toFixed(1),
        style: `${bar.style ?? ""};stroke-linecap:butt;stroke-dasharray:none`,
      });
    }
    const put = (part, y, words) => scene.text(layer, `${key}-${number}-${part}`, x, y, words, "rs-tick", "middle");
    if (bar.text) put("u", toY(bar.value) - 4, bar.text);
    if (bar.name) put("n", floor + LINE * (1 + (number % rows)), bar.name);
  });
  const below = floor + 3 + LINE * (named ? rows + 1 : 1);
  scene.text(layer, `${key}-name`, inner.x + 0.5 * inner.width, below, name, "", "middle");
}
